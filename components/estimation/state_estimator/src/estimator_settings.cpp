// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/estimator_settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <pipescout/estimation/planar_motion.hpp>
#include <stdexcept>
#include <string_view>

#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/state_estimator/centre_line_file.hpp"
#include "pipescout/weld_ledger/tally_file.hpp"

namespace pipescout {

namespace {

using estimation::FactorKind;
using estimation::StateEstimatorParameters;
using statistics::RobustKernel;

constexpr FloatingPointRange kSeconds{0.0, 86400.0};
constexpr FloatingPointRange kMetres{-1e4, 1e4};
constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kNotNegative{0.0, 1e6};
constexpr FloatingPointRange kShare{0.0, 1.0};
constexpr FloatingPointRange kAngle{-2 * M_PI, 2 * M_PI};
constexpr std::array kKernels{RobustKernel::kNone, RobustKernel::kHuber, RobustKernel::kCauchy,
                              RobustKernel::kSaliency};

StateEstimatorParameters preset(const std::string& name) {
  if (name == "ground_robot") {
    return StateEstimatorParameters::ground_robot();
  }
  if (name == "uav") {
    return StateEstimatorParameters::uav();
  }
  if (name == "crawler") {
    return StateEstimatorParameters::crawler();
  }
  throw ParameterError("preset", "parameter 'preset': '" + name +
                                     "' is not one of 'ground_robot', 'uav', 'crawler'");
}

RobustKernel kernel(const std::string& parameter, const std::string& name) {
  for (const RobustKernel kernel : kKernels) {
    if (to_string(kernel) == name) {
      return kernel;
    }
  }
  throw std::invalid_argument("parameter '" + parameter + "': '" + name +
                              "' is not one of 'none', 'huber', 'cauchy', 'saliency'");
}

Eigen::Vector3d three_or_zero(const Parameter<std::vector<double>>& parameter) {
  return three(parameter).value_or(Eigen::Vector3d::Zero());
}

}  // namespace

EstimatorParameters::EstimatorParameters(Parameters& parameters) {
  const auto name = parameters.declare<std::string>(
      "preset", "ground_robot",
      {.description = "default values of the other parameters: ground_robot, uav or crawler",
       .read_only = true});
  defaults_ = preset(name.get());
  imu_implied_by_ = parameters.declare<std::string>(
      "imu.implied_by", "",
      {.description = "for a robot without an IMU: the source whose speed and yaw rate stand for "
                      "one, of kind odometry_velocity, base_velocity or wheel_encoders; empty: "
                      "there is an IMU",
       .read_only = true});
  if (!imu_implied_by_.share()->empty()) {
    estimation::set_planar(defaults_);
  }
  bound_.emplace(parameters, defaults_);
  declare_frames(parameters);
  declare_messages(parameters);
  declare_sensors(parameters);
  declare_start(parameters);
  declare_smoother();
  declare_use();
  declare_watch(parameters, "gps", &Estimator::gps, FactorKind::kGps);
  declare_watch(parameters, "visual_pose", &Estimator::visual_pose, FactorKind::kVisualPose);
  declare_watch(parameters, "heading", &Estimator::heading, FactorKind::kHeading);
  sources_.emplace(parameters);
}

void EstimatorParameters::declare_frames(Parameters& parameters) {
  map_frame_ = parameters.declare<std::string>("map_frame", "map",
                                               {.description = "frame of odometry/filtered"});
  odom_frame_ = parameters.declare<std::string>("odom_frame", "odom",
                                                {.description = "continuous frame (REP 105)"});
  base_frame_ =
      parameters.declare<std::string>("base_frame", "base_link", {.description = "of the robot"});
  rack_frame_ =
      parameters.declare<std::string>("rack_frame", "rack", {.description = "frame of rack/pose"});
  publish_tf_ = parameters.declare<bool>(
      "publish_tf", true,
      {.description = "publish map -> odom, odom -> base and, with visual poses, map -> rack"});
  publish_period_ = parameters.declare<double>(
      "publish_period", 0.0,
      {.description = "s between two published states; 0: one for each reading of the IMU",
       .floating_point_range = kSeconds});
}

void EstimatorParameters::declare_messages(Parameters& parameters) {
  maximum_age_ = parameters.declare<double>(
      "maximum_age", 1.0,
      {.description =
           "s, messages with an older stamp are counted as stale; 0: any age is accepted",
       .floating_point_range = kSeconds});
  maximum_lead_ = parameters.declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, messages with a stamp further ahead of the clock are refused",
       .floating_point_range = kSeconds});
  silent_after_ = parameters.declare<double>(
      "silent_after", 2.0,
      {.description = "s without a reading of the IMU after which imu.silent is counted",
       .floating_point_range = kPositive});
}

