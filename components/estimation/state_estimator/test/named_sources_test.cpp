// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/named_sources.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/state_estimator/state_estimator.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using testing::ComponentHarness;
using ::testing::HasSubstr;

/// A robot that stands at a known place, with the sensors that the parameters name.
class NamedSourcesTest : public ::testing::Test {
 protected:
  static constexpr double kGravity = 9.81;
  static constexpr Time kStart{std::chrono::seconds(1000)};

  NamedSourcesTest() { harness_.set_time(kStart); }

  StateEstimator& start(std::vector<NamedParameter> more) {
    std::vector<NamedParameter> parameters = {
        {"datum", std::vector<double>{47.0, 8.0, 400.0}},
        {"start.position", std::vector<double>{0.0, 0.0, 0.0}},
        {"start.position_deviation", 1.0},
        {"start.heading", std::vector<double>{0.1, 0.2}}};
    parameters.insert(parameters.end(), more.begin(), more.end());
    auto& estimator =
        harness_.make<StateEstimator>({.name = "estimator", .parameters = parameters});
    const auto result = harness_.bring_up(estimator);
    EXPECT_TRUE(result.success) << result.message;
    return estimator;
  }

  /// IMU at 100 Hz; `others` ten times a second, with the stamp.
  template <class Others>
  void stand(double from, double to, Others&& others) {
    for (int i = static_cast<int>(std::lround(100 * from)); i < std::lround(100 * to); ++i) {
      const Time now = kStart + from_seconds(0.01 * i);
      harness_.set_time(now);
      sensor_msgs::msg::Imu imu;
      imu.header.stamp = to_message(now);
      imu.orientation_covariance[0] = -1;
      imu.linear_acceleration.z = kGravity;
      publish("imu/data", imu);
      if (i % 10 == 0) {
        others(to_message(now));
      }
    }
  }
  template <class T>
  void publish(std::string_view topic, const T& message) {
    harness_.publish(Topic<T>{topic, QoS::reliable(10)}, message);
    harness_.spin();
  }
  [[nodiscard]] std::size_t accepted(const std::string& source) {
    const auto& state = states_.back();
    const auto found = std::ranges::find(state.source, source);
    return found == state.source.end()
               ? 0
               : state.source_accepted[static_cast<std::size_t>(found - state.source.begin())];
  }

  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<nav_msgs::msg::Odometry> odometry_ =
      harness_.collect(topics::kOdometryFiltered);
  testing::Collector<pipescout_msgs::msg::EstimatorState> states_ =
      harness_.collect(topics::kEstimatorState);
};

TEST_F(NamedSourcesTest, ACompassABarometerAndBeaconsHoldARobotWithoutGps) {
  start({{"sources", std::vector<std::string>{"compass", "barometer", "north", "east", "velocity"}},
         {"compass.kind", "magnetic_field"},
         {"compass.topic", "imu/mag"},
         {"compass.declination", 0.05},
         {"barometer.kind", "fluid_pressure"},
         {"north.kind", "range"},
         {"north.beacon", std::vector<double>{0.0, 30.0, 2.0}},
         {"east.kind", "range"},
         {"east.beacon", std::vector<double>{20.0, 0.0, 2.0}},
         {"velocity.kind", "gps_velocity"}});
  stand(0, 12, [&](const auto& stamp) {
    sensor_msgs::msg::MagneticField field;
    field.header.stamp = stamp;
    field.magnetic_field =
        to_message(Vector3d(2e-5 * std::sin(0.05), 2e-5 * std::cos(0.05), -4e-5));
    publish("imu/mag", field);
    sensor_msgs::msg::FluidPressure pressure;
    pressure.header.stamp = stamp;
    pressure.fluid_pressure = 95000;
    publish("barometer", pressure);
    sensor_msgs::msg::Range range;
    range.header.stamp = stamp;
    // It is at (1, 1), where it was said to be at (0, 0).
    range.range = static_cast<float>(Vector3d(1, -29, -2).norm());
    publish("north", range);
    range.range = static_cast<float>(Vector3d(-19, 1, -2).norm());
    publish("east", range);
    range.range = std::numeric_limits<float>::infinity();  // nothing detected
    publish("east", range);
    geometry_msgs::msg::TwistStamped velocity;
    velocity.header.stamp = stamp;
    publish("velocity", velocity);
  });
  ASSERT_FALSE(odometry_.empty());
  const SE3 pose = from_message(odometry_.back().pose.pose);
  EXPECT_NEAR(pose.translation().x(), 1, 0.2);
  EXPECT_NEAR(pose.translation().y(), 1, 0.2);
  EXPECT_NEAR(pose.rotation().roll_pitch_yaw().z(), 0, 0.05);
  for (const char* source : {"compass", "barometer", "north", "east", "velocity"}) {
    EXPECT_GT(accepted(source), 50U) << source;
  }
}

