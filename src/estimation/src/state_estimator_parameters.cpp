// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <numbers>
#include <stdexcept>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout::estimation {
namespace {

using validation::require;

void within(const char* field, double value, double low, double high, const char* range) {
  require(field, value, value >= low && value <= high, range);
}

template <std::size_t N, class Enumeration>
std::string_view name_of(const std::array<std::string_view, N>& names, Enumeration value) {
  const auto i = static_cast<std::size_t>(value);
  return i < N ? names[i] : "unknown";
}

void validate_start(const StartParameters& p) {
  within("start.levelling", p.levelling, 0.1, 60, "[0.1, 60]");
  within("start.still_rate", p.still_rate, 1e-6, 10, "[1e-6, 10]");
  within("start.still_force", p.still_force, 1e-6, 100, "[1e-6, 100]");
  within("start.largest_gyro_bias", p.largest_gyro_bias, 1e-6, 1, "[1e-6, 1]");
  within("start.accelerometer_bias_deviation", p.accelerometer_bias_deviation, 1e-6, 10,
         "[1e-6, 10]");
  within("start.largest_tilt", p.largest_tilt, 0.01, std::numbers::pi / 2, "[0.01, pi/2]");
  within("start.gravity_tolerance", p.gravity_tolerance, 0.01, 0.5, "[0.01, 0.5]");
  within("start.moving_tilt_deviation", p.moving_tilt_deviation, 1e-3, 1, "[1e-3, 1]");
  within("start.largest_speed", p.largest_speed, 0, 100, "[0, 100]");
  if (p.hover_speed != 0) {
    within("start.hover_speed", p.hover_speed, 1e-3, 10, "{0} or [1e-3, 10]");
  }
  within("start.heading_deviation", p.heading_deviation, 1e-3, 1, "[1e-3, 1]");
  within("start.position_fixes", static_cast<double>(p.position_fixes), 1, 1000, "[1, 1000]");
  within("start.longest_alignment", p.longest_alignment, 1, 1e4, "[1, 10000]");
  within("start.weld_heading_deviation", p.weld_heading_deviation, 1e-4, 1, "[1e-4, 1]");
}

void validate_odometer(const OdometerUse& p) {
  within("odometer.deviation", p.deviation, 1e-6, 10, "[1e-6, 10]");
  within("odometer.share", p.share, 0, 1, "[0, 1]");
  within("odometer.across_deviation", p.across_deviation, 1e-6, 100, "[1e-6, 100]");
  require(
      "odometer.no_consensus_factor", p.no_consensus_factor,
      p.no_consensus_factor == 0 || (p.no_consensus_factor >= 1 && p.no_consensus_factor <= 1000),
      "{0} or [1, 1000]");
  within("odometer.largest_speed", p.largest_speed, 0.1, 1000, "[0.1, 1000]");
  within("odometer.largest_gap", p.largest_gap, 0.01, 10, "[0.01, 10]");
  within("odometer.sensor", p.sensor.norm(), 0, 100, "[0, 100]");
}

void validate_standstill(const StandstillUse& p) {
  within("standstill.window", p.window, 0.05, 10, "[0.05, 10]");
  within("standstill.still_distance", p.still_distance, 1e-9, 1, "[1e-9, 1]");
  within("standstill.still_rate", p.still_rate, 1e-6, 10, "[1e-6, 10]");
  within("standstill.still_force", p.still_force, 1e-6, 100, "[1e-6, 100]");
  within("standstill.wheel_rate", p.wheel_rate, 1e-6, 10, "[1e-6, 10]");
  within("standstill.velocity_deviation", p.velocity_deviation, 1e-6, 10, "[1e-6, 10]");
  within("standstill.rate_deviation", p.rate_deviation, 1e-6, 10, "[1e-6, 10]");
}

/// Wheels that slip, and readings that are wrong, count for little.
Robustness slipping() {
  return {.kernel = statistics::RobustKernel::kCauchy, .width = 3};
}

void validate_watch(const char* source, const SourceWatchParameters& watch) {
  try {
    watch.validate();
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(std::string(source) + "." + wrong.what());
  }
}

}  // namespace

