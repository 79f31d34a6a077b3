// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/named_sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "pipescout/message_conversions/mounting_parameters.hpp"

namespace pipescout {

namespace {

using estimation::StateEstimatorParameters;

constexpr std::array<std::string_view, kNamedSourceKinds> kKinds = {
    "gps_velocity",   "gps_velocity_with_covariance",
    "base_velocity",  "odometry_velocity",
    "odometry_pose",  "magnetic_field",
    "fluid_pressure", "range",
    "gps_fix",        "wheel_encoders"};

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kNotNegative{0.0, 1e6};
constexpr FloatingPointRange kShare{0.0, 1.0};
constexpr FloatingPointRange kAngle{-M_PI, M_PI};
constexpr FloatingPointRange kSeconds{0.0, 1000.0};

NamedSourceKind kind_named(const std::string& parameter, const std::string& name) {
  const auto found = std::ranges::find(kKinds, name);
  if (found == kKinds.end()) {
    std::string all;
    for (const std::string_view kind : kKinds) {
      all += (all.empty() ? "'" : ", '") + std::string(kind) + "'";
    }
    throw ParameterError(parameter,
                         "parameter '" + parameter + "': '" + name + "' is not one of " + all);
  }
  return static_cast<NamedSourceKind>(found - kKinds.begin());
}

/// Of one axis: m/s, rad or m.
double default_deviation(NamedSourceKind kind) {
  switch (kind) {
    case NamedSourceKind::kGpsVelocity:
    case NamedSourceKind::kGpsVelocityWithCovariance:
    case NamedSourceKind::kBaseVelocity:
    case NamedSourceKind::kOdometryVelocity:
    case NamedSourceKind::kWheelEncoders:
      return 0.1;
    case NamedSourceKind::kOdometryPose:
      return 0.02;
    case NamedSourceKind::kMagneticField:
      return 0.1;
    case NamedSourceKind::kFluidPressure:
      return 0.5;
    case NamedSourceKind::kRange:
      return 0.3;
    case NamedSourceKind::kGpsFix:
      return 2;
  }
  return 1;
}

}  // namespace

std::string_view to_string(NamedSourceKind kind) noexcept {
  const auto i = static_cast<std::size_t>(kind);
  return i < kKinds.size() ? kKinds[i] : "unknown";
}

NamedSourceParameters::NamedSourceParameters(Parameters& parameters) {
  const auto names =
      parameters
          .declare<std::vector<std::string>>(
              "sources", {},
              {.description = "names of further sources; parameters of each begin with its name",
               .read_only = true})
          .get();
  for (const std::string& name : names) {
    const auto number = [&](const char* what, double value, FloatingPointRange range,
                            const char* description) {
      return parameters.declare<double>(
          name + "." + what, value, {.description = description, .floating_point_range = range});
    };
    const auto numbers = [&](const char* what, const char* description) {
      return parameters.declare<std::vector<double>>(name + "." + what, {},
                                                     {.description = description});
    };
    const auto kind = kind_named(
        name + ".kind",
        parameters
            .declare_required<std::string>(
                name + ".kind",
                {.description = "what it measures, and by which message", .read_only = true})
            .get());
    const auto joints = [&](const char* side) {
      return parameters.declare<std::vector<std::string>>(
          name + "." + side, {},
          {.description =
               std::string("joints of the wheels on the ") + side + ", of wheel_encoders"});
    };
    // The height of the standard atmosphere is off by the weather, and from the map's by the datum.
    const bool pressure = kind == NamedSourceKind::kFluidPressure;
    declared_.push_back(
        {.name = name,
         .kind = kind,
         .topic =
             parameters.declare<std::string>(name + ".topic", name, {.description = "its topic"}),
         .position = numbers("position", "m, in the base frame; empty: from tf"),
         .roll_pitch_yaw = numbers("roll_pitch_yaw", "rad, with a position; empty: 0 0 0"),
         .deviation = number("deviation", default_deviation(kind), kPositive,
                             "m/s, rad or m, standard deviation per axis of messages without "
                             "covariance"),
         .rotation_deviation =
             number("rotation_deviation", 0.005, kPositive, "rad, of a step of odometry_pose"),
         .declination = number("declination", 0, kAngle,
                               "rad, of magnetic north from the map's y axis, east positive"),
         .beacon = numbers("beacon", "m, of the beacon of a range, in the map"),
         .bias_deviation = number("bias_deviation", pressure ? 1000 : 0, kNotNegative,
                                  "m or rad, of its bias, which is estimated; 0: it has none; of "
                                  "magnetic_field, fluid_pressure and range"),
         .bias_walk = number("bias_walk", pressure ? 0.02 : 0, kNotNegative,
                             "per sqrt(s), random walk of the bias"),
         .correlation_time = number("correlation_time", 0, kSeconds,
                                    "s, correlation time of the measurement errors; 0: white"),
         .gate = number("gate", 0.9999, kShare,
                        "share of correct measurements that the chi-square gate accepts; 1: no "
                        "gate"),
         .left = joints("left"),
         .right = joints("right"),
         .wheel_radius = number("wheel_radius", 0, kNotNegative, "m, of wheel_encoders"),
         .track = number("track", 0, kNotNegative,
                         "m between the wheels of both sides, of wheel_encoders")});
  }
}

std::vector<NamedSource> NamedSourceParameters::read(StateEstimatorParameters& estimator) const {
  if (declared_.size() > estimation::kOwnFactorKinds) {
    throw std::invalid_argument("parameter 'sources': more than " +
                                std::to_string(estimation::kOwnFactorKinds) + " names");
  }
  std::vector<NamedSource> sources;
  int biases = 0;
  for (const Declared& declared : declared_) {
    const std::size_t place = sources.size();
    NamedSource& source = sources.emplace_back();
    source.name = declared.name;
    source.kind = declared.kind;
    source.topic = declared.topic.get();
    source.position = three(declared.position);
    source.R_base_sensor = geometry::SO3::from_roll_pitch_yaw(
        three(declared.roll_pitch_yaw).value_or(Eigen::Vector3d::Zero()));
    source.deviation = declared.deviation.get();
    source.rotation_deviation = declared.rotation_deviation.get();
    source.declination = declared.declination.get();
    const auto beacon = three(declared.beacon);
    if (source.kind == NamedSourceKind::kRange && !beacon) {
      throw std::invalid_argument("parameter '" + declared.name +
                                  ".beacon': a range needs the position of its beacon");
    }
    if (source.kind == NamedSourceKind::kWheelEncoders) {
      source.wheels = {.left = declared.left.get(),
                       .right = declared.right.get(),
                       .wheel_radius = declared.wheel_radius.get(),
                       .track = declared.track.get()};
      try {
        source.wheels.validate();
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("parameters of source '" + declared.name +
                                    "': " + error.what());
      }
    }
    source.beacon = beacon.value_or(Eigen::Vector3d::Zero());
    const bool may_be_biased = source.kind == NamedSourceKind::kMagneticField ||
                               source.kind == NamedSourceKind::kFluidPressure ||
                               source.kind == NamedSourceKind::kRange;
    if (const double deviation = declared.bias_deviation.get(); may_be_biased && deviation > 0) {
      if (biases == estimation::kOwnSize) {
        throw std::invalid_argument("parameter '" + declared.name + ".bias_deviation': more than " +
                                    std::to_string(estimation::kOwnSize) + " sources have a bias");
      }
      source.bias = biases++;
      estimator.smoother.global_deviations.own[source.bias] = deviation;
      estimator.smoother.own_walks[source.bias] = declared.bias_walk.get();
    }
    estimator.own_sources.push_back({.correlation_time = declared.correlation_time.get()});
    const auto kind = static_cast<std::size_t>(estimation::own_kind(place));
    estimator.smoother.robustness[kind].gate_probability = declared.gate.get();
  }
  return sources;
}

}  // namespace pipescout