TEST_F(NamedSourcesTest, AFrameIsTakenFromTfAndNamedWhereItIsMissing) {
  auto& estimator = start({{"sources", std::vector<std::string>{"wheels"}},
                           {"wheels.kind", "base_velocity"},
                           {"wheels.topic", "twist"}});
  const auto send = [&](const auto& stamp) {
    geometry_msgs::msg::TwistWithCovarianceStamped twist;
    twist.header.stamp = stamp;
    twist.header.frame_id = "axle";
    publish("twist", twist);
  };
  stand(0, 4, send);
  EXPECT_GT(estimator.diagnostics().counter("wheels.tf"), 20U);
  EXPECT_EQ(accepted("wheels"), 0U);
  tf2_msgs::msg::TFMessage tf;
  auto& transform = tf.transforms.emplace_back();
  transform.header.frame_id = "base_link";
  transform.child_frame_id = "axle";
  transform.transform = transform_message(SE3(SO3(), Vector3d(0.2, 0, 0)));
  harness_.publish(topics::kTfStatic, tf);
  harness_.spin();
  const auto missing = estimator.diagnostics().counter("wheels.tf");
  stand(4, 8, send);
  EXPECT_EQ(estimator.diagnostics().counter("wheels.tf"), missing);
  EXPECT_GT(accepted("wheels"), 20U);
}

TEST_F(NamedSourcesTest, OdometryOfAnyBaseIsAMotionOrAVelocity) {
  auto& estimator = start({{"sources", std::vector<std::string>{"lidar", "base", "antenna"}},
                           {"lidar.kind", "odometry_pose"},
                           {"lidar.position", std::vector<double>{0.1, 0.0, 0.5}},
                           {"base.kind", "odometry_velocity"},
                           {"antenna.kind", "gps_fix"},
                           {"antenna.position", std::vector<double>{0.0, 0.4, 1.0}}});
  const geometry::LocalFrame map({47.0, 8.0, 400.0});
  double offset = 0;
  const auto send = [&](const auto& stamp) {
    nav_msgs::msg::Odometry odometry;
    odometry.header.stamp = stamp;
    odometry.child_frame_id = "base_link";
    odometry.pose.pose = to_message(SE3(SO3::about_z(2), Vector3d(5 + offset, 6, 0)));
    publish("lidar", odometry);
    publish("base", odometry);
    const geometry::GeodeticPosition place = map.geodetic(Vector3d(0, 0.4, 1));
    sensor_msgs::msg::NavSatFix fix;
    fix.header.stamp = stamp;
    fix.latitude = place.latitude;
    fix.longitude = place.longitude;
    fix.altitude = place.altitude;
    publish("antenna", fix);
  };
  stand(0, 6, send);
  for (const char* source : {"lidar", "base", "antenna"}) {
    EXPECT_GT(accepted(source), 30U) << source;
  }
  EXPECT_EQ(estimator.diagnostics().counter("lidar.jump"), 0U);
  offset = 500;
  stand(6, 6.5, send);
  EXPECT_EQ(estimator.diagnostics().counter("lidar.jump"), 1U);
  EXPECT_LT(from_message(odometry_.back().pose.pose).translation().norm(), 1);
}

