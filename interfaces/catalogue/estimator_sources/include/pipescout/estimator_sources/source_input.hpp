// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <sensor_msgs/msg/fluid_pressure.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/magnetic_field.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/range.hpp>
#include <string>
#include <type_traits>
#include <variant>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/wheel_drive.hpp"
#include "pipescout/estimator_sources/named_source.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/geometry/se3.hpp"

namespace pipescout {

/// A message of any kind of named source.
using SourceMessage =
    std::variant<geometry_msgs::msg::TwistStamped, geometry_msgs::msg::TwistWithCovarianceStamped,
                 nav_msgs::msg::Odometry, sensor_msgs::msg::MagneticField,
                 sensor_msgs::msg::FluidPressure, sensor_msgs::msg::Range,
                 sensor_msgs::msg::NavSatFix, sensor_msgs::msg::JointState,
                 geometry_msgs::msg::PoseWithCovarianceStamped>;

/// The frame in which a message's numbers are, or on which its sensor is; empty: the base.
template <class Message>
[[nodiscard]] std::string sensor_frame(const Message& message) {
  if constexpr (std::is_same_v<Message, nav_msgs::msg::Odometry>) {
    return message.child_frame_id;
  } else if constexpr (std::is_same_v<Message, sensor_msgs::msg::JointState>) {
    return {};  // the motion is that of the base, whatever frame the joints have
  } else if constexpr (std::is_same_v<Message, geometry_msgs::msg::PoseWithCovarianceStamped>) {
    return {};  // it names the map; a sensor that is not at the base has a `position`
  } else {
    return message.header.frame_id;
  }
}

/// A pose of the sensor in a frame of its own.
struct TimedPose {
  double time = 0;
  geometry::SE3 pose{};
};

/// What a message of a named source is used with.
struct SourceContext {
  geometry::SE3 T_body_sensor{};
  /// rad/s, of the body, as measured by the gyro.
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();
  const geometry::LocalFrame* map = nullptr;  ///< null: not known yet, fixes are not used
  double least_gps_deviation = 0;             ///< m, per axis, lower bound
};

/// What a message of a named source tells.
struct SourceNews {
  std::optional<estimation::AnyFactor> factor{};  ///< nothing: it holds no measurement
  /// Of the body, in its axes; of the kinds that measure its velocity.
  std::optional<estimation::WheelMotion> motion{};
  double jumped = 0;  ///< m, of a pose whose frame began again elsewhere
};

/// What is heard of one named source: its messages become factors of the estimator.
class SourceInput {
 public:
  /// `place`: of the source in StateEstimatorParameters::own_sources. Poses that move faster than
  /// `largest_speed`, m/s, are those of a frame that began again. Throws std::invalid_argument for
  /// wheels that are not valid.
  SourceInput(const NamedSource& source, std::size_t place, double largest_speed);

  /// `time`: s since an origin that the caller keeps. Throws std::invalid_argument naming what is
  /// wrong with the message, or that it is not of the source's kind. Numbers that are not finite
  /// are for the estimator to refuse.
  [[nodiscard]] SourceNews take(const geometry_msgs::msg::TwistStamped& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const geometry_msgs::msg::TwistWithCovarianceStamped& message,
                                double time, const SourceContext& context);
  [[nodiscard]] SourceNews take(const nav_msgs::msg::Odometry& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const sensor_msgs::msg::MagneticField& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const sensor_msgs::msg::FluidPressure& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const sensor_msgs::msg::Range& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const sensor_msgs::msg::NavSatFix& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const sensor_msgs::msg::JointState& message, double time,
                                const SourceContext& context);
  [[nodiscard]] SourceNews take(const geometry_msgs::msg::PoseWithCovarianceStamped& message,
                                double time, const SourceContext& context);

 private:
  [[nodiscard]] SourceNews body_velocity(const geometry_msgs::msg::TwistWithCovariance& twist,
                                         double time, const SourceContext& context) const;
  [[nodiscard]] SourceNews relative_pose(const nav_msgs::msg::Odometry& message, double time,
                                         const SourceContext& context);

  NamedSource source_;
  estimation::FactorKind kind_;
  double largest_speed_;
  std::optional<TimedPose> last_pose_{};
  std::optional<estimation::WheelDrive> wheels_{};
};

}  // namespace pipescout
