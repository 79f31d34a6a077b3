// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <pipescout/estimation/state_estimator.hpp>
#include <pipescout/estimation/wheel_drive.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/parameters.hpp"

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
  kWheelEncoders,              ///< sensor_msgs/JointState: angles or rates of driven wheels
};
inline constexpr std::size_t kNamedSourceKinds = 10;
/// "gps_velocity", "gps_velocity_with_covariance", "base_velocity", "odometry_velocity",
/// "odometry_pose", "magnetic_field", "fluid_pressure", "range", "gps_fix", "wheel_encoders".
[[nodiscard]] std::string_view to_string(NamedSourceKind kind) noexcept;

/// One source that the parameter `sources` names. Its factors are of `own_kind(i)`, i its place.
struct NamedSource {
  std::string name;
  NamedSourceKind kind{};
  std::string topic;
  std::optional<Eigen::Vector3d> position;           ///< m, in the base frame; nothing: from tf
  geometry::SO3 R_base_sensor;                       ///< with `position`
  double deviation = 0;                              ///< per axis, of messages without covariance
  double rotation_deviation = 0;                     ///< rad, kOdometryPose
  double declination = 0;                            ///< rad, kMagneticField
  Eigen::Vector3d beacon = Eigen::Vector3d::Zero();  ///< m, in the map, kRange
  int bias = -1;                                     ///< place in GlobalStates::own; -1: none
  estimation::WheelDriveParameters wheels{};         ///< kWheelEncoders
};

/// A pose of the sensor in a frame of its own.
struct TimedPose {
  double time = 0;
  geometry::SE3 pose{};
};

/// The parameters of the sources that the parameter `sources` names: docs/components/
/// state_estimator.md.
class NamedSourceParameters {
 public:
  /// Declares them. Throws ParameterError for a kind that is unknown.
  explicit NamedSourceParameters(Parameters& parameters);

  /// Sets gates, own states and correlation times in `estimator`. Throws std::invalid_argument
  /// naming the parameter.
  [[nodiscard]] std::vector<NamedSource> read(
      estimation::StateEstimatorParameters& estimator) const;

 private:
  struct Declared {
    std::string name;
    NamedSourceKind kind;
    Parameter<std::string> topic;
    Parameter<std::vector<double>> position;
    Parameter<std::vector<double>> roll_pitch_yaw;
    Parameter<double> deviation;
    Parameter<double> rotation_deviation;
    Parameter<double> declination;
    Parameter<std::vector<double>> beacon;
    Parameter<double> bias_deviation;
    Parameter<double> bias_walk;
    Parameter<double> correlation_time;
    Parameter<double> gate;
    Parameter<std::vector<std::string>> left;
    Parameter<std::vector<std::string>> right;
    Parameter<double> wheel_radius;
    Parameter<double> track;
  };
  std::vector<Declared> declared_;
};

}  // namespace pipescout
