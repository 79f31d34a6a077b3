// SPDX-License-Identifier: Apache-2.0
#include "run/motion_watch.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout::host {
namespace {

/// A base holds the last command for half of this time (`cmd_vel_timeout` of diff_drive_controller:
/// 0.5 s), and controllers command more often.
constexpr Duration kCommandHolds = std::chrono::seconds(1);
constexpr double kSigmas = 3.0;
/// `trans_stopped_velocity` and `rot_stopped_velocity` of Nav2's StoppedGoalChecker, m/s and rad/s.
constexpr double kStopped = 0.25;

bool is_zero(const geometry_msgs::msg::Twist& twist) {
  const std::array<double, 6> speeds{twist.linear.x,  twist.linear.y,  twist.linear.z,
                                     twist.angular.x, twist.angular.y, twist.angular.z};
  // What is no number is no command to stand.
  return std::all_of(speeds.begin(), speeds.end(), [](double speed) { return speed == 0.0; });
}

}  // namespace

bool says_standing(const nav_msgs::msg::Odometry& odometry) {
  const auto& twist = odometry.twist.twist;
  const std::array<double, 6> speeds{twist.linear.x,  twist.linear.y,  twist.linear.z,
                                     twist.angular.x, twist.angular.y, twist.angular.z};
  constexpr std::size_t kStride = 7;  // of the diagonal of a 6x6 matrix
  for (std::size_t k = 0; k < speeds.size(); ++k) {
    const double bound = kSigmas * std::sqrt(odometry.twist.covariance[k * kStride]);
    if (!(std::abs(speeds[k]) <= bound && bound <= kStopped)) {
      return false;
    }
  }
  return true;
}

MotionWatch::MotionWatch(Node& node, const std::set<std::string>& namespaces)
    : node_(node),
      group_(node.create_callback_group(CallbackGroupType::kMutuallyExclusive)),
      may_move_until_(steady_now() + kCommandHolds) {
  const NodeSubscriptionOptions settings{.group = group_, .managed = false};
  for (const auto& ns : namespaces) {
    const auto in_ns = [&](std::string_view name) {
      return (ns == "/" ? "/" : ns + "/") + std::string(name);
    };
    commands_.push_back(node.create_subscription<geometry_msgs::msg::Twist>(
        in_ns(topics::kGroundVelocityCommand.name), QoS::sensor_data(1),
        [this](const geometry_msgs::msg::Twist& command) { on_command(command); }, settings));
    stamped_commands_.push_back(node.create_subscription<geometry_msgs::msg::TwistStamped>(
        in_ns(topics::kVelocityCommand.name), QoS::sensor_data(1),
        [this](const geometry_msgs::msg::TwistStamped& command) { on_command(command.twist); },
        settings));
    auto& one = *odometry_.emplace_back(std::make_unique<Odometry>());
    one.topic = in_ns(topics::kOdometryFiltered.name);
    one.subscription = node.create_subscription<nav_msgs::msg::Odometry>(
        one.topic, QoS::sensor_data(1),
        [this, &one](const nav_msgs::msg::Odometry& odometry) {
          const std::lock_guard lock(mutex_);
          one.heard_at = steady_now();
          one.stands = says_standing(odometry);
        },
        settings);
  }
}

void MotionWatch::on_command(const geometry_msgs::msg::Twist& command) {
  if (!is_zero(command)) {
    const std::lock_guard lock(mutex_);
    may_move_until_ = steady_now() + kCommandHolds;
  }
}

bool MotionWatch::stands(SteadyTime now) const {
  const auto topics = node_.context().graph().endpoints();
  const auto is_published = [&](const std::string& topic) {
    const auto wire = mangle_topic_name(topic, DdsTopicKind::kTopic);
    return std::any_of(topics.begin(), topics.end(), [&](const GraphEndpoint& endpoint) {
      return endpoint.is_publisher && endpoint.wire_topic == wire;
    });
  };
  const std::lock_guard lock(mutex_);
  return now >= may_move_until_ &&
         std::all_of(odometry_.begin(), odometry_.end(), [&](const auto& one) {
           const bool is_fresh = one->heard_at && now - *one->heard_at <= kCommandHolds;
           return is_fresh ? one->stands : !is_published(one->topic);
         });
}

}  // namespace pipescout::host
