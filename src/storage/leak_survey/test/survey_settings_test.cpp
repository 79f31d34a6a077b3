// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>

#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/leak_survey/survey_poses.hpp"
#include "threshold_reader.hpp"

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

SurveySettings parse(const std::string& text) {
  return parse_survey_settings(text, "survey.yaml", test::read_threshold);
}

TEST(SurveySettings, TakesAll) {
  const SurveySettings s = parse(R"(
preset: hot_pipes
field_of_view: 90
camera_position: [0.3, 0, 1.2]
camera_roll_pitch_yaw: [-90, 0, -90]
range: {source: distance, distance: 12, distance_deviation: 0.5}
pose_deviation: {position: 0.1, orientation: 180}
frame_rate: 30
datum: {latitude: 36.66, longitude: -5.8, altitude: 60}
weather: clear night
calibration: black body
)");
  EXPECT_EQ(s.preset, thermal::DetectorPreset::kHotPipes);
  EXPECT_NEAR(s.field_of_view.value_or(0), M_PI / 2, 1e-12);
  // Looks forward: z of the camera is x of the robot.
  const Eigen::Vector3d ahead = s.findings.T_base_camera * Eigen::Vector3d(0, 0, 1);
  EXPECT_LT((ahead - Eigen::Vector3d(1.3, 0, 1.2)).norm(), 1e-9);
  EXPECT_EQ(s.findings.range_source, leak_findings::RangeSource::kDistance);
  EXPECT_DOUBLE_EQ(s.findings.distance, 12);
  EXPECT_DOUBLE_EQ(s.position_deviation, 0.1);
  EXPECT_NEAR(s.orientation_deviation, M_PI, 1e-12);
  EXPECT_DOUBLE_EQ(s.frame_rate, 30);
  ASSERT_TRUE(s.datum.has_value());
  EXPECT_DOUBLE_EQ(s.datum->longitude, -5.8);
  EXPECT_EQ(s.weather, "clear night");
  EXPECT_EQ(
      parse("range: {source: lines}\nlines: [[[0, 8, 2], [150, 8, 2]]]").findings.lines.size(), 1U);
}

TEST(SurveySettings, MayBeEmpty) {
  const SurveySettings s = parse("");
  EXPECT_EQ(s.preset, thermal::DetectorPreset::kCollectors);
  EXPECT_FALSE(s.field_of_view.has_value());
  const Eigen::Vector3d down = s.findings.T_base_camera * Eigen::Vector3d(0, 0, 1);
  EXPECT_LT((down - Eigen::Vector3d(0, 0, -1)).norm(), 1e-9);
}

TEST(SurveySettings, ParametersGoOnTopOfThePreset) {
  const SurveySettings s = parse(R"(
parameters: {threshold: 90.0}
range: {source: diameter, pipe_diameter: 0.3}
preset: hot_pipes
)");
  EXPECT_EQ(s.detector.threshold, 90);
  EXPECT_EQ(s.detector.threshold_rule,
            thermal::LeakDetectorParameters::of(thermal::DetectorPreset::kHotPipes).threshold_rule);
  EXPECT_EQ(s.detector.pipe_diameter, 0.3);
  EXPECT_EQ(s.parameters, "{threshold: 90.0}");
  EXPECT_EQ(parse_survey_settings("preset: hot_pipes", "s", test::read_threshold,
                                  thermal::DetectorPreset::kTorresol)
                .detector.profile.leak_delta,
            thermal::LeakDetectorParameters::torresol().profile.leak_delta);
}

TEST(SurveySettings, TheCameraMayBeTold) {
  const SurveySettings s =
      parse("camera: {width: 320, height: 240, focal_length: 700, centre_u: 160, centre_v: 119}");
  ASSERT_TRUE(s.camera.has_value());
  EXPECT_EQ(s.camera->focal_length, 700);
  EXPECT_EQ(s.camera->aspect_ratio, 1);
}

