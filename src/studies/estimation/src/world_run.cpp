// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/world_run.hpp"

#include <cmath>
#include <variant>

#include "pipescout/estimation_study/sensor_loss.hpp"

namespace pipescout::estimation_study {
namespace {

constexpr double kNominalScaleDeviation = 0.02;  // of an odometer that nobody has calibrated
constexpr double kWholeUntil = 20;               // s: what is lost is lost afterwards
constexpr double kBurst = 2;                     // s

/// The stamps as they ought to be.
VehicleRun with_true_stamps(VehicleRun run, const simulation::World& world) {
  for (Event& event : run.events) {
    const auto sensor = sensor_of(event.reading);
    const double offset = sensor == Sensor::kGps          ? world.gps_stamp_offset
                          : sensor == Sensor::kOdometer   ? world.odometer_stamp_offset
                          : sensor == Sensor::kVisualPose ? world.camera_stamp_offset
                                                          : 0.0;
    std::visit([&](auto& reading) { reading.time -= offset; }, event.reading);
  }
  return run;
}

/// Of the sideways speed of a robot that slips in proportion to the lateral force: not white noise,
/// as which the estimator takes it at each keyframe, but alike for as long as a turn or a slope.
void tell_side_slip(double side_slip, estimation::StateEstimatorParameters& p) {
  constexpr double kForce = 1;  // m/s^2, root mean square: turns at up to 2, slopes of 0.1 rad
  constexpr double kAlike = 2;  // s
  const double speed =
      side_slip * kForce * std::sqrt(estimation::covariance_factor(kAlike, p.keyframe_period));
  p.lateral_deviation = std::hypot(p.lateral_deviation, speed);
  p.odometer.across_deviation = std::hypot(p.odometer.across_deviation, speed * p.keyframe_period);
}

}  // namespace

WorldScore score_world(Vehicle vehicle, double duration, const simulation::WorldRanges& ranges,
                       std::uint64_t seed) {
  const simulation::World world = simulation::draw_world(ranges, seed);
  RunOptions options;
  options.duration = duration;
  options.gps = vehicle == Vehicle::kGroundRobot ? GpsGrade::kStandalone : GpsGrade::kRtk;
  options.world = world;
  VehicleRun run = vehicle_run(vehicle, options, seed);
  for (const Sensor sensor : {Sensor::kImu, Sensor::kOdometer, Sensor::kGps, Sensor::kVisualPose}) {
    run =
        with_loss(std::move(run), {.sensor = sensor, .share = world.lost, .longest_burst = kBurst},
                  kWholeUntil, seed + static_cast<std::uint64_t>(sensor));
  }
  const estimation::StateEstimatorParameters exact = estimator_parameters(run, options);
  estimation::StateEstimatorParameters nominal = exact;
  if (vehicle == Vehicle::kGroundRobot) {
    // The preset as it is, whose noise is that of real robots.
    const auto preset = estimation::StateEstimatorParameters::ground_robot();
    nominal.gps = preset.gps;
    nominal.odometer.share = preset.odometer.share;
    nominal.smoother.imu_noise = preset.smoother.imu_noise;
  }
  if (vehicle == Vehicle::kUav) {
    const auto preset = estimation::StateEstimatorParameters::uav();
    nominal.gps = preset.gps;
    nominal.visual_pose = preset.visual_pose;
  }
  nominal.smoother.global_deviations.odometer_scale = kNominalScaleDeviation;

  estimation::StateEstimatorParameters told = exact;
  estimation::ImuNoise& noise = told.smoother.imu_noise;
  noise.gyro *= world.imu_noise;
  noise.accelerometer *= world.imu_noise;
  noise.gyro_bias *= world.imu_noise;
  noise.accelerometer_bias *= world.imu_noise;
  told.gps.correlation_time = world.gps_correlation_time;
  told.gps.height_correlation_time = world.gps_correlation_time;
  told.smoother.globals.odometer_scale = 1 / (1 + world.wheel_scale);
  if (vehicle == Vehicle::kGroundRobot) {
    tell_side_slip(world.side_slip, told);
  }

  constexpr double kSpacing = 0.5;  // s
  const ScoreOptions score{.nees_spacing = kSpacing};
  return {.nominal = score_run(run, options, nominal, score),
          .told = score_run(with_true_stamps(run, world), options, told, score)};
}

}  // namespace pipescout::estimation_study