void EstimatorParameters::declare_sensors(Parameters& parameters) {
  const auto place = [&parameters](const char* name, const char* what) {
    return parameters.declare<std::vector<double>>(
        name, {},
        {.description = std::string("m, x y z of ") + what + " in the base frame; empty: 0 0 0"});
  };
  imu_position_ = place("imu.position", "the IMU");
  imu_roll_pitch_yaw_ = parameters.declare<std::vector<double>>(
      "imu.roll_pitch_yaw", {}, {.description = "rad, of the IMU in the base frame; empty: 0 0 0"});
  bound_->real(
      "imu.gyro_noise", [](auto& p) -> double& { return p.smoother.imu_noise.gyro; }, {1e-9, 10},
      "rad/s/sqrt(Hz)");
  bound_->real(
      "imu.gyro_scale_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.gyro_scale; }, kShare,
      "standard deviation of the scale error of an axis; 0: not estimated");
  bound_->real(
      "imu.gyro_misalignment_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.gyro_misalignment; }, kShare,
      "rad, standard deviation of the misalignment of an axis; 0: not estimated");
  bound_->real(
      "imu.accelerometer_scale_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.accelerometer_scale; }, kShare,
      "as imu.gyro_scale_deviation");
  bound_->real(
      "imu.accelerometer_misalignment_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.accelerometer_misalignment; },
      kShare, "rad, as imu.gyro_misalignment_deviation");
  bound_->real(
      "imu.accelerometer_noise",
      [](auto& p) -> double& { return p.smoother.imu_noise.accelerometer; }, {1e-9, 1000},
      "m/s^2/sqrt(Hz)");
  bound_->real(
      "imu.gyro_bias_walk", [](auto& p) -> double& { return p.smoother.imu_noise.gyro_bias; },
      {1e-9, 1}, "rad/s^2/sqrt(Hz)");
  bound_->real(
      "imu.accelerometer_bias_walk",
      [](auto& p) -> double& { return p.smoother.imu_noise.accelerometer_bias; }, {1e-9, 100},
      "m/s^3/sqrt(Hz)");
  bound_->real(
      "gravity", [](auto& p) -> double& { return p.smoother.gravity; }, {0, 100}, "m/s^2, local");

  bound_->real(
      "imu.specific_force_scale", [](auto& p) -> double& { return p.specific_force_scale; },
      {1e-3, 1e3}, "factor from its linear acceleration to m/s^2: 9.80665 for an IMU in g");

  gps_antenna_ = place("gps.position", "the antenna");
  earth_ = parameters.declare<bool>(
      "earth", true,
      {.description = "once the origin of the map is known: gravity is along the vertical of the "
                      "place, and the gyro sees the Earth turn; false: a flat Earth at rest, as "
                      "simulators have it"});
  datum_ = parameters.declare<std::vector<double>>(
      "datum", {},
      {.description =
           "latitude and longitude in degrees and altitude in m of the origin of the map; "
           "empty: the first of five fixes that agree"});
  gps_deviation_ = parameters.declare<double>(
      "gps.deviation", 2.0,
      {.description =
           "m, standard deviation per axis of fixes without covariance; 0: such fixes are refused",
       .floating_point_range = kNotNegative});
  least_gps_deviation_ = parameters.declare<double>(
      "gps.least_deviation", 0.01,
      {.description = "m, lower bound of the standard deviation of a fix per axis",
       .floating_point_range = kPositive});

  heading_from_imu_ = parameters.declare<bool>(
      "heading.from_imu", false,
      {.description = "use headings from the orientation in imu/data, for an IMU with a compass"});
  heading_deviation_ = parameters.declare<double>(
      "heading.deviation", 0.1,
      {.description = "rad, standard deviation of headings without covariance",
       .floating_point_range = kPositive});

  camera_.emplace(parameters, base_frame_);
  camera_position_deviation_ = parameters.declare<double>(
      "camera.position_deviation", 0.0,
      {.description = "m, standard deviation of the camera's position per axis; 0: not estimated",
       .floating_point_range = kNotNegative});
  camera_rotation_deviation_ = parameters.declare<double>(
      "camera.rotation_deviation", 0.0,
      {.description = "rad, standard deviation of its rotation per axis; 0: not estimated",
       .floating_point_range = kShare});
  rack_position_ = parameters.declare<std::vector<double>>(
      "rack.position", {}, {.description = "m, of the rack frame in the map; empty: 0 0 0"});
  rack_heading_ = parameters.declare<double>(
      "rack.heading", 0.0,
      {.description = "rad, from the map's x axis to the rack's", .floating_point_range = kAngle});
  bound_->real(
      "rack.position_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.rack_position; }, kNotNegative,
      "m, standard deviation per axis; 0: the position of the rack is known");
  bound_->real(
      "rack.rotation_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.rack_rotation; }, kNotNegative,
      "rad, standard deviation per axis; 0: the orientation of the rack is known");

  odometer_ = place("odometer.position", "the point whose path the odometers measure");
  weld_sensor_ = place("weld.position", "the weld probe");
  least_weld_probability_ = parameters.declare<double>(
      "weld.least_probability", 0.99,
      {.description = "smallest probability of the data association of a weld that is used",
       .floating_point_range = kShare});
  weld_deviation_ = parameters.declare<double>(
      "weld.across_deviation", 0.05,
      {.description = "m, standard deviation of the probe's distance from the centre line",
       .floating_point_range = kPositive});
  tally_ = parameters.declare<std::string>(
      "weld.tally", "",
      {.description = "CSV file with the pipe's tally or weld ledger: a weld with a wrong data "
                      "association is associated again by the state; empty: it is not used"});
  centre_line_ = parameters.declare<std::string>(
      "centre_line.file", "",
      {.description = "CSV file with the points x, y, z (m, in the map) of the pipe's centre line; "
                      "empty: none, and welds are not used"});
  centre_line_first_chainage_ = parameters.declare<double>(
      "centre_line.first_chainage", 0.0,
      {.description = "m, of its first point", .floating_point_range = {{-1e7, 1e7}}});
  bound_->real(
      "centre_line.deviation", [](auto& p) -> double& { return p.centre_line_deviation; },
      {1e-6, 100}, "m, standard deviation of the body's distance from the centre line");
  bound_->real(
      "centre_line.correlation", [](auto& p) -> double& { return p.centre_line_correlation; },
      {0, 1000}, "m, correlation length of that distance; the line is used once per this length");
}