void StateEstimatorParameters::validate() const {
  try {
    smoother.validate();
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(std::string("smoother.") + wrong.what());
  }
  within("specific_force_scale", specific_force_scale, 1e-3, 1e3, "[1e-3, 1000]");
  within("largest_rate", largest_rate, 0.1, 1e4, "[0.1, 1e4]");
  within("largest_force", largest_force, 1, 1e6, "[1, 1e6]");
  within("spike_rate", spike_rate, 0.01, 1e4, "[0.01, 1e4]");
  within("spike_force", spike_force, 0.1, 1e6, "[0.1, 1e6]");
  within("largest_imu_gap", largest_imu_gap, 1e-4, 1, "[1e-4, 1]");
  within("keyframe_period", keyframe_period, 0.005, 10, "[0.005, 10]");
  require("keyframe_period", keyframe_period, keyframe_period <= smoother.max_step,
          "[0.005, smoother.max_step]");
  within("imu_silence", imu_silence, 0.01, 10, "[0.01, 10]");
  within("longest_wait", longest_wait, 0.1, 60, "[0.1, 60]");
  within("longest_coasting", longest_coasting, 0.1, 1e4, "[0.1, 1e4]");
  within("longest_jump", longest_jump, 0, 1e4, "[0, 1e4]");
  validate_start(start);
  validate_odometer(odometer);
  validate_standstill(standstill);
  validate_watch("gps", gps);
  validate_watch("visual_pose", visual_pose);
  validate_watch("heading", heading);
  validate_watch("weld", weld);
  const auto speed = [](const char* field, double value) {
    require(field, value, value == 0 || (value >= 1e-6 && value <= 100), "{0} or [1e-6, 100]");
  };
  speed("lateral_deviation", lateral_deviation);
  speed("vertical_deviation", vertical_deviation);
  if ((lateral_deviation == 0) != (vertical_deviation == 0)) {
    throw std::invalid_argument("vertical_deviation: 0 without lateral_deviation, or that without");
  }
  within("lateral_correlation", lateral_correlation, 0, 1000, "[0, 1000]");
  within("centre_line_deviation", centre_line_deviation, 1e-6, 100, "[1e-6, 100]");
  within("centre_line_correlation", centre_line_correlation, 0, 1000, "[0, 1000]");
  if (!tally.empty() && !centre_line) {
    throw std::invalid_argument("tally: welds lie on a centre_line, and there is none");
  }
  for (std::size_t i = 0; i < tally.size(); ++i) {
    const double least = i > 0 ? tally[i - 1] : centre_line->first_chainage();
    const double most = centre_line->last_chainage();
    if (!(tally[i] <= most && (i > 0 ? tally[i] > least : tally[i] >= least))) {
      throw std::invalid_argument("tally[" + std::to_string(i) +
                                  "]: " + validation::number_text(tally[i]) +
                                  " is not after the weld before it, or beyond the centre_line");
    }
  }
  require("own_sources", static_cast<double>(own_sources.size()),
          own_sources.size() <= kOwnFactorKinds, "at most 16");
  for (const OwnSource& source : own_sources) {
    require("own_sources.correlation_time", source.correlation_time,
            source.correlation_time >= 0 && source.correlation_time <= 1000, "[0, 1000]");
  }
}

