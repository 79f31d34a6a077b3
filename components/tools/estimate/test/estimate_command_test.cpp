// SPDX-License-Identifier: Apache-2.0
// `pipescout estimate` on bags with stock ROS types.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <limits>
#include <nav_msgs/msg/odometry.hpp>
#include <numbers>
#include <sensor_msgs/msg/fluid_pressure.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/magnetic_field.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/range.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/csv/testing/german_excel.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::estimate {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr double kBegin = 1'700'000'000;
constexpr double kDuration = 90;  // s

/// A robot that drives a figure of eight with changing speed on level ground.
struct Motion {
  double speed(double t) const { return t < 5 ? 0 : 1.5 + std::sin(0.6 * t) - std::sin(3.0); }
  double acceleration(double t) const { return t < 5 ? 0 : 0.6 * std::cos(0.6 * t); }
  double rate(double t) const { return t < 5 ? 0 : 0.4 * std::sin(0.15 * t); }
};

class EstimateOfABag : public ::testing::Test {
 protected:
  template <class T>
  void write(const std::string& topic, T message, double time) {
    const MessageType& type = message_type<T>();
    if constexpr (requires { message.header.stamp; }) {
      message.header.stamp.sec += time >= kJump ? jump_ : 0;
    }
    std::vector<std::byte> data(type.serialized_size(&message));
    ASSERT_EQ(type.serialize(&message, data), data.size());
    const auto stamp = static_cast<std::int64_t>((kBegin + time) * 1e9);
    writer_.write({.topic = writer_.add_topic(make_bag_topic(topic, std::string(type.name), {})),
                   .log_time = stamp,
                   .publish_time = stamp,
                   .data = data});
  }
  template <class T>
  static T stamped(double time, const std::string& frame) {
    T message;
    const double whole = std::floor(kBegin + time);
    message.header.stamp.sec = static_cast<std::int32_t>(whole);
    message.header.stamp.nanosec = static_cast<std::uint32_t>((kBegin + time - whole) * 1e9);
    message.header.frame_id = frame;
    return message;
  }
  void write_imu(double t, const sensor_msgs::msg::Imu& like) {
    auto m = stamped<sensor_msgs::msg::Imu>(t, "imu_link");
    m.linear_acceleration = like.linear_acceleration;
    m.angular_velocity = like.angular_velocity;
    m.angular_velocity.z *= gyro_sign_;
    write("/imu/data", m, t);
  }
  /// The IMU is turned by 90 degrees to the left: its x axis points along the body's y axis.
  sensor_msgs::msg::Imu turned_imu(double t) const {
    sensor_msgs::msg::Imu m;
    const double left = motion_.speed(t) * motion_.rate(t);
    // Quantised noise that no clean simulation lacks, so that no reading repeats.
    const double shake = 0.02 * std::sin(977 * t);
    m.linear_acceleration.x = left + shake;
    m.linear_acceleration.y = -motion_.acceleration(t) + shake;
    m.linear_acceleration.z = 9.807 + shake;
    m.angular_velocity.z = motion_.rate(t) + 1e-3 * std::sin(1013 * t);
    return m;
  }
  void write_odometry(double t) {
    auto m = stamped<nav_msgs::msg::Odometry>(t, "odom");
    m.child_frame_id = "base_link";
    if (twist_) {
      m.twist.twist.linear.x = odometer_factor_ * motion_.speed(t);
      m.twist.twist.angular.z = motion_.rate(t);
    }
    // In a frame of its own, turned from the map.
    m.pose.pose.position.x = pose_.y();
    m.pose.pose.position.y = -pose_.x();
    const double half = (heading_ - std::numbers::pi / 2) / 2;
    m.pose.pose.orientation.z = std::sin(half);
    m.pose.pose.orientation.w = std::cos(half);
    write("/odom", m, t);
  }
  /// Angles of wheels of 0.2 m, 0.6 m apart, in a message with a joint of an arm.
  void write_joints(double t) {
    auto m = stamped<sensor_msgs::msg::JointState>(t, "");
    m.name = {"wheel_left", "shoulder", "wheel_right"};
    m.position = {(way_ - 0.3 * heading_) / 0.2, 0.7, (way_ + 0.3 * heading_) / 0.2};
    write("/joint_states", m, t);
  }
  void write_fix(double t, const Eigen::Vector3d& position, const std::string& topic = "/fix") {
    auto m = stamped<sensor_msgs::msg::NavSatFix>(t + fix_clock_, "gps");
    const auto place = map_.geodetic(fixes_are_frozen_ ? Eigen::Vector3d::Zero() : position);
    m.latitude = place.latitude;
    m.longitude = place.longitude;
    m.altitude = place.altitude;
    m.position_covariance_type = 2;
    m.position_covariance = {1, 0, 0, 0, 1, 0, 0, 0, 4};
    write(topic, m, t);
  }
  void write_mounting() {
    tf2_msgs::msg::TFMessage m;
    m.transforms.resize(1);
    m.transforms[0].header.frame_id = "base_link";
    m.transforms[0].child_frame_id = "imu_link";
    m.transforms[0].transform.rotation.z = std::sqrt(0.5);
    m.transforms[0].transform.rotation.w = std::sqrt(0.5);
    write("/tf_static", m, 0);
  }
  /// The whole drive; the last position.
  Eigen::Vector3d drive(bool with_imu) {
    Eigen::Vector3d& position = pose_;
    double& heading = heading_;
    const int steps = static_cast<int>(kDuration * 100);
    for (int i = 0; i < steps; ++i) {
      const double t = 0.01 * i;
      if (with_imu) {
        write_imu(t, turned_imu(t));
      }
      if (i % 5 == 0) {
        joints_ ? write_joints(t) : write_odometry(t);
      }
      if (i % 50 == 0 && fixes_) {
        write_fix(t, position);
      }
      if (i % 10 == 0 && also_) {
        also_(t);
      }
      position +=
          0.01 * motion_.speed(t) * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
      heading += 0.01 * motion_.rate(t);
      way_ += 0.01 * motion_.speed(t);
    }
    return position;
  }
  /// Into `out`. What the run before has written is then in `before`.
  [[nodiscard]] auto run(const std::vector<std::string>& more = {}) {
    writer_.close();
    const fs::path out = folder_.path() / "out";
    const fs::path before = folder_.path() / "before";
    if (fs::exists(out)) {
      fs::remove_all(before);
      fs::rename(out, before);
    }
    std::vector<std::string> arguments{"bag", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return testing::run_program(ESTIMATE_COMMAND, arguments, folder_.path());
  }
  /// Position in the last line of the TUM file.
  [[nodiscard]] Eigen::Vector3d last_position() const {
    std::ifstream file(folder_.path() / "out" / "trajectory.tum");
    Eigen::Vector3d p = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    double time = 0, qx = 0, qy = 0, qz = 0, qw = 0, x = 0, y = 0, z = 0;
    while (file >> time >> x >> y >> z >> qx >> qy >> qz >> qw) {
      p = {x, y, z};
    }
    return p;
  }

  Eigen::Vector3d pose_ = Eigen::Vector3d::Zero();
  double heading_ = 0.5;
  double way_ = 0;
  bool twist_ = true;
  bool joints_ = false;  // in place of odometry
  bool fixes_ = true;
  std::function<void(double)> also_;  // writes more, ten times a second
  double fix_clock_ = 0;              // s, added to the stamps of fixes
  bool fixes_are_frozen_ = false;
  double gyro_sign_ = 1;
  double odometer_factor_ = 1;
  static constexpr double kJump = 45;  // s, when all clocks are set
  std::int32_t jump_ = 0;              // s
  Motion motion_;
  const geometry::LocalFrame map_{{47.0, 8.0, 400.0}};
  testing::TemporaryFolder folder_;
  bags::BagWriter writer_{folder_.path() / "bag", {}};
};

TEST_F(EstimateOfABag, WithImuOdometerAndGpsIsWrittenAndExplained) {
  write_mounting();
  const Eigen::Vector3d end = drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
  const std::string report = testing::content(folder_.path() / "out" / "report.md");
  EXPECT_THAT(report, AllOf(HasSubstr("/imu/data (sensor_msgs/msg/Imu, frame 'imu_link'"),
                            HasSubstr("yaw 90.0 degrees, from the transforms"),
                            HasSubstr("the odometer (speed along x, yaw rate)"),
                            Not(HasSubstr("seems to be mounted"))));
  EXPECT_THAT(testing::content(folder_.path() / "out" / "configuration.yaml"),
              HasSubstr("source: \"/imu/data\""));
  EXPECT_THAT(testing::content(folder_.path() / "out" / "trajectory.geojson"),
              HasSubstr("MultiLineString"));
  EXPECT_THAT(testing::content(folder_.path() / "out" / "trajectory.svg"),
              AllOf(HasSubstr(">x [m]</text>"), HasSubstr(">y [m]</text>"), HasSubstr(">0</text>"),
                    HasSubstr(">trajectory</text>"), HasSubstr(">GPS</text>")));
  const auto again = testing::run_program(
      ESTIMATE_COMMAND, {"bag", "--config", "out/configuration.yaml", "--out", "again"},
      folder_.path());
  EXPECT_EQ(again.code(), 0) << again.err;
  const auto over = testing::run_program(ESTIMATE_COMMAND, {"bag", "--out", "out"}, folder_.path());
  EXPECT_EQ(over.code(), 1);
  EXPECT_THAT(over.err, HasSubstr("out: is not empty ("));
  EXPECT_EQ(testing::content(folder_.path() / "out" / "report.md"), report);
  EXPECT_EQ(testing::content(folder_.path() / "again" / "trajectory.csv"),
            testing::content(folder_.path() / "out" / "trajectory.csv"));
}

TEST_F(EstimateOfABag, FixedTransformsOnTfAreAMountingAndMovingOnesAreNot) {
  for (int i = 0; i < 5; ++i) {
    tf2_msgs::msg::TFMessage m;
    m.transforms.resize(2);
    m.transforms[0].header.frame_id = "base_link";
    m.transforms[0].child_frame_id = "imu_link";
    m.transforms[0].transform.rotation.z = std::sqrt(0.5);
    m.transforms[0].transform.rotation.w = std::sqrt(0.5);
    m.transforms[1].header.frame_id = "base_link";
    m.transforms[1].child_frame_id = "gps";
    m.transforms[1].transform.translation.x = i;
    m.transforms[1].transform.rotation.w = 1;
    write("/tf", m, 0.01 * i);
  }
  drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("yaw 90.0 degrees, from the transforms"),
                                HasSubstr("where the antenna is on the robot is not known")));
}