void EstimatorParameters::declare_start(Parameters& parameters) {
  start_position_ = parameters.declare<std::vector<double>>(
      "start.position", {}, {.description = "m, of the base in the map; empty: unknown"});
  start_position_deviation_ = parameters.declare<double>(
      "start.position_deviation", 0.5,
      {.description = "m, per axis", .floating_point_range = FloatingPointRange{1e-3, 1e4}});
  start_heading_ = parameters.declare<std::vector<double>>(
      "start.heading", {},
      {.description =
           "rad, of the base's x axis from the map's, and its standard deviation; empty: "
           "unknown"});
  bound_->real(
      "start.levelling", [](auto& p) -> double& { return p.start.levelling; }, {0.1, 60},
      "s of IMU readings for levelling");
  bound_->real(
      "start.still_rate", [](auto& p) -> double& { return p.start.still_rate; }, {1e-6, 10},
      "rad/s, largest standard deviation of the gyro at standstill");
  bound_->real(
      "start.still_force", [](auto& p) -> double& { return p.start.still_force; }, {1e-6, 100},
      "m/s^2, the same of the accelerometer");
  bound_->real(
      "start.largest_gyro_bias", [](auto& p) -> double& { return p.start.largest_gyro_bias; },
      {1e-6, 1}, "rad/s, a larger mean rate is a rotation");
  bound_->real(
      "start.accelerometer_bias_deviation",
      [](auto& p) -> double& { return p.start.accelerometer_bias_deviation; }, {1e-6, 10}, "m/s^2");
  bound_->real(
      "start.largest_tilt", [](auto& p) -> double& { return p.start.largest_tilt; }, {0.01, M_PI_2},
      "rad: gravity further from the base's z axis is a fault of the mounting");
  bound_->real(
      "start.gravity_tolerance", [](auto& p) -> double& { return p.start.gravity_tolerance; },
      {0.01, 0.5}, "largest relative deviation of the mean specific force from gravity");
  bound_->real(
      "start.largest_speed", [](auto& p) -> double& { return p.start.largest_speed; }, {0, 100},
      "m/s, of a robot that is not at standstill");
  bound_->real(
      "start.hover_speed", [](auto& p) -> double& { return p.start.hover_speed; }, {0, 10},
      "m/s, standard deviation of the velocity of a robot that hovers until it is initialised in "
      "the map; 0: no assumption");
  bound_->real(
      "start.heading_deviation", [](auto& p) -> double& { return p.start.heading_deviation; },
      {1e-3, 1}, "rad, largest standard deviation of a heading from motion that is accepted");
  bound_->count(
      "start.position_fixes", [](auto& p) -> std::size_t& { return p.start.position_fixes; },
      {1, 1000}, "number of GPS positions that must agree first");
  bound_->real(
      "start.longest_alignment", [](auto& p) -> double& { return p.start.longest_alignment; },
      {1, 10000}, "s, after which the heading from motion is restarted");
  bound_->boolean(
      "start.heading_from_weld", [](auto& p) -> bool& { return p.start.heading_from_weld; },
      "the base's x axis points along the pipe, towards greater chainage");
}

