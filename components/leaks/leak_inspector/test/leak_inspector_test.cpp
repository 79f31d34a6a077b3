// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/leak_inspector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/leak_store/leak_store.hpp"
#include "pipescout/leak_survey/leak_survey.hpp"
#include "pipescout/leak_survey/picture_recording.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/simulation/thermal_camera.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"
#include "pipescout/testing/component_harness.hpp"
#include "pipescout/thermal_parameters/survey_parameters.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using pipescout_msgs::msg::LeakDetections;
using pipescout_msgs::msg::LeakEvent;
using sensor_msgs::msg::Image;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kPeriod = 0.04;  // s
constexpr double kSpeed = 5.5;    // m/s
constexpr double kDistance = 10;  // m, from the tube
constexpr double kElevation = 0.145;
constexpr double kLeak = 20;  // m, along the tube
const Eigen::Vector3d kCamera(0.2, 0.2, 1.2);

simulation::ThermalSceneParameters leaking_row() {
  simulation::ThermalSceneParameters scene;
  scene.length = 60;
  scene.leaks = {{.place = kLeak, .length = 0.8, .rise = 110}};
  return scene;
}

SE3 robot_at(double place) {
  return {SO3(), {place, -kDistance, 0}};
}

class LeakInspectorTest : public ::testing::Test {
 protected:
  LeakInspectorTest() { harness_.set_time(kStart); }