TEST_F(EstimateOfABag, StampsOfAnotherClockAreNamedWithTheirOffsetAndUsed) {
  write_mounting();
  fix_clock_ = -3600;
  const Eigen::Vector3d end = drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("/fix: header.stamp is of another clock, 3600.000 s behind"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, StampsThatJumpGoOnAsTheRecordingDoes) {
  write_mounting();
  jump_ = -30;
  const Eigen::Vector3d end = drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("/imu/data: header.stamp jumps by -30.0 s"),
                                HasSubstr("/odom: header.stamp jumps by -30.0 s"),
                                HasSubstr("/fix: header.stamp jumps by -30.0 s"),
                                Not(HasSubstr("repeats that of another message"))));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, AGyroThatTurnsAgainstGpsIsNotUsed) {
  write_mounting();
  gyro_sign_ = -1;
  const Eigen::Vector3d end = drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("/imu/data turns against the course of /fix"),
                                HasSubstr("No IMU is used"), Not(HasSubstr("tells which"))));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, WithoutGpsNobodyTellsWhichOfGyroAndOdometerIsWrong) {
  write_mounting();
  gyro_sign_ = -1;
  fixes_ = false;
  drive(true);
  const auto result = run();
  EXPECT_THAT(result.out, AllOf(HasSubstr("turn in opposite directions"),
                                HasSubstr("the trajectory is wrong")));
}