void EstimatorParameters::declare_smoother() {
  bound_->real(
      "lag", [](auto& p) -> double& { return p.smoother.lag; }, {0.01, 1000},
      "s, length of the smoother's window; older measurements are refused");
  bound_->real(
      "keyframe_period", [](auto& p) -> double& { return p.keyframe_period; }, {0.005, 10},
      "s between keyframes");
  bound_->real(
      "imu_silence", [](auto& p) -> double& { return p.imu_silence; }, {0.01, 10},
      "s without readings of the IMU after which the state coasts on the other sensors");
  bound_->real(
      "longest_wait", [](auto& p) -> double& { return p.longest_wait; }, {0.1, 60},
      "s for which measurements that are ahead of the IMU wait for it");
  bound_->real(
      "longest_coasting", [](auto& p) -> double& { return p.longest_coasting; }, {0.1, 1e4},
      "s of coasting after which the state is discarded");
  bound_->real(
      "longest_jump", [](auto& p) -> double& { return p.longest_jump; }, {0, 1e4},
      "s, largest jump in time without a new initialisation");
  bound_->real(
      "odometer.scale_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.odometer_scale; }, kNotNegative,
      "standard deviation of the scale of the fused odometer; 0: not estimated");
  bound_->real(
      "odometer.mount_yaw", [](auto& p) -> double& { return p.smoother.globals.mount_yaw; }, kAngle,
      "rad, of the direction of travel in the base frame");
  bound_->real(
      "odometer.mount_yaw_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.mount_yaw; }, kNotNegative,
      "rad, its standard deviation; 0: not estimated");
  bound_->real(
      "odometer.mount_pitch_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.mount_pitch; }, kNotNegative,
      "rad, the same up and down");
  bound_->real(
      "gps.position_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.gps_lever_arm; }, kNotNegative,
      "m, standard deviation of gps.position per axis; 0: not estimated");
  bound_->real(
      "gps.time_offset_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.gps_time_offset; }, kNotNegative,
      "s, standard deviation of the time offset of fixes; 0: not estimated");
  bound_->real(
      "visual_pose.time_offset_deviation",
      [](auto& p) -> double& { return p.smoother.global_deviations.visual_pose_time_offset; },
      kNotNegative, "s, standard deviation of the time offset of visual poses; 0: not estimated");
}

