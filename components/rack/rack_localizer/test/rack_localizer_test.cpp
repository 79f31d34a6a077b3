// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_localizer/rack_localizer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/rack_localizer/rack_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using pipescout_msgs::msg::RackState;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kPeriod = 0.04;  // s between two images

// Four pipes of different spacing on a beam.
constexpr const char* kRack = R"(row:
  - {name: a, radius: 0.15, length: 10}
  - {name: b, radius: 0.20, length: 10, gap: 0.10}
  - {name: c, radius: 0.17, length: 10, gap: 0.15}
  - {name: d, radius: 0.12, length: 10, gap: 0.20}
supports:
  - {name: beam, lowest_corner: [-0.3, 4.1, -0.2], highest_corner: [2.1, 4.3, 0]}
)";

class RackLocalizerTest : public ::testing::Test {
 protected:
  RackLocalizerTest() {
    std::ofstream(rack_) << kRack;
    harness_.set_time(kStart);
  }

  RackLocalizer& start(std::vector<NamedParameter> parameters = {}) {
    parameters.push_back({"rack", rack_});
    auto& localizer = harness_.make<RackLocalizer>({.name = "localizer", .parameters = parameters});
    const auto result = harness_.bring_up(localizer);
    EXPECT_TRUE(result.success) << result.message;
    return localizer;
  }
  RackLocalizer& start_near_truth(std::vector<NamedParameter> parameters = {}) {
    const Eigen::Vector3d p = truth(0).translation();
    parameters.push_back(
        {"start.position", std::vector<double>{p.x() + 0.01, p.y(), p.z() - 0.01}});
    parameters.push_back({"find_first_pose", false});
    return start(parameters);
  }

  /// A slow flight along the pipes, looking down.
  [[nodiscard]] static SE3 truth(double time) {
    const SO3 down = SO3::about_x(M_PI);
    return {SO3::from_roll_pitch_yaw({0.01 * std::sin(time), 0.01 * std::cos(time), 0.02 * time}) *
                down,
            {0.8 + 0.05 * std::sin(time), 4 + 0.3 * time, 2.6}};
  }

  [[nodiscard]] Image image(double time) {
    Image message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.header.frame_id = "camera_optical";
    message.width = static_cast<std::uint32_t>(camera_.parameters().width);
    message.height = static_cast<std::uint32_t>(camera_.parameters().height);
    message.encoding = "mono8";
    message.step = message.width;
    message.data.resize(std::size_t{message.step} * message.height);
    renderer_.render({.T_camera_rack = truth(time).inverse(),
                      .frame = static_cast<std::uint64_t>(std::llround(time / kPeriod))},
                     message.data);
    return message;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }
  void calibrate() { send(topics::kCameraInfo, to_message(camera_.parameters())); }
  /// So many images from `first` on.
  void fly(int first, int images) {
    for (int i = first; i < first + images; ++i) {
      harness_.set_time(kStart + from_seconds(i * kPeriod));
      send(topics::kCameraImage, image(i * kPeriod));
    }
  }

  testing::TemporaryFolder folder_;
  std::string rack_ = (folder_.path() / "rack.yaml").string();
  ComponentHarness harness_{{.simulated_time = true}};
  geometry::Camera camera_;
  simulation::RackImageRenderer renderer_{
      simulation::RackScene{.model = (std::ofstream(rack_) << kRack).flush()
                                         ? read_rack(rack_)
                                         : rack_vision::RackModel{},
                            .seed = 2},
      camera_};
  testing::Collector<geometry_msgs::msg::PoseWithCovarianceStamped> poses_ =
      harness_.collect(topics::kRackPose);
  testing::Collector<pipescout_msgs::msg::RackState> states_ = harness_.collect(topics::kRackState);
};