TEST_F(EstimateOfABag, AnOdometerInKilometresPerHourIsNamedWithItsScale) {
  write_mounting();
  odometer_factor_ = 3.6;
  const Eigen::Vector3d end = drive(true);
  EXPECT_THAT(run().out, HasSubstr("as if its speed were in km/h instead of m/s. Set "
                                   "odometer.scale: 0.2"));
  std::ofstream(folder_.path() / "scaled.yaml") << "odometer: {scale: 0.2778}";
  const auto scaled = run({"--config", "scaled.yaml"});
  ASSERT_EQ(scaled.code(), 0) << scaled.err;
  EXPECT_THAT(scaled.out, HasSubstr("Nothing needs to be changed"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, AFrozenReceiverIsNamed) {
  write_mounting();
  fixes_are_frozen_ = true;
  drive(true);
  const auto result = run();
  EXPECT_THAT(result.out, HasSubstr("/fix: the position is frozen at one value from 0.0 to"));
}

TEST_F(EstimateOfABag, ADelayOfGpsIsFoundAndTakenIntoAccount) {
  write_mounting();
  fix_clock_ = 0.3;
  const Eigen::Vector3d end = drive(true);
  std::ofstream(folder_.path() / "late.yaml") << "gps: {time_offset_deviation: 1}";
  const auto result = run({"--config", "late.yaml"});
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, ContainsRegex("its fixes are of 0\\.[23][0-9] .* s before their stamps"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 0.5);
}

TEST_F(EstimateOfABag, WhatIsMissingForAStartIsNamed) {
  write_mounting();
  heading_ = 0;
  twist_ = false;
  // An IMU and GPS of a robot that drives too little to tell its heading.
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    write_imu(t, turned_imu(0));
    if (i % 50 == 0) {
      write_fix(t, Eigen::Vector3d::Zero());
    }
  }
  const auto unknown = run();
  EXPECT_EQ(unknown.code(), 1);
  EXPECT_THAT(unknown.out, AllOf(HasSubstr("The heading was never known. Give 'start: {heading:"),
                                 Not(HasSubstr("Nothing needs to be changed"))));
  std::ofstream(folder_.path() / "start.yaml") << "start: {heading: 40, heading_deviation: 5}";
  const auto known = run({"--config", "start.yaml"});
  ASSERT_EQ(known.code(), 0) << known.err;
  EXPECT_THAT(known.out,
              HasSubstr("The heading of start is used; the position is that of the first fix."));
}

TEST_F(EstimateOfABag, ASecondAntennaIsNamedAndUsedOnceTheConfigurationNamesIt) {
  write_mounting();
  also_ = [&](double t) {
    const Eigen::Vector3d rear(-0.8 * std::cos(heading_), -0.8 * std::sin(heading_), 0);
    write_fix(t + 0.05, pose_ + rear, "/gps_rear/fix");
  };
  const Eigen::Vector3d end = drive(true);
  std::ofstream(folder_.path() / "front.yaml") << "gps: {source: /fix}";
  const auto one = run({"--config", "front.yaml"});
  EXPECT_THAT(one.out, HasSubstr("{kind: gps_fix, topic: "));
  std::ofstream(folder_.path() / "both.yaml")
      << "further_sources: {rear: {kind: gps_fix, topic: /gps_rear/fix, position: [-0.8, 0, 0]}}";
  const auto both = run({"--config", "both.yaml"});
  ASSERT_EQ(both.code(), 0) << both.err;
  EXPECT_THAT(both.out, ContainsRegex("- rear: [1-9][0-9]+ measurements accepted, 0 rejected"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 0.5);
}

TEST_F(EstimateOfABag, TheReportSaysForHowLongErrorsOfGpsStayAlike) {
  write_mounting();
  drive(true);
  EXPECT_THAT(run().out, HasSubstr("- GPS: errors of gps "));
  std::ofstream(folder_.path() / "found.yaml")
      << "gps: {correlation_time: 5, shortest_correlation_time: 0}";
  const auto found = run({"--config", "found.yaml"});
  EXPECT_THAT(found.out, HasSubstr("found on line between 0 and 5 s"));
  EXPECT_THAT(testing::content(folder_.path() / "out" / "configuration.yaml"),
              HasSubstr("  shortest_correlation_time: 0  #"));
}

TEST_F(EstimateOfABag, WithoutImuIsFromWheelsAndGps) {
  const Eigen::Vector3d end = drive(false);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
  EXPECT_THAT(result.out, HasSubstr("No IMU is used"));
}

TEST_F(EstimateOfABag, MountingFromMotionIsProposedAndAppliedOnlyWhenAsked) {
  const Eigen::Vector3d end = drive(true);
  const auto proposed = run();
  EXPECT_THAT(proposed.out, AllOf(HasSubstr("roll 0, pitch 0, yaw 90 degrees, which is not"),
                                  HasSubstr("is not connected to the base frame"),
                                  Not(HasSubstr("as asked by --apply-mounting"))));
  const auto applied = run({"--apply-mounting"});
  ASSERT_EQ(applied.code(), 0) << applied.err;
  EXPECT_THAT(applied.out, HasSubstr("as asked by --apply-mounting"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, BadInputIsCountedAndNamedAndLosesNothingElse) {
  write_mounting();
  auto zero = stamped<sensor_msgs::msg::NavSatFix>(0.001, "gps");
  write("/fix", zero, 0.001);
  sensor_msgs::msg::Imu dead;
  dead.angular_velocity.z = 0.1;
  write_imu(0.001, dead);
  auto odometry = stamped<nav_msgs::msg::Odometry>(0.001, "odom");
  odometry.twist.twist.linear.x = std::numeric_limits<double>::quiet_NaN();
  write("/odom", odometry, 0.001);
  auto fix = stamped<sensor_msgs::msg::NavSatFix>(0.002, "gps");
  fix.latitude = 47;
  fix.longitude = 8;
  fix.altitude = 400;
  fix.position_covariance_type = 2;
  fix.position_covariance[0] = -1;
  write("/fix", fix, 0.002);
  const Eigen::Vector3d end = drive(true);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("the position is exactly 0, 0"), HasSubstr("a dead accelerometer"),
                    HasSubstr("/odom: twist.linear is not finite; not used: 1 of its messages"),
                    HasSubstr("position_covariance is not finite, not symmetric, zero or")));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, CutShortIsUsedAsFarAsItCanBeRead) {
  write_mounting();
  drive(true);
  writer_.close();
  for (const auto& entry : fs::directory_iterator(folder_.path() / "bag")) {
    if (entry.path().extension() == ".db3") {
      fs::resize_file(entry.path(), fs::file_size(entry.path()) * 7 / 10);
    }
  }
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("The bag cannot be read to its end"));
}

TEST_F(EstimateOfABag, OdometryWithoutTwistIsUsedByItsPoses) {
  twist_ = false;
  const Eigen::Vector3d end = drive(false);
  const auto result = run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("/odom: twist is zero in all messages"));
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
}

