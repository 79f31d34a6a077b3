// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_tracker/thermal_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/simulation/pipe_view.hpp"
#include "pipescout/simulation/thermal_camera.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using pipescout_msgs::msg::PipeTrack;
using sensor_msgs::msg::Image;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kPeriod = 0.04;  // s
constexpr double kSpeed = 5.5;    // m/s
constexpr double kDistance = 10;  // m, from the tube
const SE3 kMounting = simulation::T_body_side_camera({0.2, 0.2, 1.2}, 0.145);

simulation::ThermalSceneParameters row() {
  simulation::ThermalSceneParameters scene;
  scene.length = 100;
  return scene;
}

/// The robot rolls on rough ground.
SE3 robot_at(double place) {
  return {SO3::from_roll_pitch_yaw({0.03 * std::sin(1.1 * place), 0, 0}), {place, -kDistance, 0}};
}

class ThermalTrackerTest : public ::testing::Test {
 protected:
  ThermalTrackerTest() { harness_.set_time(kStart); }

  ThermalTracker& start(const std::vector<NamedParameter>& more = {}) {
    const auto planck = simulation::simulated_thermal_constants().planck;
    const Eigen::Vector3d angles = kMounting.rotation().roll_pitch_yaw();
    const Eigen::Vector3d place = kMounting.translation();
    std::vector<NamedParameter> parameters{
        {"camera.planck", std::vector<double>{planck.r1, planck.r2, planck.b, planck.f, planck.o}},
        {"camera.position", std::vector<double>{place.x(), place.y(), place.z()}},
        {"camera.roll_pitch_yaw", std::vector<double>{angles.x(), angles.y(), angles.z()}},
        {"range.lines", std::vector<double>{0, 0, 3, 100, 0, 3}}};
    for (const NamedParameter& parameter : more) {
      std::erase_if(parameters, [&](const auto& known) { return known.name == parameter.name; });
      parameters.push_back(parameter);
    }
    auto& tracker = harness_.make<ThermalTracker>({.name = "tracker", .parameters = parameters});
    const auto result = harness_.bring_up(tracker);
    EXPECT_TRUE(result.success) << result.message;
    return tracker;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  void send_calibration() { send(topics::kThermalCameraInfo, to_message(camera_.camera)); }

  [[nodiscard]] Image picture(double place) {
    counts_.resize(static_cast<std::size_t>(camera_.camera.width * camera_.camera.height));
    renderer_.render({.T_map_camera = robot_at(place) * kMounting, .frame = frame_++}, counts_);
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
    covariance.topLeftCorner<3, 3>() *= 1e-3;
    covariance.bottomRightCorner<3, 3>() *= 1e-6;
    message.pose.covariance = to_message(covariance);
    message.twist.twist = twist_message({kSpeed, 0, 0}, {0, 0, 0});
    return message;
  }

  void step() {
    now_ += from_seconds(kPeriod);
    harness_.set_time(now_);
  }

  void drive(double from, double to, bool with_odometry = true) {
    for (double place = from; place < to; place += kSpeed * kPeriod) {
      step();
      if (with_odometry) {
        send(topics::kOdometryFiltered, odometry(place));
      }
      send(topics::kThermalImage, picture(place));
      last_place_ = place;
    }
  }

  /// px, of the middle of the last track from the truth across the pipe.
  [[nodiscard]] double error() const {
    const auto seen = simulation::view_pipe({.from = {0, 0, 3}, .to = {100, 0, 3}},
                                            renderer_.camera(), robot_at(last_place_) * kMounting);
    const Eigen::Vector2d along = (seen->to - seen->from).normalized();
    const Eigen::Vector2d away =
        Eigen::Vector2d(tracks_.back().estimate.u, tracks_.back().estimate.v) - seen->from;
    return std::abs(along.x() * away.y() - along.y() * away.x());
  }

  [[nodiscard]] std::string counted(const ThermalTracker& tracker, const std::string& key) {
    return harness_.value(harness_.next_diagnostics(tracker), key).value_or("none");
  }

  simulation::ThermalCameraParameters camera_ = simulation::ThermalCameraParameters::qvga();
  simulation::ThermalRenderer renderer_{simulation::ThermalScene(row()), camera_};
  std::vector<std::uint16_t> counts_;
  std::uint64_t frame_ = 0;
  double last_place_ = 0;
  Time now_ = kStart;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<PipeTrack> tracks_ = harness_.collect(topics::kPipeTrack);
};

TEST_F(ThermalTrackerTest, FollowsThePipe) {
  start();
  send_calibration();
  const auto particles = harness_.collect(topics::kPipeTrackParticles);
  drive(20, 30);
  ASSERT_GT(tracks_.size(), 40U);
  const PipeTrack& track = tracks_.back();
  EXPECT_EQ(track.state, PipeTrack::STATE_LOCKED);
  EXPECT_EQ(track.track, 1U);
  EXPECT_EQ(track.fault, "");
  EXPECT_GT(track.confidence, 0.9);
  EXPECT_LT(error(), 1.5);
  EXPECT_NEAR(track.range, kDistance, 1);
  EXPECT_TRUE(track.whole_width);
  EXPECT_GT(track.half_width, 1);
  EXPECT_EQ(track.width, 320U);
  EXPECT_GT(track.covariance[5], 0) << "across; along it the borders of the picture tell";
  EXPECT_EQ(track.header.frame_id, "thermal_optical");
  EXPECT_EQ(particles.back().u.size(), 200U);
  EXPECT_FALSE(particles.back().regions.empty());
}

TEST_F(ThermalTrackerTest, PicturesAreHeardOnceTheNamedNodeListensToTheTrack) {
  start({{"wait_for_subscribers", std::vector<std::string>{"arm"}}});
  const auto heard = [this] {
    send_calibration();
    step();
    send(topics::kThermalImage, picture(20));
    return !tracks_.empty();
  };
  EXPECT_FALSE(heard());
  Node arm({.context = harness_.context().shared_from_this(),
            .executor = &harness_.executor(),
            .name = {"/", "arm"}});
  std::size_t heard_by_arm = 0;
  const auto subscription =
      arm.create_subscription(topics::kPipeTrack, [&](const PipeTrack&) { ++heard_by_arm; });
  harness_.spin();
  EXPECT_TRUE(heard());
  EXPECT_EQ(heard_by_arm, 1U);
}

TEST_F(ThermalTrackerTest, FollowsItWithoutOdometryToo) {
  auto& tracker = start();
  send_calibration();
  drive(20, 30, false);
  EXPECT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
  EXPECT_LT(error(), 2);
  EXPECT_EQ(counted(tracker, "odometry.missing"), "none") << "that there is none is no fault";
}

/// Behind a row that is cooler, an upright cylinder of 1.2 x 1.5 m.
class BodyTrackerTest : public ThermalTrackerTest {
 protected:
  BodyTrackerTest() {
    simulation::ThermalSceneParameters scene = row();
    scene.tube_temperature = 60;
    scene.support_width = 0;
    scene.decoys = {{.kind = simulation::ThermalDecoyKind::kHotBody,
                     .place = 40,
                     .size = 1.2,
                     .rise = 100,
                     .behind = 4,
                     .height = 1.5,
                     .foot = 1.5}};
    renderer_ = simulation::ThermalRenderer(simulation::ThermalScene(scene), camera_);
  }