TEST(SurveySettings, AreReadBackAsTheyWere) {
  EXPECT_TRUE(rc::check([](std::array<std::uint32_t, 12> bits, bool camera, bool lines,
                           bool datum) {
    const auto share = [&bits](std::size_t i) { return bits[i] / 4294967296.0; };
    SurveySettings s;
    s.preset = thermal::kDetectorPresets[bits[0] % 4];
    if (camera) {
      s.camera = geometry::CameraParameters{};
      s.camera->focal_length = 300 + share(1);
      s.camera->centre_u = 360 + share(2);
    } else {
      s.field_of_view = 0.1 + share(3);
    }
    s.position_deviation = 0.01 + share(4);
    s.frame_rate = 1 + share(5);
    s.findings.distance = 1 + share(6);
    s.findings.width_deviation = 0.01 + 0.9 * share(7);
    if (lines) {
      s.findings.range_source = leak_findings::RangeSource::kLine;
      s.findings.lines = {{{share(0), share(1), -share(2)}, {9 + share(3), 0, 1e-9 * share(4)}}};
    }
    if (datum) {
      s.datum = {.latitude = 80 * share(8), .longitude = -170 * share(9), .altitude = share(10)};
    }
    s.weather = "clear: \"night\", # 14 degC\nwind";
    s.parameters = "{threshold: " + std::to_string(bits[11] % 100) + ".5}";
    const SurveySettings r = parse(to_yaml(s));
    RC_ASSERT(r.preset == s.preset);
    RC_ASSERT(r.camera.has_value() == camera);
    if (camera) {
      RC_ASSERT(r.camera->focal_length == s.camera->focal_length);
      RC_ASSERT(r.camera->centre_u == s.camera->centre_u);
      RC_ASSERT(r.camera->width == s.camera->width);
    } else {
      RC_ASSERT(std::abs(*r.field_of_view - *s.field_of_view) < 1e-14);
    }
    RC_ASSERT(r.position_deviation == s.position_deviation);
    RC_ASSERT(r.frame_rate == s.frame_rate);
    RC_ASSERT(r.findings.range_source == s.findings.range_source);
    RC_ASSERT(r.findings.distance == s.findings.distance);
    RC_ASSERT(r.findings.width_deviation == s.findings.width_deviation);
    RC_ASSERT(r.findings.lines.size() == s.findings.lines.size());
    for (std::size_t i = 0; i < s.findings.lines.size(); ++i) {
      RC_ASSERT(r.findings.lines[i].from == s.findings.lines[i].from);
      RC_ASSERT(r.findings.lines[i].to == s.findings.lines[i].to);
    }
    RC_ASSERT(r.datum.has_value() == datum);
    if (datum) {
      RC_ASSERT(r.datum->latitude == s.datum->latitude);
      RC_ASSERT(r.datum->altitude == s.datum->altitude);
    }
    RC_ASSERT(r.weather == s.weather);
    RC_ASSERT(r.parameters == s.parameters);
    RC_ASSERT(r.detector.threshold == bits[11] % 100 + 0.5);
  }));
}

TEST(SurveySettings, ErrorsNameFileAndLine) {
  const auto throws = [](const char* begin) {
    return ThrowsMessage<std::runtime_error>(StartsWith(begin));
  };
  const auto parsing = [](const char* text) { return [text] { (void)parse(text); }; };
  EXPECT_THAT(parsing("\npreset: cold"), throws("survey.yaml:2: 'cold' is not one of collectors"));
  EXPECT_THAT(parsing("field_of_view: 0"), throws("survey.yaml:1: 0"));
  EXPECT_THAT(parsing("camera_position: [1, 2]"), throws("survey.yaml:1: needs three numbers"));
  EXPECT_THAT(parsing("range: {source: far}"), throws("survey.yaml:1: 'far' is not one of none"));
  EXPECT_THAT(parsing("range: {source: lines}"), throws("survey.yaml:1: lines"));
  EXPECT_THAT(parsing("range: {distance: -1}"), throws("survey.yaml:1: distance"));
  EXPECT_THAT(parsing("lines: [[1, 2]]"), throws("survey.yaml:1: needs three numbers"));
  EXPECT_THAT(parsing("lines: [[1]]"), throws("survey.yaml:1: a line needs two points"));
  EXPECT_THAT(parsing("datum: {latitude: 100}"), throws("survey.yaml:1: latitude"));
  EXPECT_THAT(parsing("camera: {width: 320, height: 240, focal_length: 700}"),
              throws("survey.yaml:1: CameraParameters.centre_u"));
  EXPECT_THAT(parsing("camera: {width: 320}"), throws("survey.yaml:1: CameraParameters.height"));
  EXPECT_THAT(parsing("field_of_view: 20\ncamera: {width: 320, height: 240, focal_length: 700, "
                      "centre_u: 160, centre_v: 119}"),
              throws("survey.yaml:1: field_of_view and camera"));
  EXPECT_THAT(parsing("\nparameters: {threshhold: 90.0}"), throws("survey.yaml:2: only threshold"));
  EXPECT_THAT(parsing("\nparameters: {threshold: .nan}"), throws("survey.yaml:2: "));
  EXPECT_THAT(parsing("whether: rain"), throws("survey.yaml:1: unknown name 'whether'"));
}

const std::string kHeader = "file,time,x,y,z,qx,qy,qz,qw,x_deviation\n";