TEST_F(EstimateOfABag, WheelsOfJointStatesAreNamedAndUsedOnceTheyAreKnown) {
  joints_ = true;
  const Eigen::Vector3d end = drive(false);
  const auto unknown = run();
  EXPECT_EQ(unknown.code(), 1);
  EXPECT_THAT(unknown.out, HasSubstr("'odometer: {wheels: {left: [wheel_left], right: "
                                     "[wheel_right], radius: ..., track: ...}}'"));
  std::ofstream(folder_.path() / "wheels.yaml")
      << "odometer: {wheels: {left: [wheel_left], right: [wheel_right], radius: 0.2, track: 0.6}}";
  const auto known = run({"--config", "wheels.yaml"});
  ASSERT_EQ(known.code(), 0) << known.out << known.err;
  EXPECT_LT((last_position() - end).head<2>().norm(), 1.0);
  EXPECT_THAT(testing::content(folder_.path() / "out" / "configuration.yaml"),
              HasSubstr("left: [\"wheel_left\"]"));
  // What was written can be passed back.
  const auto again = run({"--config", "before/configuration.yaml"});
  EXPECT_EQ(again.code(), 0) << again.err;
  std::ofstream(folder_.path() / "wheels.yaml") << "odometer: {wheels: {left: [a], right: [a]}}";
  const auto wrong = run({"--config", "wheels.yaml"});
  EXPECT_NE(wrong.code(), 0);
  EXPECT_THAT(wrong.err, HasSubstr("wheels.yaml:1"));
}