void EstimatorParameters::declare_use() {
  bound_->real(
      "odometer.deviation", [](auto& p) -> double& { return p.odometer.deviation; }, {1e-6, 10},
      "m, standard deviation added to each step between keyframes");
  bound_->real(
      "odometer.share", [](auto& p) -> double& { return p.odometer.share; }, kShare,
      "share of the step, added to the standard deviation");
  bound_->real(
      "odometer.across_deviation", [](auto& p) -> double& { return p.odometer.across_deviation; },
      {1e-6, 100}, "m, lateral slip between keyframes");
  bound_->real(
      "odometer.no_consensus_factor",
      [](auto& p) -> double& { return p.odometer.no_consensus_factor; }, {0, 1000},
      "factor on the standard deviations if the odometers are inconsistent; 0: not used then");
  bound_->real(
      "odometer.largest_speed", [](auto& p) -> double& { return p.odometer.largest_speed; },
      {0.1, 1000}, "m/s, a larger speed is a reset of the counter");
  bound_->boolean(
      "standstill.by_odometer", [](auto& p) -> bool& { return p.standstill.by_odometer; },
      "standstill if the distance does not change and the gyro noise is low");
  bound_->boolean(
      "standstill.by_imu", [](auto& p) -> bool& { return p.standstill.by_imu; },
      "standstill if gyro and accelerometer noise are low; not for robots that hover or roll "
      "evenly");
  bound_->real(
      "standstill.window", [](auto& p) -> double& { return p.standstill.window; }, {0.05, 10},
      "s for which the condition must hold");
  bound_->real(
      "standstill.rate", [](auto& p) -> double& { return p.standstill.still_rate; }, {1e-6, 10},
      "rad/s, largest gyro noise at standstill");
  bound_->real(
      "standstill.force", [](auto& p) -> double& { return p.standstill.still_force; }, {1e-6, 100},
      "m/s^2, the same");
  bound_->real(
      "standstill.wheel_rate", [](auto& p) -> double& { return p.standstill.wheel_rate; },
      {1e-6, 10}, "rad/s, largest yaw rate that wheels say at standstill");
  bound_->real(
      "non_holonomic.lateral_deviation", [](auto& p) -> double& { return p.lateral_deviation; },
      {0, 100}, "m/s, standard deviation of lateral slip; 0: no constraint");
  bound_->real(
      "non_holonomic.vertical_deviation", [](auto& p) -> double& { return p.vertical_deviation; },
      {0, 100}, "m/s, standard deviation of vertical slip");
  bound_->real(
      "non_holonomic.correlation", [](auto& p) -> double& { return p.lateral_correlation; },
      {0, 1000}, "m, correlation length of the slip: the constraint is used once per this length");
}