  LeakInspector& start(const std::vector<NamedParameter>& more = {}) {
    const SE3 mounting = simulation::T_body_side_camera(kCamera, kElevation);
    const auto planck = simulation::simulated_thermal_constants().planck;
    const Eigen::Vector3d angles = mounting.rotation().roll_pitch_yaw();
    std::vector<NamedParameter> parameters{
        {"camera.planck", std::vector<double>{planck.r1, planck.r2, planck.b, planck.f, planck.o}},
        {"camera.position", std::vector<double>{kCamera.x(), kCamera.y(), kCamera.z()}},
        {"camera.roll_pitch_yaw", std::vector<double>{angles.x(), angles.y(), angles.z()}},
        {"range.source", "lines"},
        {"range.lines", std::vector<double>{0, 0, 3, 60, 0, 3}}};
    for (const NamedParameter& parameter : more) {
      std::erase_if(parameters, [&](const auto& known) { return known.name == parameter.name; });
      parameters.push_back(parameter);
    }
    auto& inspector = harness_.make<LeakInspector>({.name = "inspector", .parameters = parameters});
    const auto result = harness_.bring_up(inspector);
    EXPECT_TRUE(result.success) << result.message;
    return inspector;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  void send_calibration() { send(topics::kThermalCameraInfo, to_message(camera_.camera)); }

  [[nodiscard]] Image picture(double place) {
    counts_.resize(static_cast<std::size_t>(camera_.camera.width * camera_.camera.height));
    renderer_.render(
        {.T_map_camera = robot_at(place) * simulation::T_body_side_camera(kCamera, kElevation),
         .frame = frame_++},
        counts_);
    Image message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "thermal_optical";
    message.width = static_cast<std::uint32_t>(camera_.camera.width);
    message.height = static_cast<std::uint32_t>(camera_.camera.height);
    message.step = 2 * message.width;
    message.encoding = "mono16";
    message.data.resize(2 * counts_.size());
    std::memcpy(message.data.data(), counts_.data(), message.data.size());
    return message;
  }

  [[nodiscard]] nav_msgs::msg::Odometry odometry(double place) const {
    nav_msgs::msg::Odometry message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "map";
    message.child_frame_id = "base_link";
    message.pose.pose = to_message(robot_at(place));
    geometry::Matrix6d covariance = geometry::Matrix6d::Identity();
    covariance.topLeftCorner<3, 3>() *= 1e-4;
    covariance.bottomRightCorner<3, 3>() *= 1e-6;
    message.pose.covariance = to_message(covariance);
    message.twist.twist = twist_message({kSpeed, 0, 0}, {0, 0, 0});
    return message;
  }

  void step() {
    now_ += from_seconds(kPeriod);
    harness_.set_time(now_);
  }

  /// Past the tube, from `from` to `to` m along it.
  void drive(double from, double to) {
    for (double place = from; place < to; place += kSpeed * kPeriod) {
      step();
      send(topics::kOdometryFiltered, odometry(place));
      send(topics::kThermalImage, picture(place));
    }
  }

  [[nodiscard]] std::vector<LeakEvent> events(std::uint8_t kind) const {
    std::vector<LeakEvent> result;
    for (const auto& event : events_.messages()) {
      if (event->kind == kind) {
        result.push_back(*event);
      }
    }
    return result;
  }

  [[nodiscard]] std::string counted(const LeakInspector& inspector, const std::string& key) {
    return harness_.value(harness_.next_diagnostics(inspector), key).value_or("none");
  }

  simulation::ThermalCameraParameters camera_ = simulation::ThermalCameraParameters::qvga();
  simulation::ThermalRenderer renderer_{simulation::ThermalScene(leaking_row()), camera_};
  std::vector<std::uint16_t> counts_;
  std::uint64_t frame_ = 0;
  Time now_ = kStart;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<LeakDetections> detections_ = harness_.collect(topics::kLeakDetections);
  testing::Collector<LeakEvent> events_ = harness_.collect(topics::kLeakEvents);
};

TEST_F(LeakInspectorTest, RaisesALeakWhereItIs) {
  start();
  send_calibration();
  drive(10, 32);
  const auto raised = events(LeakEvent::RAISED);
  ASSERT_EQ(raised.size(), 1U);
  const auto& finding = events_.back().finding;
  EXPECT_TRUE(finding.position_known);
  EXPECT_NEAR(finding.position.x, kLeak, 0.2);
  EXPECT_NEAR(finding.position.y, 0, 0.2);
  EXPECT_NEAR(finding.position.z, 3, 0.2);
  EXPECT_NEAR(finding.delta, 110, 25);
  EXPECT_LT(finding.delta_low, finding.delta);
  EXPECT_GT(finding.delta_high, finding.delta);
  EXPECT_NEAR(finding.length, 0.8, 0.3);
  EXPECT_EQ(finding.passes, 1U);
  EXPECT_GT(finding.probability, 0.9);
  EXPECT_EQ(finding.thumbnail.format, "png");
  EXPECT_GT(finding.thumbnail.data.size(), 100U);
  EXPECT_EQ(events_.back().header.frame_id, "map");

  std::size_t detected = 0;
  for (const auto& message : detections_.messages()) {
    EXPECT_EQ(message->fault, "");
    detected += message->leaks.empty() ? 0 : 1;
  }
  EXPECT_GE(detected, 10U);
}

TEST_F(LeakInspectorTest, PicturesAreHeardOnceTheNamedNodeListensToTheDetections) {
  start({{"wait_for_subscribers.detections", std::vector<std::string>{"recorder"}}});
  send_calibration();
  drive(10, 11);
  EXPECT_TRUE(detections_.messages().empty());
  Node recorder({.context = harness_.context().shared_from_this(),
                 .executor = &harness_.executor(),
                 .name = {"/", "recorder"}});
  std::size_t recorded = 0;
  const auto subscription = recorder.create_subscription(
      topics::kLeakDetections, [&](const LeakDetections&) { ++recorded; });
  harness_.spin();
  drive(11, 12);
  EXPECT_FALSE(detections_.messages().empty());
  EXPECT_EQ(recorded, detections_.messages().size());
}

TEST_F(LeakInspectorTest, RaisesItWithinThreePicturesOfSeeingIt) {
  start();
  send_calibration();
  drive(10, 32);
  std::size_t first = 0;
  while (first < detections_.size() && detections_.at(first).leaks.empty()) {
    ++first;
  }
  ASSERT_LT(first + 2, detections_.size());
  const auto raised = events(LeakEvent::RAISED);
  ASSERT_EQ(raised.size(), 1U);
  EXPECT_LE(from_message(raised.front().header.stamp),
            from_message(detections_.at(first + 2).header.stamp));
}

TEST_F(LeakInspectorTest, KnowsALeakAgainOnAnotherDayAndReports) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path store = folder.path() / "site/leaks.db";
  const std::filesystem::path report = folder.path() / "report";
  const std::vector<NamedParameter> kept{{"store", store.string()},
                                         {"report_folder", report.string()},
                                         {"datum", std::vector<double>{36.6, -5.8, 80.0}}};
  auto& first_day = start(kept);
  send_calibration();
  drive(10, 32);
  ASSERT_EQ(events(LeakEvent::RAISED).size(), 1U);
  ASSERT_TRUE(harness_.deactivate(first_day).success);
  harness_.destroy(first_day);

  events_.clear();
  now_ += std::chrono::hours(24);
  start(kept);
  send_calibration();
  drive(10, 32);
  ASSERT_FALSE(events_.empty());
  EXPECT_TRUE(events(LeakEvent::RAISED).empty()) << "it is known";
  EXPECT_EQ(events_.back().finding.id, 1U);
  EXPECT_EQ(events_.back().finding.passes, 2U);

