// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/simulation/ground_robot.hpp"
#include "wheel_fusion.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kStanding = 5;           // s
constexpr double kOdometerPeriod = 0.02;  // s
constexpr double kLatency = 0.01;         // s, of a wheel's sample
// m, from the middle between the wheels to the IMU.
const Vector3d kImuPlace(0.2, -0.05, 0.1);

/// A field is crossed to and fro, with way-points at random.
std::vector<Vector2d> way_points(internal::Draw& draw) {
  constexpr double kField = 120;  // m
  constexpr int kCount = 60;
  std::vector<Vector2d> points;
  Vector2d last = Vector2d::Zero();
  while (points.size() < kCount) {
    const Vector2d next(draw.uniform(-kField / 2, kField / 2),
                        draw.uniform(-kField / 2, kField / 2));
    constexpr double kShortestLeg = 25;  // m
    if ((next - last).norm() > kShortestLeg) {
      points.push_back(next);
      last = next;
    }
  }
  return points;
}

odometry::OdometerStreamParameters fusion() {
  odometry::OdometerStreamParameters p;
  p.odometers.assign(
      simulation::kWheels,
      {.resolution = 0.001, .sigma_per_sqrt_metre = 0.01, .period = kOdometerPeriod});
  p.tick_period = 0.05;
  p.window_distance = 0.5;
  p.lookback_windows = 0;
  p.maximum_delay = 0.1;
  p.maximum_speed = 10;
  return p;
}

/// What the wheels would show in the middle of the robot: each less its part in the turns, by the
/// gyro, whose bias is its mean before the robot drives.
class TurnsTakenOut {
 public:
  explicit TurnsTakenOut(double track) : half_track_(track / 2) {}

  void add(const estimation::ImuReading& reading) {
    const double rate = reading.angular_rate.z();
    if (reading.time < kStanding) {
      ++count_;
      bias_ += (rate - bias_) / count_;
    } else if (std::isfinite(last_time_)) {
      turned_ += (reading.time - last_time_) * (rate - bias_);
    }
    last_time_ = reading.time;
  }
  [[nodiscard]] double in_the_middle(std::size_t wheel, double shown) const {
    return shown + (wheel % 2 == 0 ? half_track_ : -half_track_) * turned_;
  }

 private:
  double half_track_;
  double bias_ = 0;
  double turned_ = 0;
  double last_time_ = std::numeric_limits<double>::quiet_NaN();
  int count_ = 0;
};

}  // namespace

VehicleRun ground_robot_run(const RunOptions& options, std::uint64_t seed) {
  options.validate();
  using simulation::GroundRobot;
  VehicleRun run;
  run.vehicle = Vehicle::kGroundRobot;
  run.R_body_imu = SO3::about_z(std::numbers::pi / 2);
  run.antenna = Vector3d(-0.2, 0.1, 0.6);
  run.odometer_point = -kImuPlace;
  internal::Draw draw = internal::make_draw(seed, 10);
  internal::Recorder recorder(options, run, seed);

  constexpr std::array kRoads{simulation::RoadClass::kC, simulation::RoadClass::kD,
                              simulation::RoadClass::kE};
  const simulation::Terrain terrain(
      {.roughness = iso_8608_density(kRoads[seed % kRoads.size()]), .hill_height = 3}, seed);
  simulation::GroundRobotParameters parameters;
  if (options.world) {
    parameters.slip_spacing /= options.world->slip;
    parameters.side_slip = options.world->side_slip;
  }
  GroundRobot robot(parameters, terrain, Vector2d::Zero(),
                    draw.uniform(-std::numbers::pi, std::numbers::pi), seed);
  // Rougher ground is taken more slowly.
  const double speed = 5.5 - static_cast<double>(seed % kRoads.size());
  simulation::CourseController course({.speed = speed}, way_points(draw));
  odometry::OdometerStream stream(fusion());
  TurnsTakenOut turns(parameters.track);
  const SE3 T_body_imu(SO3(), kImuPlace);

  const int steps = static_cast<int>(options.duration / GroundRobot::kStep);
  const int odometer_steps = static_cast<int>(std::lround(kOdometerPeriod / GroundRobot::kStep));
  for (int i = 0; i <= steps; ++i) {
    const simulation::BodyMotion motion = robot.motion().of(T_body_imu);
    recorder.sample(motion, robot.distance());
    if (recorder.newest_imu()) {
      turns.add(*recorder.newest_imu());
    }
    if (i % odometer_steps == 0) {
      const auto shown = robot.odometers();
      for (std::size_t wheel = 0; wheel < simulation::kWheels; ++wheel) {
        internal::push_wheel(stream,
                             {.odometer = wheel,
                              .time = motion.time,
                              .value = turns.in_the_middle(wheel, shown[wheel])},
                             kLatency, recorder);
      }
    }
    if (motion.time >= kStanding) {
      robot.command(course.steer(robot));
    }
    robot.step();
  }
  recorder.finish();
  return run;
}

}  // namespace pipescout::estimation_study
