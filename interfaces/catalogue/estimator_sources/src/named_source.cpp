// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimator_sources/named_source.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <stdexcept>

namespace pipescout {

namespace {

struct KindTraits {
  std::string_view name;
  std::string_view message;
  double deviation;  // default, of one axis: m/s, rad or m
};

/// By NamedSourceKind.
constexpr std::array<KindTraits, kNamedSourceKinds> kKinds = {
    KindTraits{"gps_velocity", "geometry_msgs/msg/TwistStamped", 0.1},
    KindTraits{"gps_velocity_with_covariance", "geometry_msgs/msg/TwistWithCovarianceStamped", 0.1},
    KindTraits{"base_velocity", "geometry_msgs/msg/TwistWithCovarianceStamped", 0.1},
    KindTraits{"odometry_velocity", "nav_msgs/msg/Odometry", 0.1},
    KindTraits{"odometry_pose", "nav_msgs/msg/Odometry", 0.02},
    KindTraits{"magnetic_field", "sensor_msgs/msg/MagneticField", 0.1},
    KindTraits{"fluid_pressure", "sensor_msgs/msg/FluidPressure", 0.5},
    KindTraits{"range", "sensor_msgs/msg/Range", 0.3},
    KindTraits{"gps_fix", "sensor_msgs/msg/NavSatFix", 2},
    KindTraits{"pose", "geometry_msgs/msg/PoseWithCovarianceStamped", 0.05},
    KindTraits{"wheel_encoders", "sensor_msgs/msg/JointState", 0.1}};

constexpr double kSmallest = 1e-9;
constexpr double kLargest = 1e6;
constexpr std::array<NamedSourceNumber, 10> kNumbers = {
    NamedSourceNumber{"deviation", &NamedSource::deviation, kSmallest, kLargest,
                      "m/s, rad or m, standard deviation per axis of messages without covariance"},
    NamedSourceNumber{"rotation_deviation", &NamedSource::rotation_deviation, kSmallest, kLargest,
                      "rad, of a step of odometry_pose, and of a pose without covariance"},
    NamedSourceNumber{"declination", &NamedSource::declination, -std::numbers::pi, std::numbers::pi,
                      "rad, of magnetic north from the map's y axis, east positive"},
    NamedSourceNumber{"bias_deviation", &NamedSource::bias_deviation, 0, kLargest,
                      "m or rad, of its bias, which is estimated; 0: it has none; of "
                      "magnetic_field, fluid_pressure and range"},
    NamedSourceNumber{"bias_walk", &NamedSource::bias_walk, 0, kLargest,
                      "per sqrt(s), random walk of the bias"},
    NamedSourceNumber{"mounting_position_deviation", &NamedSource::mounting_position_deviation, 0,
                      1e3,
                      "m per axis, of the sensor of a pose on the robot, which is estimated; 0: it "
                      "is known"},
    NamedSourceNumber{"mounting_rotation_deviation", &NamedSource::mounting_rotation_deviation, 0,
                      1, "rad per axis, the same"},
    NamedSourceNumber{"time_offset_deviation", &NamedSource::time_offset_deviation, 0, 10,
                      "s, of the delay of a pose after its stamp, which is estimated; 0: it has "
                      "none"},
    NamedSourceNumber{"correlation_time", &NamedSource::correlation_time, 0, 1000,
                      "s, correlation time of the measurement errors; 0: white"},
    NamedSourceNumber{"gate", &NamedSource::gate, 0, 1,
                      "share of correct measurements that the chi-square gate accepts; 1: no "
                      "gate"}};

const KindTraits* traits_of(NamedSourceKind kind) noexcept {
  const auto i = static_cast<std::size_t>(kind);
  return i < kKinds.size() ? &kKinds[i] : nullptr;
}

bool may_be_biased(NamedSourceKind kind) {
  return kind == NamedSourceKind::kMagneticField || kind == NamedSourceKind::kFluidPressure ||
         kind == NamedSourceKind::kRange;
}

void require_what_its_kind_needs(const NamedSource& source) {
  if (source.kind == NamedSourceKind::kRange && !source.beacon) {
    throw std::invalid_argument("'" + source.name +
                                ".beacon': a range needs the position of its beacon");
  }
  if (source.kind == NamedSourceKind::kWheelEncoders) {
    try {
      source.wheels.validate();
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("source '" + source.name + "': " + error.what());
    }
  }
}

}  // namespace

std::string_view to_string(NamedSourceKind kind) noexcept {
  const KindTraits* traits = traits_of(kind);
  return traits != nullptr ? traits->name : "unknown";
}

std::string_view message_type_of(NamedSourceKind kind) noexcept {
  const KindTraits* traits = traits_of(kind);
  return traits != nullptr ? traits->message : "";
}

std::optional<NamedSourceKind> named_source_kind(std::string_view name) noexcept {
  const auto found = std::ranges::find(kKinds, name, &KindTraits::name);
  return found == kKinds.end()
             ? std::nullopt
             : std::optional(static_cast<NamedSourceKind>(found - kKinds.begin()));
}

std::string all_named_source_kinds() {
  std::string all;
  for (const KindTraits& kind : kKinds) {
    all += (all.empty() ? "'" : ", '") + std::string(kind.name) + "'";
  }
  return all;
}

NamedSource default_source(const std::string& name, NamedSourceKind kind) {
  NamedSource source{.name = name, .kind = kind, .topic = name};
  if (const KindTraits* traits = traits_of(kind)) {
    source.deviation = traits->deviation;
  }
  if (kind == NamedSourceKind::kFluidPressure) {
    // The height of the standard atmosphere is off by the weather, and from the map's by the datum.
    source.bias_deviation = 1000;
    source.bias_walk = 0.02;
  }
  if (kind == NamedSourceKind::kPose) {
    source.rotation_deviation = 0.02;
  }
  return source;
}

std::span<const NamedSourceNumber> named_source_numbers() noexcept {
  return kNumbers;
}

void place_sources(std::vector<NamedSource>& sources,
                   estimation::StateEstimatorParameters& estimator) {
  if (sources.size() > estimation::kOwnFactorKinds) {
    throw std::invalid_argument("'" + sources.back().name + "': more than " +
                                std::to_string(estimation::kOwnFactorKinds) + " further sources");
  }
  estimator.own_sources.clear();
  int states = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    NamedSource& source = sources[i];
    require_what_its_kind_needs(source);
    const auto take_state = [&](const char* parameter, double deviation) {
      if (states == estimation::kOwnSize) {
        throw std::invalid_argument("'" + source.name + "." + parameter + "': more than " +
                                    std::to_string(estimation::kOwnSize) +
                                    " biases and time offsets");
      }
      estimator.smoother.global_deviations.own[states] = deviation;
      return states++;
    };
    if (may_be_biased(source.kind) && source.bias_deviation > 0) {
      source.bias = take_state("bias_deviation", source.bias_deviation);
      estimator.smoother.own_walks[source.bias] = source.bias_walk;
    }
    if (source.kind == NamedSourceKind::kPose && source.time_offset_deviation > 0) {
      source.clock = take_state("time_offset_deviation", source.time_offset_deviation);
      estimator.smoother.relinearisation.own[source.clock] =
          estimator.smoother.relinearisation.time_offset;
    }
    estimator.own_sources.push_back({.correlation_time = source.correlation_time});
    const auto kind = static_cast<std::size_t>(estimation::own_kind(i));
    estimator.smoother.robustness[kind].gate_probability = source.gate;
  }
  for (NamedSource& source : sources) {
    if (source.kind == NamedSourceKind::kPose &&
        (source.mounting_position_deviation > 0 || source.mounting_rotation_deviation > 0)) {
      try {
        source.mounting = estimator.smoother.estimate_camera_mounting(
            source.mounting_position_deviation, source.mounting_rotation_deviation);
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument("'" + source.name + ".mounting_position_deviation', '" +
                                    source.name + ".mounting_rotation_deviation': " + error.what());
      }
    }
  }
}

}  // namespace pipescout