TEST(SurveyPoses, AreByFile) {
  const SurveyPoses poses =
      parse_survey_poses(kHeader + "a.png,5,1,2,3,0,0,0,1,0.5\nb.png,6,,,,,,,,\n", "p.csv", {});
  ASSERT_EQ(poses.by_file.size(), 2U);
  EXPECT_THAT(poses.notes, IsEmpty());
  const PicturePose& entry = poses.by_file.at("a.png");
  EXPECT_DOUBLE_EQ(entry.time.value_or(0), 5);
  ASSERT_TRUE(entry.pose.has_value());
  EXPECT_EQ(entry.pose->T_map_base.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(entry.pose->covariance(0, 0), 0.25);
  EXPECT_NEAR(entry.pose->covariance(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(entry.pose->covariance(5, 5), 0.0004, 1e-12);
  EXPECT_FALSE(poses.by_file.at("b.png").pose.has_value());
  EXPECT_EQ(poses.by_file.at("b.png").time, 6);
}

TEST(SurveyPoses, ALineThatIsCutShortTakesNothingElseWithIt) {
  PicturePose told{.time = 12.25, .pose = leak_findings::FramePose{}};
  told.pose->covariance = geometry::Matrix6d::Identity();
  const std::string before = survey_pose_header() + "\n" + survey_pose_line("1.tiff", told) + "\n";
  const std::string line = survey_pose_line("2.tiff", told);
  EXPECT_EQ(parse_survey_poses(before + line, "p.csv", {}).by_file.size(), 2U) << "all but its end";
  const std::size_t name = line.rfind(',') + 1;
  for (std::size_t length = 1; length < line.size(); ++length) {
    const SurveyPoses poses = parse_survey_poses(before + line.substr(0, length), "p.csv", {});
    EXPECT_TRUE(poses.by_file.contains("1.tiff"));
    EXPECT_FALSE(poses.by_file.contains("2.tiff")) << length;
    if (length < name) {
      EXPECT_THAT(poses.notes, ElementsAre("p.csv:3: the last line is truncated: ignored"));
    }
  }
}

TEST(SurveyPoses, AreReadBackAsTheyWere) {
  EXPECT_TRUE(rc::check([](std::array<std::int32_t, 13> bits) {
    const auto share = [&bits](std::size_t i) { return bits[i] / 2147483648.0; };
    PicturePose told{.time = 1.7e9 + share(12), .pose = leak_findings::FramePose{}};
    told.pose->T_map_base = geometry::SE3(geometry::SO3::exp({share(0), share(1), share(2)}),
                                          Eigen::Vector3d(1e3 * share(3), share(4), share(5)));
    for (Eigen::Index k = 0; k < 6; ++k) {
      const double deviation = 1e-3 + std::abs(share(6 + static_cast<std::size_t>(k)));
      told.pose->covariance(k, k) = deviation * deviation;
    }
    const SurveyPoses poses = parse_survey_poses(
        survey_pose_header() + "\n" + survey_pose_line("a.tiff", told) + "\n", "p.csv", {});
    const PicturePose& read = poses.by_file.at("a.tiff");
    RC_ASSERT(read.time == told.time);
    RC_ASSERT(read.pose->T_map_base.translation() == told.pose->T_map_base.translation());
    RC_ASSERT((read.pose->T_map_base.inverse() * told.pose->T_map_base).log().norm() < 1e-14);
    RC_ASSERT((read.pose->covariance - told.pose->covariance).cwiseAbs().maxCoeff() < 1e-15);
  }));
}

TEST(SurveyPoses, ErrorsNameFileAndLine) {
  const auto parsing = [](const std::string& text) {
    return [text] { (void)parse_survey_poses(text, "p.csv", {}); };
  };
  const auto throws = [](const char* begin) { return ThrowsMessage<CsvError>(StartsWith(begin)); };
  const std::string header = kHeader;
  EXPECT_THAT(parsing("file,x\na,1\n"), throws("p.csv:1: there is no column 'y'"));
  EXPECT_THAT(parsing(header + "a,5,1,2,3,0,0,0,2,1\n"), throws("p.csv:2: "));
  EXPECT_THAT(parsing(header + "a,5,1,2,nan,0,0,0,1,1\n"), throws("p.csv:2: column 'z'"));
  EXPECT_THAT(parsing(header + "a,5,1,2,3,0,0,0,1,0\n"), throws("p.csv:2: column 'x_deviation'"));
  EXPECT_THAT(parsing(header + "a,5,1,2,3,0,0,0,1,1\na,6,1,2,3,0,0,0,1,1\n"),
              throws("p.csv:3: column 'file'"));
}

}  // namespace
}  // namespace pipescout