  ThermalTracker& start_of(const std::string& shape, double least_fill) {
    return start({{"shape", shape},
                  {"region.threshold", 110.0},
                  {"region.least_fill", least_fill},
                  {"range.lines", std::vector<double>{}},
                  {"range.distance", 14.6}});
  }
  /// px per metre at the body's axis.
  [[nodiscard]] double scale() const { return camera_.camera.focal_length / 14.6; }
};

TEST_F(BodyTrackerTest, FollowsAVessel) {
  start_of("vessel", 0.75);
  send_calibration();
  const auto particles = harness_.collect(topics::kPipeTrackParticles);
  drive(38, 41.5);
  const PipeTrack& track = tracks_.back();
  EXPECT_EQ(track.state, PipeTrack::STATE_LOCKED);
  EXPECT_EQ(track.track, 1U);
  EXPECT_NEAR(track.estimate.length, 1.5 * scale(), 0.1 * scale());
  EXPECT_NEAR(2 * track.half_width, 1.2 * scale(), 0.1 * scale());
  EXPECT_NEAR(std::cos(track.estimate.angle), 0, 0.15) << "upright";
  EXPECT_TRUE(track.whole_width);
  EXPECT_NEAR(track.range, 14.6, 0.5);
  // Right in the picture is forward.
  const double camera_place = last_place_ + kMounting.translation().x();
  EXPECT_NEAR(track.estimate.u, 160 + (40 - camera_place) * scale(), 0.1 * scale());
  EXPECT_GT(track.covariance[0], 0);
  EXPECT_EQ(particles.back().u.size(), 200U);
  EXPECT_GE(particles.back().regions.size(), 1U);
  drive(48, 50);
  EXPECT_NE(tracks_.back().state, PipeTrack::STATE_LOCKED);
}

TEST_F(BodyTrackerTest, FollowsAValve) {
  start_of("valve", 0.5);
  send_calibration();
  drive(38, 41.5);
  const PipeTrack& track = tracks_.back();
  EXPECT_EQ(track.state, PipeTrack::STATE_LOCKED);
  EXPECT_NEAR(track.half_width, std::sqrt(1.2 * 1.5 / 3.1416) * scale(), 0.1 * scale());
  EXPECT_NEAR(track.estimate.length, 2 * track.half_width, 1e-6);
  EXPECT_EQ(track.estimate.angle, 0);
}

TEST_F(BodyTrackerTest, LevelsOfAutomaticGainAreNotUsed) {
  auto& tracker = start({{"shape", "vessel"}, {"preset", "contrast"}});
  send_calibration();
  step();
  Image grey = picture(40);
  grey.encoding = "mono8";
  grey.step = grey.width;
  send(topics::kThermalImage, grey);
  EXPECT_TRUE(tracks_.empty());
  EXPECT_EQ(counted(tracker, "image.grey_without_range"), "1");
}

TEST_F(BodyTrackerTest, APictureOfTheSameTimeIsNotUsed) {
  auto& tracker = start_of("vessel", 0.75);
  send_calibration();
  drive(39, 40);
  send(topics::kThermalImage, picture(40));
  EXPECT_EQ(tracks_.back().fault, "time_went_back");
  EXPECT_EQ(counted(tracker, "track.time_went_back"), "1");
}

TEST_F(ThermalTrackerTest, CoastsIsLostAndTakesItUpAgain) {
  auto& tracker = start({{"max_coast", 0.5}});
  send_calibration();
  drive(20, 26);
  ASSERT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
  std::vector<std::uint8_t> states_seen;
  for (int i = 0; i < 25; ++i) {
    step();
    Image dark = picture(26);
    std::ranges::fill(dark.data, std::uint8_t{1});
    send(topics::kThermalImage, dark);
    states_seen.push_back(tracks_.back().state);
    EXPECT_EQ(tracks_.back().fault, "no_temperature");
  }
  EXPECT_EQ(states_seen.front(), PipeTrack::STATE_COASTING);
  EXPECT_EQ(states_seen.back(), PipeTrack::STATE_LOST);
  EXPECT_NE(counted(tracker, "image.no_temperature"), "none");
  drive(26, 30);
  EXPECT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
  EXPECT_LT(error(), 1.5);
}

TEST_F(ThermalTrackerTest, WhereTheCameraIsOnTheRobotComesFromTf) {
  auto& tracker = start({{"camera.frame", "camera"}, {"max_coast", 0.5}});
  send_calibration();
  drive(20, 22);
  EXPECT_NE(counted(tracker, "tf.missing"), "none");
  for (double place = 22; place < 26; place += kSpeed * kPeriod) {
    geometry_msgs::msg::TransformStamped transform;
    transform.header.stamp = to_message(now_ + from_seconds(kPeriod));
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "camera";
    transform.transform = transform_message(kMounting);
    tf2_msgs::msg::TFMessage message;
    message.transforms.push_back(transform);
    send(topics::kTf, message);
    drive(place, place + 0.01);
  }
  EXPECT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
  EXPECT_NEAR(tracks_.back().range, kDistance, 1) << "by the line of the map";
}

TEST_F(ThermalTrackerTest, ABadPictureIsCountedAndTheNextOneIsFine) {
  auto& tracker = start();
  send_calibration();
  drive(20, 24);
  tracks_.clear();
  const auto send_bad = [&](const auto& spoil) {
    step();
    Image bad = picture(24);
    spoil(bad);
    send(topics::kThermalImage, bad);
  };
  send_bad([](Image& image) { image.encoding = "rgb8"; });
  send_bad([](Image& image) { image.height = 0; });
  send_bad([](Image& image) { image.data.resize(100); });
  EXPECT_TRUE(tracks_.empty());
  EXPECT_EQ(counted(tracker, "image.refused"), "3");
  send_bad([](Image& image) { image.header.stamp.sec = image.header.stamp.sec - 100; });
  send_bad([](Image& image) { image.header.stamp.sec = image.header.stamp.sec + 100; });
  EXPECT_TRUE(tracks_.empty());
  EXPECT_EQ(counted(tracker, "image.header.stamp.stale"), "1");
  EXPECT_EQ(counted(tracker, "image.header.stamp.in_future"), "1");
  drive(24, 26);
  EXPECT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
}

TEST_F(ThermalTrackerTest, ASecondPictureOfTheSameTimeIsNotUsed) {
  auto& tracker = start();
  send_calibration();
  drive(20, 24);
  send(topics::kThermalImage, picture(24));
  EXPECT_EQ(tracks_.back().fault, "time_went_back");
  EXPECT_EQ(counted(tracker, "track.time_went_back"), "1");
}

TEST_F(ThermalTrackerTest, PicturesOfAnotherSizeThanTheCalibrationAreTrackedWithoutIt) {
  auto& tracker = start();
  geometry::CameraParameters other = camera_.camera;
  other.width = 640;
  send(topics::kThermalCameraInfo, to_message(other));
  drive(20, 24);
  EXPECT_EQ(tracks_.back().state, PipeTrack::STATE_LOCKED);
  EXPECT_NE(counted(tracker, "camera_info.other_size"), "none");
  auto nonsense = to_message(other);
  nonsense.k[0] = std::numeric_limits<double>::quiet_NaN();
  send(topics::kThermalCameraInfo, nonsense);
  EXPECT_EQ(counted(tracker, "camera_info.refused"), "1");
}

TEST_F(ThermalTrackerTest, ParametersOutOfRangeAreNamed) {
  const auto message = [&](const NamedParameter& parameter) {
    auto& tracker = harness_.make<ThermalTracker>(
        {.name = "tracker_" + std::to_string(frame_++), .parameters = {parameter}});
    const auto result = harness_.configure(tracker);
    EXPECT_FALSE(result.success);
    return result.message;
  };
  EXPECT_THAT(message({"resampling", "roulette"}), HasSubstr("'roulette' is not one of"));
  EXPECT_THAT(message({"shape", "sphere"}), HasSubstr("'sphere' is not one of 'pipe', 'valve'"));
  EXPECT_THAT(message({"start_deviation", std::vector<double>{1, 2}}),
              HasSubstr("start_deviation"));
  EXPECT_THAT(message({"rate_walk", std::vector<double>{1, 1, 1, -1}}), HasSubstr("rate_walk"));
  EXPECT_THAT(message({"range.lines", std::vector<double>{1, 2, 3}}), HasSubstr("range.lines"));
  EXPECT_THAT(message({"camera.planck", std::vector<double>{1}}), HasSubstr("camera.planck"));
}

}  // namespace
}  // namespace pipescout