  for (const char* file : {"report.html", "leaks.geojson", "leaks.kml", "leaks.csv"}) {
    EXPECT_GT(std::filesystem::file_size(report / file), 100U) << file;
  }
}

TEST_F(LeakInspectorTest, KeepsPicturesOfWhichASurveyFindsTheSame) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path pictures = folder.path() / kMissionPictures;
  start({{"pictures_folder", pictures.string()},
         {"leak_delta", std::vector<double>{55.0}},
         {"deviations.emissivity", 0.001},
         {"raise_probability", 0.95}});
  drive(9, 10);  // not calibrated yet
  EXPECT_FALSE(std::filesystem::exists(pictures / "00000001.tiff"));
  send_calibration();
  const std::size_t before = detections_.size();
  drive(10, 32);
  const auto& live = events_.back().finding;
  const std::size_t kept = detections_.size() - before;

  LeakSurveyOptions options;
  options.read_parameters = read_survey_parameters;
  options.pictures = folder.path();  // as a mission's
  options.out = folder.path() / "out";
  options.complain = [](const std::string& problem) { ADD_FAILURE() << problem; };
  const LeakSurveyResult result = survey_leaks(options);
  EXPECT_EQ(result.pictures, kept);
  const auto found = LeakStore(options.out / "leaks.sqlite").findings();
  ASSERT_EQ(found.size(), 1U);
  ASSERT_TRUE(found[0].position.has_value());
  const auto& position = found[0].position->point;
  EXPECT_NEAR(position.x(), live.position.x, 0.02);
  EXPECT_NEAR(position.y(), live.position.y, 0.02);
  EXPECT_NEAR(position.z(), live.position.z, 0.02);
  EXPECT_NEAR(found[0].mean_delta, live.delta, 0.5);
  EXPECT_NEAR(found[0].mean_delta_interval.low, live.delta_low, 1.0);
  EXPECT_NEAR(found[0].mean_delta_interval.high, live.delta_high, 1.0);
  EXPECT_NEAR(found[0].length, live.length, 0.05);
}

TEST_F(LeakInspectorTest, PicturesAreKeptInAFolderOfTheirOwn) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "00000001.tiff") << "of yesterday";
  auto& inspector = harness_.make<LeakInspector>(
      {.name = "inspector", .parameters = {{"pictures_folder", folder.path().string()}}});
  const auto result = harness_.configure(inspector);
  EXPECT_FALSE(result.success);
  EXPECT_THAT(result.message, HasSubstr(folder.path().string() + ": is not empty"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "thermal.yaml"));
}

TEST_F(LeakInspectorTest, APictureThatIsNotKeptIsCountedAndTheInspectionGoesOn) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path pictures = folder.path() / "pictures";
  auto& inspector = start({{"pictures_folder", pictures.string()}});
  send_calibration();
  std::filesystem::remove_all(pictures);
  drive(10, 32);
  EXPECT_NE(counted(inspector, "pictures.failed"), "none");
  EXPECT_EQ(events(LeakEvent::RAISED).size(), 1U);
}

TEST_F(LeakInspectorTest, AStoreThatIsNoneIsNamed) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path store = folder.path() / "leaks.db";
  std::ofstream(store) << "This is no database of findings, and it shall stay as it is. ";
  auto& inspector = harness_.make<LeakInspector>(
      {.name = "inspector", .parameters = {{"store", store.string()}}});
  const auto result = harness_.configure(inspector);
  EXPECT_FALSE(result.success);
  EXPECT_THAT(result.message, HasSubstr(store.string()));
}

TEST_F(LeakInspectorTest, WithoutACalibrationLeaksAreDetectedAndHaveNoPlace) {
  auto& inspector = start();
  drive(18, 22);
  EXPECT_TRUE(events_.empty());
  EXPECT_FALSE(detections_.back().pipes.empty());
  EXPECT_NE(counted(inspector, "camera_info.missing"), "none");
}