TEST_F(RackLocalizerTest, FollowsTheCamera) {
  start_near_truth();
  calibrate();
  fly(0, 25);
  ASSERT_GE(poses_.size(), 23U);
  const SE3 pose = from_message(poses_.back().pose.pose);
  const SE3 expected = truth(24 * kPeriod);
  // Along the pipes it started where it was told.
  EXPECT_NEAR(pose.translation().x(), expected.translation().x(), 0.01);
  EXPECT_NEAR(pose.translation().y(), expected.translation().y(), 0.05);
  EXPECT_NEAR(pose.translation().z(), expected.translation().z(), 0.01);
  EXPECT_LT((pose.rotation().inverse() * expected.rotation()).log().norm(), 0.005);
  EXPECT_EQ(poses_.back().header.frame_id, "rack");
  EXPECT_EQ(poses_.back().header.stamp, to_message(kStart + from_seconds(24 * kPeriod)));
  EXPECT_NO_THROW((void)covariance_from_message(poses_.back().pose.covariance));
  EXPECT_EQ(states_.back().status, RackState::STATUS_TRACKING);
  EXPECT_THAT(states_.back().pipe, ::testing::ElementsAre("a", "b", "c", "d"));
  EXPECT_GT(states_.back().edge_samples_found, 50U);
}

TEST_F(RackLocalizerTest, TellsTheIntrinsicsThatItEstimates) {
  auto& localizer = start_near_truth({{"estimate_intrinsics", true}});
  calibrate();
  fly(0, 30);
  const auto values = localizer.diagnostics().take().values;
  for (const char* name : {"camera.focal_length", "camera.centre_u", "camera.centre_v"}) {
    ASSERT_TRUE(values.contains(name)) << name;
    EXPECT_THAT(values.at(name), ::testing::MatchesRegex("[0-9]+.[0-9]+ .- [0-9]+.[0-9]+ px"));
  }
  EXPECT_NEAR(std::stod(values.at("camera.focal_length")), 630, 10);
}

TEST_F(RackLocalizerTest, CountsImagesWithoutACalibration) {
  auto& localizer = start_near_truth();
  fly(0, 2);
  EXPECT_TRUE(poses_.empty());
  EXPECT_EQ(localizer.diagnostics().counter("camera_info.missing"), 2U);
}

TEST_F(RackLocalizerTest, RefusesACalibrationThatIsNone) {
  auto& localizer = start_near_truth();
  auto info = to_message(camera_.parameters());
  info.k[0] = kNan;
  send(topics::kCameraInfo, info);
  EXPECT_EQ(localizer.diagnostics().counter("camera_info.refused"), 1U);
  calibrate();
  fly(0, 3);
  EXPECT_FALSE(poses_.empty());
}

TEST_F(RackLocalizerTest, RefusesImagesThatItCannotUse) {
  auto& localizer = start_near_truth();
  calibrate();
  fly(0, 3);
  const std::size_t poses = poses_.size();
  Image wrong = image(3 * kPeriod);
  wrong.encoding = "yuv422";
  harness_.set_time(kStart + from_seconds(3 * kPeriod));
  send(topics::kCameraImage, wrong);
  EXPECT_EQ(localizer.diagnostics().counter("image.refused"), 1U);
  wrong = image(3 * kPeriod);
  wrong.height = wrong.height - 2;
  send(topics::kCameraImage, wrong);
  EXPECT_EQ(localizer.diagnostics().counter("image.unusable"), 1U);
  Image black = image(3 * kPeriod);
  std::fill(black.data.begin(), black.data.end(), std::uint8_t{0});
  send(topics::kCameraImage, black);
  EXPECT_EQ(localizer.diagnostics().counter("image.unusable"), 2U);
  EXPECT_EQ(states_.back().status, RackState::STATUS_BAD_IMAGE);
  EXPECT_EQ(poses_.size(), poses);
  fly(4, 2);
  EXPECT_EQ(poses_.size(), poses + 2);
}

TEST_F(RackLocalizerTest, RefusesImagesFromOtherTimes) {
  auto& localizer = start_near_truth();
  calibrate();
  fly(0, 3);
  const std::size_t poses = poses_.size();
  send(topics::kCameraImage, image(3.0));  // the clock shows 0.08 s
  EXPECT_EQ(localizer.diagnostics().counter("image.header.stamp.in_future"), 1U);
  send(topics::kCameraImage, image(1 * kPeriod));
  EXPECT_EQ(localizer.diagnostics().counter("image.header.stamp.not_increasing"), 1U);
  EXPECT_EQ(poses_.size(), poses);
  harness_.set_time(kStart + from_seconds(10));
  send(topics::kCameraImage, image(3 * kPeriod));
  EXPECT_EQ(localizer.diagnostics().counter("image.header.stamp.stale"), 1U);
  EXPECT_EQ(poses_.size(), poses);
}