StateEstimatorParameters StateEstimatorParameters::ground_robot() {
  StateEstimatorParameters p;
  p.smoother.global_deviations.odometer_scale = 0.02;
  p.smoother.global_deviations.mount_yaw = 0.02;
  p.smoother.global_deviations.mount_pitch = 0.02;
  p.smoother.robustness[static_cast<std::size_t>(FactorKind::kOdometer)] = slipping();
  p.lateral_deviation = 0.1;
  p.vertical_deviation = 0.1;
  p.standstill.by_odometer = true;
  // What robots show beside the noise of data sheets: wheels that slip and skid, 3 % after 10 m
  // of steps of 0.1 m; turns that come out wrong by scales, stamps and vibration, 2 degrees after
  // 10 s. A state that is surer than that holds out fixes that are right.
  p.odometer.share = 0.3;
  // Without the IMU: gravity keeps it from tilting as it turns. Taken for 0.3, the tilt after a gap
  // was one that nothing had, and gravity pulled the position off.
  p.smoother.coasting_angular_rate = 0.1;
  p.smoother.coasting_turn = 0.3;
  p.smoother.imu_noise.gyro = 0.01;
  p.smoother.imu_noise.gyro_bias = 1e-3;
  // Receivers without corrections smooth, and are off by metres for seconds. Fixes taken for
  // independent turn the heading and the gyro's bias. What lasts longer cannot be told from the
  // map's own error: the state follows it.
  p.gps.correlation_time = 1.5;
  // Heights, which wheels and IMU tell over minutes: multipath and the air last for as long.
  p.gps.height_correlation_time = 30;
  p.gps.largest_deviation_factor = 5;
  return p;
}

StateEstimatorParameters StateEstimatorParameters::uav() {
  StateEstimatorParameters p;
  p.start.largest_speed = 1;
  // It hovers or flies straight on, within some hundredths of a radian of level.
  p.smoother.coasting_angular_rate = 0.1;
  p.smoother.coasting_acceleration = 0.5;
  // RTK GPS is finer than what the smoother leaves out of a larger one: 1 - cos of it, of the way.
  p.start.heading_deviation = 0.08;
  // What poses from images are wrong by is that of what is seen, which changes within half a second
  // or so, not that of the image.
  p.visual_pose.correlation_time = 0.5;
  p.visual_pose.shortest_correlation_time = 0;
  // Multipath moves RTK fixes by more than they state, for up to a minute, and stamps are off by
  // some hundredths of a second: at 2 m/s by as many centimetres.
  p.gps.correlation_time = 20;
  p.gps.shortest_correlation_time = 0;
  p.gps.largest_deviation_factor = 5;
  p.visual_pose.largest_deviation_factor = 5;
  p.smoother.global_deviations.gps_time_offset = 0.05;
  p.smoother.global_deviations.visual_pose_time_offset = 0.05;
  return p;
}

StateEstimatorParameters StateEstimatorParameters::crawler() {
  StateEstimatorParameters p;
  p.smoother.global_deviations.odometer_scale = 0.01;
  p.smoother.robustness[static_cast<std::size_t>(FactorKind::kOdometer)] = slipping();
  p.lateral_deviation = 0.005;
  p.vertical_deviation = 0.005;
  p.lateral_correlation = 0.5;  // it weaves within a metre or so
  p.odometer.across_deviation = 0.005;
  p.centre_line_correlation = 0.5;
  p.odometer.largest_speed = 5;
  p.standstill.by_odometer = true;
  p.start.heading_from_weld = true;
  p.start.largest_tilt = 1.2;
  p.start.largest_speed = 1;
  return p;
}

std::string_view to_string(Source source) noexcept {
  constexpr std::array<std::string_view, kSources> kNames = {
      "imu", "odometer", "relative_pose", "gps", "visual_pose", "heading", "weld"};
  return name_of(kNames, source);
}

std::string_view to_string(Phase phase) noexcept {
  constexpr std::array<std::string_view, 5> kNames = {"starting", "aligning", "running", "coasting",
                                                      "fault"};
  return name_of(kNames, phase);
}

std::string_view to_string(WaitsFor what) noexcept {
  constexpr std::array<std::string_view, 6> kNames = {"nothing", "imu",     "level",
                                                      "place",   "heading", "mounting"};
  return name_of(kNames, what);
}

std::string_view to_string(RestartReason reason) noexcept {
  constexpr std::array<std::string_view, kRestartReasons> kNames = {
      "none", "time_jump_forwards", "time_jump_backwards", "numerical_failure",
      "lost", "reacquired",         "taken_over"};
  return name_of(kNames, reason);
}

}  // namespace pipescout::estimation
