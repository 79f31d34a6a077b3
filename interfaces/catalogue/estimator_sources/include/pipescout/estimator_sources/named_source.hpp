// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <pipescout/estimation/state_estimator.hpp>
#include <pipescout/estimation/wheel_drive.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/geometry/so3.hpp"

/// Sources of the state estimator besides IMU, GPS, odometer, rack and welds: as many of a kind as
/// a robot has, each with a name and parameters of its own.
namespace pipescout {

/// What a named source measures, and by which message.
enum class NamedSourceKind {
  kGpsVelocity,                ///< geometry_msgs/TwistStamped: velocity in the map (ENU)
  kGpsVelocityWithCovariance,  ///< geometry_msgs/TwistWithCovarianceStamped, the same
  kBaseVelocity,               ///< geometry_msgs/TwistWithCovarianceStamped: in its frame
  kOdometryVelocity,           ///< nav_msgs/Odometry: its twist, in its child frame
  kOdometryPose,               ///< nav_msgs/Odometry: the difference of two of its poses
  kMagneticField,              ///< sensor_msgs/MagneticField: heading
  kFluidPressure,              ///< sensor_msgs/FluidPressure: height, with a bias that walks
  kRange,                      ///< sensor_msgs/Range: distance from a beacon
  kGpsFix,                     ///< sensor_msgs/NavSatFix: another antenna
  kPose,                       ///< geometry_msgs/PoseWithCovarianceStamped: in the map
  kWheelEncoders,              ///< sensor_msgs/JointState: angles or rates of driven wheels
};
inline constexpr std::size_t kNamedSourceKinds = 11;
/// "gps_velocity", "gps_velocity_with_covariance", "base_velocity", "odometry_velocity",
/// "odometry_pose", "magnetic_field", "fluid_pressure", "range", "gps_fix", "pose",
/// "wheel_encoders"; "unknown".
[[nodiscard]] std::string_view to_string(NamedSourceKind kind) noexcept;
/// Nothing for another text.
[[nodiscard]] std::optional<NamedSourceKind> named_source_kind(std::string_view name) noexcept;
/// "'gps_velocity', 'base_velocity', ...": for errors.
[[nodiscard]] std::string all_named_source_kinds();
/// As ROS 2 names it: "sensor_msgs/msg/Range".
[[nodiscard]] std::string_view message_type_of(NamedSourceKind kind) noexcept;

/// One source. Its factors are of `estimation::own_kind(i)`, i its place.
struct NamedSource {
  std::string name;
  NamedSourceKind kind{};
  std::string topic;
  std::optional<Eigen::Vector3d> position{};  ///< m, in the base frame; nothing: from tf
  geometry::SO3 R_base_sensor{};              ///< with `position`
  double deviation = 1;                       ///< per axis, of messages without covariance
  double rotation_deviation = 0.005;          ///< rad, of a step of kOdometryPose; kPose
  double declination = 0;                     ///< rad, kMagneticField
  std::optional<Eigen::Vector3d> beacon{};    ///< m, in the map, kRange
  double bias_deviation = 0;                  ///< m or rad; 0: no bias
  double bias_walk = 0;                       ///< per sqrt(s)
  /// Of kPose; above 0: estimated. m and rad per axis, and s.
  double mounting_position_deviation = 0;
  double mounting_rotation_deviation = 0;
  double time_offset_deviation = 0;
  double correlation_time = 0;                ///< s, of the measurement errors; 0: white
  double gate = 0.9999;                       ///< share of correct measurements that are accepted
  int bias = -1;                              ///< place in GlobalStates::own; -1: none
  int mounting = -1;                          ///< the same of the first of six
  int clock = -1;                             ///< of its time offset
  estimation::WheelDriveParameters wheels{};  ///< kWheelEncoders
};

/// With the defaults of its kind; the topic is the name.
[[nodiscard]] NamedSource default_source(const std::string& name, NamedSourceKind kind);

/// A parameter of a source that is a number.
struct NamedSourceNumber {
  const char* key;
  double NamedSource::*field;
  double low;  ///< least and largest value
  double high;
  const char* description;  ///< with its unit
};
[[nodiscard]] std::span<const NamedSourceNumber> named_source_numbers() noexcept;

/// Gives each source its place in the estimator: gate, correlation time, and a state for its bias.
/// Throws std::invalid_argument naming the source and the parameter when there are too many
/// sources, or biases, or a source lacks what its kind needs.
void place_sources(std::vector<NamedSource>& sources,
                   estimation::StateEstimatorParameters& estimator);

}  // namespace pipescout
