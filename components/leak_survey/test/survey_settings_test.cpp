// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pipescout/leak_survey/survey_poses.hpp"
#include "pipescout/odometer_replay/csv_table.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

SurveySettings parse(const std::string& text) {
  return parse_survey_settings(text, "survey.yaml");
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

TEST(SurveySettings, ErrorsNameFileAndLine) {
  const auto throws = [](const char* begin) {
    return ThrowsMessage<std::runtime_error>(StartsWith(begin));
  };
  const auto parsing = [](const char* text) { return [text] { (void)parse(text); }; };
  EXPECT_THAT(parsing("\npreset: cold"), throws("survey.yaml:2: 'cold' is none of collectors"));
  EXPECT_THAT(parsing("field_of_view: 0"), throws("survey.yaml:1: 0"));
  EXPECT_THAT(parsing("camera_position: [1, 2]"), throws("survey.yaml:1: needs three numbers"));
  EXPECT_THAT(parsing("range: {source: far}"), throws("survey.yaml:1: 'far' is none of none"));
  EXPECT_THAT(parsing("range: {source: lines}"), throws("survey.yaml:1: lines"));
  EXPECT_THAT(parsing("range: {distance: -1}"), throws("survey.yaml:1: distance"));
  EXPECT_THAT(parsing("lines: [[1, 2]]"), throws("survey.yaml:1: needs three numbers"));
  EXPECT_THAT(parsing("lines: [[1]]"), throws("survey.yaml:1: a line needs two points"));
  EXPECT_THAT(parsing("datum: {latitude: 100}"), throws("survey.yaml:1: latitude"));
  EXPECT_THAT(parsing("whether: rain"), throws("survey.yaml:1: unknown name 'whether'"));
}

const std::string kHeader = "file,time,x,y,z,qx,qy,qz,qw,x_deviation\n";

TEST(SurveyPoses, AreByFile) {
  const auto poses = parse_survey_poses(kHeader + "a.png,5,1,2,3,0,0,0,1,0.5\n", "p.csv", {});
  ASSERT_EQ(poses.size(), 1U);
  const PicturePose& pose = poses.at("a.png");
  EXPECT_DOUBLE_EQ(pose.time.value_or(0), 5);
  EXPECT_EQ(pose.pose.T_map_base.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(pose.pose.covariance(0, 0), 0.25);
  EXPECT_NEAR(pose.pose.covariance(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(pose.pose.covariance(5, 5), 0.0004, 1e-12);
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