TEST_F(EstimateOfABag, FurtherSourcesAreNamedAndUsedOnceTheConfigurationNamesThem) {
  write_mounting();
  const Eigen::Vector3d beacon(20, -10, 3);
  also_ = [&](double t) {
    auto field = stamped<sensor_msgs::msg::MagneticField>(t, "base_link");
    field.magnetic_field.x = 2e-5 * std::sin(heading_);
    field.magnetic_field.y = 2e-5 * std::cos(heading_);
    field.magnetic_field.z = -4e-5;
    write("/imu/mag", field, t);
    auto pressure = stamped<sensor_msgs::msg::FluidPressure>(t, "base_link");
    pressure.fluid_pressure = 96'600;
    write("/pressure", pressure, t);
    auto range = stamped<sensor_msgs::msg::Range>(t, "antenna");  // tf does not know it
    range.range = static_cast<float>((pose_ - beacon).norm());
    write("/uwb", range, t);
    auto velocity = stamped<geometry_msgs::msg::TwistWithCovarianceStamped>(t, "map");
    velocity.twist.twist.linear.x = motion_.speed(t) * std::cos(heading_);
    velocity.twist.twist.linear.y = motion_.speed(t) * std::sin(heading_);
    write("/gps/velocity", velocity, t);
  };
  const Eigen::Vector3d end = drive(true);
  const auto unnamed = run();
  ASSERT_EQ(unnamed.code(), 0) << unnamed.err;
  EXPECT_THAT(unnamed.out,
              AllOf(HasSubstr("{kind: magnetic_field, topic: /imu/mag}"),
                    HasSubstr("{kind: range, topic: /uwb, beacon: [x, y, z]}"),
                    HasSubstr("/gps/velocity (geometry_msgs/msg/TwistWithCovarianceStamped): not "
                              "used, it seems to be a velocity of GPS")));
  const std::string named = R"(further_sources:
  compass: {kind: magnetic_field, topic: /imu/mag, deviation: 0.05}
  barometer: {kind: fluid_pressure, topic: /pressure}
  anchor: {kind: range, topic: /uwb, beacon: [20, -10, 3], position: [0, 0, 0]}
  speed: {kind: gps_velocity_with_covariance, topic: /gps/velocity, position: [0, 0, 0]}
  lidar: {kind: odometry_pose, topic: /odom}
)";
  std::ofstream(folder_.path() / "named.yaml") << named;
  const auto used = run({"--config", "named.yaml"});
  ASSERT_EQ(used.code(), 0) << used.out << used.err;
  EXPECT_LT((last_position() - end).head<2>().norm(), 0.5);
  EXPECT_THAT(used.out, AllOf(HasSubstr("taken as compass, of kind magnetic_field"),
                              HasSubstr("taken as lidar, of kind odometry_pose"),
                              HasSubstr("/odom (nav_msgs/msg/Odometry, frame 'base_link'")));
  for (const char* source : {"compass", "barometer", "anchor", "speed", "lidar"}) {
    EXPECT_THAT(used.out,
                ContainsRegex(std::string("- ") + source +
                              ": [1-9][0-9][0-9]+ measurements accepted, [0-9] rejected"));
  }
  // What was written can be passed back.
  const auto again = run({"--config", "before/configuration.yaml"});
  EXPECT_EQ(again.code(), 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("taken as compass, of kind magnetic_field"));
  // A frame that tf does not know is named, and nothing else is lost.
  std::ofstream(folder_.path() / "named.yaml")
      << "further_sources: {anchor: {kind: range, topic: /uwb, beacon: [20, -10, 3]}}";
  const auto frameless = run({"--config", "named.yaml"});
  EXPECT_EQ(frameless.code(), 0) << frameless.err;
  EXPECT_THAT(frameless.out, HasSubstr("anchor: frame 'antenna' is not connected to the base"));
}