TEST_F(RackLocalizerTest, StartsFromAPoseOnATopic) {
  auto& localizer = start({{"find_first_pose", false}});
  calibrate();
  fly(0, 2);
  EXPECT_TRUE(poses_.empty());
  EXPECT_EQ(states_.back().status, RackState::STATUS_NOT_STARTED);
  EXPECT_FALSE(states_.back().reason.empty());

  geometry_msgs::msg::PoseWithCovarianceStamped hint;
  hint.header.stamp = to_message(kStart + from_seconds(kPeriod));
  hint.header.frame_id = "rack";
  hint.pose.pose = to_message(truth(2 * kPeriod));
  geometry::Matrix6d covariance = geometry::Matrix6d::Identity() * 1e-3;
  hint.pose.covariance = to_message(covariance);
  hint.pose.pose.position.x = kNan;
  send(topics::kRackPoseHint, hint);
  EXPECT_EQ(localizer.diagnostics().counter("pose_hint.refused"), 1U);
  hint.pose.pose = to_message(truth(2 * kPeriod));
  hint.header.frame_id = "map";
  send(topics::kRackPoseHint, hint);
  EXPECT_EQ(localizer.diagnostics().counter("pose_hint.header.frame_id"), 1U);
  hint.header.frame_id = "rack";
  send(topics::kRackPoseHint, hint);
  fly(2, 3);
  EXPECT_FALSE(poses_.empty());
}

TEST_F(RackLocalizerTest, StartsWhereItWasToldToBeTiltedAsATopicSays) {
  const Eigen::Vector3d p = truth(2 * kPeriod).translation();
  start({{"find_first_pose", false},
         {"start.position", std::vector<double>{p.x(), p.y(), p.z()}},
         {"start.roll_pitch_yaw", std::vector<double>{M_PI - 0.25, 0.2, 0.0}},
         {"start.rotation_deviation", 0.02},
         {"start.drift", 0.01}});
  calibrate();
  fly(0, 2);
  EXPECT_TRUE(poses_.empty());

  geometry_msgs::msg::PoseWithCovarianceStamped tilt;
  tilt.header.stamp = to_message(kStart + from_seconds(kPeriod));
  tilt.header.frame_id = "rack";
  tilt.pose.pose = to_message(SE3(truth(2 * kPeriod).rotation(), {0, 0, 0}));
  geometry::Matrix6d covariance = geometry::Matrix6d::Identity() * 1e8;
  covariance(3, 3) = covariance(4, 4) = 1e-4;
  covariance(5, 5) = 10;
  tilt.pose.covariance = to_message(covariance);
  send(topics::kRackPoseHint, tilt);
  fly(2, 8);
  EXPECT_FALSE(poses_.empty());
}

TEST_F(RackLocalizerTest, FindsItselfInTheImage) {
  const Eigen::Vector3d p = truth(0).translation();
  start({{"hint.position", std::vector<double>{p.x() + 0.3, p.y(), p.z() - 0.4}},
         {"hint.position_deviation", std::vector<double>{1.0, 0.1, 1.0}},
         {"hint.heading", std::vector<double>{0.1, 0.3}}});
  calibrate();
  constexpr int kImages = 16;  // several attempts
  fly(0, kImages);
  ASSERT_FALSE(poses_.empty());
  const SE3 pose = from_message(poses_.back().pose.pose);
  EXPECT_NEAR(pose.translation().x(), truth((kImages - 1) * kPeriod).translation().x(), 0.02);
  EXPECT_NEAR(pose.translation().z(), truth((kImages - 1) * kPeriod).translation().z(), 0.02);
}

TEST_F(RackLocalizerTest, SaysWhatIsWrongWithItsParameters) {
  auto& without = harness_.make<RackLocalizer>({.name = "without"});
  EXPECT_THAT(harness_.bring_up(without).message, HasSubstr("'rack'"));
  auto& missing =
      harness_.make<RackLocalizer>({.name = "missing", .parameters = {{"rack", "no_such.yaml"}}});
  EXPECT_THAT(harness_.bring_up(missing).message, HasSubstr("no_such.yaml"));
  auto& position = harness_.make<RackLocalizer>(
      {.name = "position",
       .parameters = {{"rack", rack_}, {"start.position", std::vector<double>{1.0, 2.0}}}});
  EXPECT_THAT(harness_.bring_up(position).message, HasSubstr("start.position"));
}

}  // namespace
}  // namespace pipescout