TEST_F(LeakInspectorTest, ABadPictureIsCountedAndTheNextOneIsFine) {
  auto& inspector = start();
  send_calibration();
  const auto send_bad = [&](const auto& spoil) {
    step();
    send(topics::kOdometryFiltered, odometry(20));
    Image bad = picture(20);
    spoil(bad);
    send(topics::kThermalImage, bad);
  };
  send_bad([](Image& image) { image.encoding = "rgb8"; });
  send_bad([](Image& image) { image.height = 0; });
  send_bad([](Image& image) { image.step = 3; });
  send_bad([](Image& image) { image.data.resize(100); });
  EXPECT_TRUE(detections_.empty());
  EXPECT_EQ(counted(inspector, "image.refused"), "4");
  send_bad([](Image& image) { std::ranges::fill(image.data, std::uint8_t{0xff}); });
  ASSERT_EQ(detections_.size(), 1U);
  EXPECT_EQ(detections_.back().fault, "saturated");
  send_bad([](Image& image) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    image.encoding = "32FC1";
    image.step = 4 * image.width;
    image.data.resize(std::size_t{image.step} * image.height);
    for (std::size_t i = 0; i < image.data.size(); i += sizeof(nan)) {
      std::memcpy(image.data.data() + i, &nan, sizeof(nan));
    }
  });
  EXPECT_EQ(detections_.back().fault, "no_temperature");
  drive(20, 20.3);
  EXPECT_EQ(detections_.back().fault, "");
  EXPECT_FALSE(detections_.back().pipes.empty());
}

TEST_F(LeakInspectorTest, RefusesStampsThatAreNotOfNow) {
  auto& inspector = start();
  send_calibration();
  Image early = picture(20);
  early.header.stamp = to_message(now_ + std::chrono::seconds(5));
  send(topics::kThermalImage, early);
  early.header.stamp = to_message(now_ - std::chrono::seconds(50));
  send(topics::kThermalImage, early);
  EXPECT_TRUE(detections_.empty());
  EXPECT_EQ(counted(inspector, "image.header.stamp.in_future"), "1");
  EXPECT_EQ(counted(inspector, "image.header.stamp.stale"), "1");
}

TEST_F(LeakInspectorTest, PosesOfAnotherFrameAreNotUsed) {
  auto& inspector = start();
  send_calibration();
  for (double place = 10; place < 30; place += kSpeed * kPeriod) {
    step();
    auto pose = odometry(place);
    pose.header.frame_id = "odom";
    send(topics::kOdometryFiltered, pose);
    send(topics::kThermalImage, picture(place));
  }
  for (const auto& event : events_.messages()) {
    EXPECT_FALSE(event->finding.position_known);
  }
  EXPECT_NE(counted(inspector, "odometry.header.frame_id"), "none");
  EXPECT_NE(counted(inspector, "findings.no_pose"), "none");
}

TEST_F(LeakInspectorTest, CountsMeanNothingWithoutACamera) {
  auto& inspector = start({{"camera.planck", std::vector<double>{}}});
  send_calibration();
  drive(20, 20.5);
  EXPECT_TRUE(detections_.empty());
  EXPECT_NE(counted(inspector, "image.counts_without_camera"), "none");
}

TEST_F(LeakInspectorTest, ATurnedOverCalibrationIsRefused) {
  auto& inspector = start();
  auto calibration = to_message(camera_.camera);
  calibration.k[0] = std::numeric_limits<double>::quiet_NaN();
  send(topics::kThermalCameraInfo, calibration);
  drive(20, 20.3);
  EXPECT_EQ(counted(inspector, "camera_info.refused"), "1");
  EXPECT_FALSE(detections_.empty());
}

TEST_F(LeakInspectorTest, ParametersOutOfRangeAreNamed) {
  const auto message = [&](const NamedParameter& parameter) {
    auto& inspector = harness_.make<LeakInspector>(
        {.name = "inspector_" + std::to_string(frame_++), .parameters = {parameter}});
    const auto result = harness_.configure(inspector);
    EXPECT_FALSE(result.success);
    return result.message;
  };
  EXPECT_THAT(message({"camera.planck", std::vector<double>{1, 2}}), HasSubstr("camera.planck"));
  EXPECT_THAT(message({"camera.linear", std::vector<double>{-1, 2}}), HasSubstr("camera.linear"));
  EXPECT_THAT(message({"camera.grey_range", std::vector<double>{300, 100}}),
              HasSubstr("camera.grey_range"));
  EXPECT_THAT(message({"range.lines", std::vector<double>{1, 2, 3}}), HasSubstr("range.lines"));
  EXPECT_THAT(message({"range.source", "diameter"}), HasSubstr("pipe_diameter"));
  EXPECT_THAT(message({"range.source", "radar"}), HasSubstr("'radar' is not one of"));
  EXPECT_THAT(message({"datum", std::vector<double>{91, 0, 0}}), HasSubstr("datum"));
  EXPECT_THAT(message({"leak_delta", std::vector<double>{1, 2}}), HasSubstr("leak_delta"));
  EXPECT_THROW((void)harness_.make<LeakInspector>(
                   {.name = "inspector_of_nothing", .parameters = {{"preset", "dragon"}}}),
               ParameterError);
}

}  // namespace
}  // namespace pipescout