TEST_F(EstimateOfABag, FurtherSourcesThatTheRecordingDoesNotHaveAreErrors) {
  drive(false);
  const auto error_of = [&](const std::string& sources) {
    std::ofstream(folder_.path() / "named.yaml") << "further_sources: " << sources;
    const auto result = run({"--config", "named.yaml"});
    EXPECT_NE(result.code(), 0);
    return result.err;
  };
  EXPECT_THAT(error_of("{a: {kind: magnetic_field, topic: /imu/mag}}"),
              HasSubstr("further_sources.a.topic: the recording has no source '/imu/mag'"));
  EXPECT_THAT(error_of("{a: {kind: magnetic_field, topic: /fix}}"),
              HasSubstr("is measured by sensor_msgs/msg/MagneticField"));
  EXPECT_THAT(error_of("{a: {kind: sundial}}"), HasSubstr("named.yaml:1"));
  EXPECT_THAT(error_of("{a: {kind: range, topic: /fix}}"), HasSubstr("a.beacon"));
  EXPECT_THAT(error_of("{a: {kind: gps_fix, height: 3}}"), HasSubstr("height"));
}

/// A vehicle on a circle of 10 m from (10, 0) northwards, 2 m/s: wheels whose yaw rate is off, and
/// sources that say so. `standing`: s, before it drives. `start`: m, where it is said to begin.
class CircleWithoutGps {
 public:
  static constexpr double kRadius = 10;
  static constexpr double kSpeed = 2;
  static constexpr double kEnd = 60;  // s