void EstimatorParameters::declare_watch(Parameters& parameters, const std::string& source,
                                        estimation::SourceWatchParameters Estimator::*watch,
                                        FactorKind kind) {
  const auto robustness = static_cast<std::size_t>(kind);
  bound_->real(
      source + ".gate",
      [robustness](auto& p) -> double& {
        return p.smoother.robustness[robustness].gate_probability;
      },
      kShare, "share of correct measurements that the chi-square gate accepts; 1: no gate");
  kernels_.push_back(
      {kind, parameters.declare<std::string>(
                 source + ".kernel",
                 std::string(to_string(defaults_.smoother.robustness[robustness].kernel)),
                 {.description = "robust kernel: none, huber, cauchy or saliency"})});
  bound_->real(
      source + ".kernel_width",
      [robustness](auto& p) -> double& { return p.smoother.robustness[robustness].width; },
      {1e-3, 1e3}, "of the kernel, in standard deviations");
  bound_->real(
      source + ".correlation_time",
      [watch](auto& p) -> double& { return (p.*watch).correlation_time; }, {0, 1000},
      "s, correlation time of the measurement errors, such as multipath; 0: white");
  bound_->real(
      source + ".shortest_correlation_time",
      [watch](auto& p) -> double& { return (p.*watch).shortest_correlation_time; }, {0, 1000},
      "s, below correlation_time: that is found on line between both, from the innovations");
  if (kind == FactorKind::kGps) {
    bound_->real(
        source + ".height_correlation_time",
        [watch](auto& p) -> double& { return (p.*watch).height_correlation_time; }, {0, 1000},
        "s, correlation time of the errors of heights, where it is longer than correlation_time");
  }
  bound_->real(
      source + ".largest_deviation_factor",
      [watch](auto& p) -> double& { return (p.*watch).largest_deviation_factor; }, {1, 100},
      "standard deviations are taken for up to this factor larger than stated; 1: as stated");
  bound_->real(
      source + ".outage", [watch](auto& p) -> double& { return (p.*watch).outage; }, {0.1, 1000},
      "s without a measurement after which the source must prove consistent again");
  bound_->count(
      source + ".doubt_after", [watch](auto& p) -> std::size_t& { return (p.*watch).doubt_after; },
      {1, 10000}, "number of gated measurements in a row after which the source is no longer used");
  bound_->count(
      source + ".agreeing", [watch](auto& p) -> std::size_t& { return (p.*watch).agreeing; },
      {2, 10000}, "number of measurements that must agree before the source is used");
  bound_->real(
      source + ".agreeing_time", [watch](auto& p) -> double& { return (p.*watch).agreeing_time; },
      {0, 1000}, "s that these must span");
  bound_->real(
      source + ".drift_share", [watch](auto& p) -> double& { return (p.*watch).drift_share; },
      kShare,
      "possible error of dead reckoning as a share of the distance: a source farther away is not "
      "used");
  bound_->real(
      source + ".drift_floor", [watch](auto& p) -> double& { return (p.*watch).drift_floor; },
      {0, 1000}, "m (rad for headings), smallest possible error of dead reckoning");
  bound_->real(
      source + ".takeover", [watch](auto& p) -> double& { return (p.*watch).takeover; }, {1, 1e6},
      "s of consistency with the motion after which the source resets a contradicting state");
  bound_->real(
      source + ".confirmed_takeover",
      [watch](auto& p) -> double& { return (p.*watch).confirmed_takeover; }, {1, 1e6},
      "s, the same if absolute measurements had confirmed the state");
}

std::optional<estimation::GivenPose> EstimatorParameters::start() const {
  estimation::GivenPose result;
  if (const auto position = three(start_position_)) {
    result.position = *position;
    result.position_deviation = start_position_deviation_.get();
  }
  if (const std::vector<double>& heading = *start_heading_.share(); !heading.empty()) {
    if (heading.size() != 2 || !std::isfinite(heading[0]) ||
        !(heading[1] >= 1e-4 && heading[1] <= 1)) {
      throw std::invalid_argument(
          "parameter 'start.heading' must be empty or two numbers: an angle and its standard "
          "deviation in [0.0001, 1] rad");
    }
    result.heading = heading[0];
    result.heading_deviation = heading[1];
  }
  if (!result.position && !result.heading) {
    return std::nullopt;
  }
  return result;
}

int EstimatorParameters::camera_mounting(Estimator& estimator) const {
  const double position = camera_position_deviation_.get();
  const double rotation = camera_rotation_deviation_.get();
  if (position == 0 && rotation == 0) {
    return -1;
  }
  try {
    return estimator.smoother.estimate_camera_mounting(position, rotation);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameters '" + camera_position_deviation_.name() + "', '" +
                                camera_rotation_deviation_.name() + "': " + error.what());
  }
}