TEST_F(NamedSourcesTest, WheelEncodersAndGpsAreEnough) {
  constexpr double kRadius = 20;  // m, of the circle
  constexpr double kSpeed = 2;    // m/s
  constexpr double kWheel = 0.16;
  constexpr double kTrack = 0.6;
  auto& estimator = start({{"sources", std::vector<std::string>{"wheels"}},
                           {"imu.implied_by", "wheels"},
                           {"wheels.kind", "wheel_encoders"},
                           {"wheels.topic", "joint_states"},
                           {"wheels.left", std::vector<std::string>{"fl", "rl"}},
                           {"wheels.right", std::vector<std::string>{"fr", "rr"}},
                           {"wheels.wheel_radius", kWheel},
                           {"wheels.track", kTrack}});
  const geometry::LocalFrame map({47.0, 8.0, 400.0});
  const double rate = kSpeed / kRadius;
  Vector3d truth = Vector3d::Zero();
  for (int i = 0; i <= 1200; ++i) {
    const double time = 0.05 * i;
    harness_.set_time(kStart + from_seconds(time));
    truth = {kRadius * std::sin(rate * time), kRadius * (1 - std::cos(rate * time)), 0};
    sensor_msgs::msg::JointState joints;
    joints.header.stamp = to_message(kStart + from_seconds(time));
    joints.name = {"shoulder", "elbow"};  // of the arm, in a message of its own
    joints.position = {0.1, std::numeric_limits<double>::quiet_NaN()};
    publish("joint_states", joints);
    joints.name = {"fl", "fr", "rl", "rr", "gripper"};
    const double left = (kSpeed - rate * kTrack / 2) / kWheel * time;
    const double right = (kSpeed + rate * kTrack / 2) / kWheel * time;
    joints.position = {left, right, left, right, 0.0};
    publish("joint_states", joints);
    if (i % 20 == 0) {
      const geometry::GeodeticPosition place = map.geodetic(truth);
      sensor_msgs::msg::NavSatFix fix;
      fix.header.stamp = joints.header.stamp;
      fix.latitude = place.latitude;
      fix.longitude = place.longitude;
      fix.altitude = place.altitude;
      fix.position_covariance = {0.25, 0, 0, 0, 0.25, 0, 0, 0, 1};
      fix.position_covariance_type = sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_KNOWN;
      publish("gps/fix", fix);
    }
  }
  ASSERT_FALSE(odometry_.empty());
  EXPECT_LT((from_message(odometry_.back().pose.pose).translation() - truth).head<2>().norm(), 0.5);
  EXPECT_NEAR(odometry_.back().twist.twist.linear.x, kSpeed, 0.1);
  EXPECT_GT(accepted("wheels"), 500U);
  EXPECT_EQ(estimator.diagnostics().counter("wheels.refused"), 0U);
  EXPECT_EQ(estimator.diagnostics().counter("imu.silent"), 0U);
  harness_.advance(std::chrono::seconds(3));
  harness_.advance(std::chrono::seconds(3));
  EXPECT_GT(estimator.diagnostics().counter("imu.silent"), 0U);
}

TEST_F(NamedSourcesTest, ParametersThatAreWrongAreRefusedByName) {
  const auto refused = [&](std::vector<NamedParameter> parameters) {
    parameters.push_back({"sources", std::vector<std::string>{"one"}});
    auto& estimator = harness_.make<StateEstimator>({.parameters = parameters});
    const auto result = harness_.configure(estimator);
    EXPECT_FALSE(result.success);
    harness_.destroy(estimator);
    return result.message;
  };
  EXPECT_THROW((void)harness_.make<StateEstimator>(
                   {.parameters = {{"sources", std::vector<std::string>{"one"}}}}),
               ParameterError);
  EXPECT_THROW(
      (void)harness_.make<StateEstimator>(
          {.parameters = {{"sources", std::vector<std::string>{"one"}}, {"one.kind", "sundial"}}}),
      ParameterError);
  EXPECT_THAT(refused({{"one.kind", "range"}}), HasSubstr("one.beacon"));
  EXPECT_THAT(refused({{"one.kind", "gps_fix"}, {"one.position", std::vector<double>{1.0}}}),
              HasSubstr("one.position"));
  EXPECT_THAT(refused({{"one.kind", "wheel_encoders"}}), HasSubstr("source 'one'"));
  EXPECT_THAT(refused({{"one.kind", "gps_velocity"}, {"imu.implied_by", "one"}}),
              HasSubstr("imu.implied_by"));
}

}  // namespace
}  // namespace pipescout