  explicit CircleWithoutGps(double standing, double start = kRadius) : standing_(standing) {
    constexpr double kOff = 0.01;  // rad/s
    std::ofstream wheels(folder_.path() / "wheels.csv");
    std::ofstream ranges(folder_.path() / "ranges.csv");
    std::ofstream track(folder_.path() / "track.csv");
    wheels << "t,v,w\n";
    ranges << "t,north,east\n";
    track << "t,speed,course\n";
    for (int i = 0; i <= 20 * kEnd; ++i) {
      const double t = 0.05 * i;
      const double speed = t < standing ? 0 : kSpeed;
      const Eigen::Vector2d p = place(t);
      wheels << t << "," << speed << "," << speed / kRadius + (speed > 0 ? kOff : 0) << "\n";
      ranges << t << "," << (p - Eigen::Vector2d(0, 40)).norm() << ","
             << (p - Eigen::Vector2d(40, 0)).norm() << "\n";
      track << t << "," << speed << "," << -angle(t) * 180 / std::numbers::pi << "\n";
    }
    std::ofstream(folder_.path() / "mapping.yaml")
        << "start: {position: [" << start << R"(, 0, 0], heading: 90}
further_sources:
  north: {kind: range, beacon: [0, 40, 0], deviation: 0.1}
  east: {kind: range, beacon: [40, 0, 0], deviation: 0.1}
  track: {kind: gps_velocity}
sources:
  - {name: wheels, kind: odometer, file: wheels.csv, columns: {time: t, speed: v, yaw_rate: w}}
  - {name: north, kind: range, file: ranges.csv, columns: {time: t, range: north}}
  - {name: east, kind: range, file: ranges.csv, columns: {time: t, range: east}}
  - {name: track, kind: gps_velocity, file: track.csv, columns: {time: t, speed: speed, course: course}}
)";
  }

  [[nodiscard]] double angle(double t) const {
    return std::max(0.0, t - standing_) * kSpeed / kRadius;
  }
  [[nodiscard]] Eigen::Vector2d place(double t) const {
    return kRadius * Eigen::Vector2d(std::cos(angle(t)), std::sin(angle(t)));
  }
  /// Anew: results are never overwritten.
  [[nodiscard]] auto run() const {
    std::filesystem::remove_all(folder_.path() / "out");
    return testing::run_program(ESTIMATE_COMMAND, {".", "--config", "mapping.yaml", "--out", "out"},
                                folder_.path());
  }
  /// The files as another program writes them: `convert` takes their bytes.
  template <class Convert>
  void convert_files(const Convert& convert) const {
    for (const char* name : {"wheels.csv", "ranges.csv", "track.csv"}) {
      const std::string bytes = convert(testing::content(folder_.path() / name));
      std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
    }
  }
  [[nodiscard]] std::string trajectory() const {
    return testing::content(folder_.path() / "out" / "trajectory.csv");
  }
  /// In place of start and of the other sources: poses that are of `late` seconds after their
  /// stamp.
  void write_poses(double late) const {
    std::ofstream poses(folder_.path() / "poses.csv");
    poses << "t,x,y,z,qx,qy,qz,qw\n";
    for (int i = 0; i <= 10 * kEnd; ++i) {
      const double t = 0.1 * i;
      const Eigen::Vector2d p = place(t + late);
      const double heading = angle(t + late) + std::numbers::pi / 2;
      poses << t << "," << p.x() << "," << p.y() << ",0,0,0," << std::sin(heading / 2) << ","
            << std::cos(heading / 2) << "\n";
    }
    std::ofstream(folder_.path() / "mapping.yaml") << R"(further_sources:
  seen: {kind: pose, deviation: 0.02, rotation_deviation: 0.01, time_offset_deviation: 0.1}
sources:
  - {name: wheels, kind: odometer, file: wheels.csv, columns: {time: t, speed: v, yaw_rate: w}}
  - {name: seen, kind: pose, file: poses.csv, columns: {time: t, position: [x, y, z], orientation: [qx, qy, qz, qw]}}
)";
  }
  /// m, of the last pose of the trajectory, which must be near the end.
  [[nodiscard]] double error() const {
    std::ifstream file(folder_.path() / "out" / "trajectory.tum");
    double time = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
    while (file >> time >> x >> y >> z >> qx >> qy >> qz >> qw) {
    }
    EXPECT_GT(time, kEnd - 1);
    return (Eigen::Vector2d(x, y) - place(time)).norm();
  }

 private:
  double standing_;
  testing::TemporaryFolder folder_;
};

TEST(EstimateOfCsvFiles, FurtherSourcesHoldAVehicleWithoutGps) {
  const CircleWithoutGps circle(3);
  const auto result = circle.run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("the trajectory begins as start says"),
                                HasSubstr("taken as track, of kind gps_velocity")));
  EXPECT_LT(circle.error(), 0.5);  // by the wheels alone: 10 m
}

TEST(EstimateOfCsvFiles, GermanExcelsExportsGiveTheSameTrajectory) {
  const CircleWithoutGps circle(3);
  ASSERT_EQ(circle.run().code(), 0);
  const std::string original = circle.trajectory();
  circle.convert_files([](const std::string& csv) {
    return testing::german_excel(csv, testing::ExcelExport::kUnicodeText);
  });
  const auto result = circle.run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("wheels.csv: numbers have a decimal comma"));
  EXPECT_EQ(circle.trajectory(), original);
}