std::optional<std::size_t> EstimatorParameters::implied_imu(
    const std::vector<NamedSource>& sources) const {
  const std::string name = imu_implied_by_.get();
  if (name.empty()) {
    return std::nullopt;
  }
  const auto found = std::ranges::find(sources, name, &NamedSource::name);
  if (found == sources.end() || (found->kind != NamedSourceKind::kOdometryVelocity &&
                                 found->kind != NamedSourceKind::kBaseVelocity &&
                                 found->kind != NamedSourceKind::kWheelEncoders)) {
    throw std::invalid_argument("parameter '" + imu_implied_by_.name() + "': '" + name +
                                "' is no source of kind odometry_velocity, base_velocity or "
                                "wheel_encoders");
  }
  if (!three_or_zero(imu_position_).isZero()) {
    throw std::invalid_argument("parameter '" + imu_position_.name() +
                                "': an IMU that wheels stand for is at 0 0 0");
  }
  return static_cast<std::size_t>(found - sources.begin());
}

EstimatorSettings EstimatorParameters::read(Node& node) const {
  EstimatorSettings result;
  result.map_frame = map_frame_.get();
  result.odom_frame = odom_frame_.get();
  result.base_frame = base_frame_.get();
  result.rack_frame = rack_frame_.get();
  result.publish_tf = publish_tf_.get();
  result.publish_period = from_seconds(publish_period_.get());
  result.stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  result.silent_after = silent_after_.get();
  if (const auto datum = three(datum_)) {
    result.datum = geometry::GeodeticPosition{datum->x(), datum->y(), datum->z()};
    try {
      result.datum->validate();
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string("parameter 'datum': ") + error.what());
    }
  }
  result.earth = earth_.get();
  result.gps_deviation = gps_deviation_.get();
  result.least_gps_deviation = least_gps_deviation_.get();
  result.heading_from_imu = heading_from_imu_.get();
  result.heading_deviation = heading_deviation_.get();
  result.least_weld_probability = least_weld_probability_.get();
  result.weld_deviation = weld_deviation_.get();
  result.weld_sensor = three_or_zero(weld_sensor_);
  result.imu = three_or_zero(imu_position_);
  result.camera = camera_->read(node);
  result.start = start();

  Estimator& estimator = result.estimator = bound_->read();
  for (const Kernel& bound : kernels_) {
    estimator.smoother.robustness[static_cast<std::size_t>(bound.kind)].kernel =
        kernel(bound.parameter.name(), bound.parameter.get());
  }
  result.sources = sources_->read(estimator);
  result.implied_imu = implied_imu(result.sources);
  result.camera_mounting = camera_mounting(estimator);
  estimator.R_body_imu = geometry::SO3::from_roll_pitch_yaw(three_or_zero(imu_roll_pitch_yaw_));
  estimator.odometer.sensor = three_or_zero(odometer_) - result.imu;
  if (const auto& deviations = estimator.smoother.global_deviations;
      deviations.mount_yaw > 0 || deviations.mount_pitch > 0) {
    // See GlobalDeviations: else the mount is found wrong by several deviations.
    constexpr double kMountRotation = 1e-3;
    double& rotation = estimator.smoother.relinearisation.rotation;
    rotation = std::min(rotation, kMountRotation);
  }
  estimator.smoother.globals.gps_lever_arm = three_or_zero(gps_antenna_) - result.imu;
  estimator.smoother.globals.rack_position = three_or_zero(rack_position_);
  estimator.smoother.globals.R_map_rack = geometry::SO3::about_z(rack_heading_.get());
  if (const std::string file = centre_line_.get(); !file.empty()) {
    estimator.centre_line = read_centre_line(file, centre_line_first_chainage_.get());
  }
  if (const std::string file = tally_.get(); !file.empty()) {
    estimator.tally = read_tally(file).chainages;
  }
  estimator.validate();
  return result;
}

}  // namespace pipescout