TEST(EstimateOfCsvFiles, TimesInOtherUnitsAreRecognised) {
  const CircleWithoutGps circle(3);
  /// The first column of a file, changed.
  const auto with_times = [](const std::string& csv, const auto& change) {
    const CsvTable table(csv, "");
    std::string text = csv.substr(0, csv.find('\n') + 1);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      text += change(table.cell(row, 0));
      for (std::size_t column = 1; column < table.columns().size(); ++column) {
        text += "," + table.cell(row, column);
      }
      text += "\n";
    }
    return text;
  };
  circle.convert_files([&](const std::string& csv) {
    return with_times(csv, [](const std::string& cell) {
      const auto ms = std::llround(*parse_csv_number(cell) * 1000) + 1'700'000'000'000;
      const std::string text = std::to_string(ms);
      return text.substr(0, 10) + "." + text.substr(10);
    });
  });
  ASSERT_EQ(circle.run().code(), 0);
  const std::string original = circle.trajectory();
  bool is_first = true;
  circle.convert_files([&](const std::string& csv) {
    return with_times(csv, [was_first = std::exchange(is_first, false)](std::string cell) {
      std::erase_if(cell, [&](char c) { return was_first && c == '.'; });
      return cell;
    });
  });
  const auto result = circle.run();
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("wheels.csv: column 't': times are in ms, by their size"));
  // Seconds with decimals and whole milliseconds differ by less than a microsecond, so the last
  // digit that is written may.
  const CsvTable found(circle.trajectory(), "");
  const CsvTable expected(original, "");
  ASSERT_EQ(found.rows(), expected.rows());
  for (std::size_t row = 0; row < found.rows(); ++row) {
    for (std::size_t column = 0; column < found.columns().size(); ++column) {
      EXPECT_NEAR(*parse_csv_number(found.cell(row, column)),
                  *parse_csv_number(expected.cell(row, column)), 1.5e-4);
    }
  }
}

TEST(EstimateOfCsvFiles, TheStartIsThatOfTheFirstMessageOfAVehicleThatDrives) {
  const CircleWithoutGps circle(0);
  const auto result = circle.run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_THAT(result.out, Not(HasSubstr("contradicts the trajectory")));
  EXPECT_LT(circle.error(), 0.5);
}

TEST(EstimateOfCsvFiles, PosesInTheMapPlaceTheVehicleAndTellTheirDelay) {
  const CircleWithoutGps circle(3);
  circle.write_poses(-0.1);
  const auto result = circle.run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("begins at the first pose of the sources of kind pose"),
                                HasSubstr("ms before their stamps")));
  EXPECT_LT(circle.error(), 0.1);
}

TEST(EstimateOfCsvFiles, AFurtherSourceThatContradictsTheTrajectoryIsNamed) {
  const auto result = CircleWithoutGps(0, 20).run();
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("east contradicts the trajectory in "));
}

TEST(EstimateOfCsvFiles, KindsAndColumnsThatAreNoneAreNamed) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "a.csv") << "t,x\n0,1\n";
  const auto error_of = [&](const std::string& source) {
    std::ofstream(folder.path() / "mapping.yaml") << "sources: [" << source << "]\n";
    const auto result = testing::run_program(
        ESTIMATE_COMMAND, {".", "--config", "mapping.yaml", "--out", "out"}, folder.path());
    EXPECT_NE(result.code(), 0);
    return result.err;
  };
  EXPECT_THAT(error_of("{name: a, kind: sundial, file: a.csv, columns: {time: t}}"),
              HasSubstr("magnetic_field"));
  EXPECT_THAT(error_of("{name: a, kind: magnetic_field, file: a.csv, columns: {time: t}}"),
              HasSubstr("'field' is missing"));
  EXPECT_THAT(error_of("{name: a, kind: range, file: a.csv, columns: {time: t, field: x}}"),
              HasSubstr("field"));
  EXPECT_THAT(
      error_of("{name: a, kind: range, file: a.csv, time_unit: h, columns: {time: t, range: x}}"),
      HasSubstr("time_unit must be s, ms, us or ns, not 'h'"));
  EXPECT_THAT(error_of("{name: a, kind: wheel_encoders, file: a.csv, columns: {time: t}}"),
              HasSubstr("is of bags"));
  std::ofstream(folder.path() / "a.csv") << "t,x\n0,1\n50000000000,1\n";
  EXPECT_THAT(error_of("{name: a, kind: range, file: a.csv, columns: {time: t, range: x}}"),
              HasSubstr("a time of 11 digits is beyond what a time in s can be; set 'time_unit' in "
                        "mapping.yaml"));
}

TEST_F(EstimateOfABag, WithoutAnythingToUseFailsAndSaysWhy) {
  write_fix(0, Eigen::Vector3d::Zero());
  const auto result = run();
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("there is no usable IMU, and no odometer"));
  EXPECT_THAT(testing::content(folder_.path() / "out" / "report.md"),
              HasSubstr("there is no usable IMU, and no odometer"));
}

}  // namespace
}  // namespace pipescout::estimate
