// SPDX-License-Identifier: Apache-2.0
#include "tf2_peer.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>

namespace pipescout::benchmarks {
namespace {

ros::Time ros_time(std::int64_t time) {
  ros::Time result;
  result.fromNSec(static_cast<std::uint64_t>(time));
  return result;
}

}  // namespace

class Tf2Peer::Impl {
 public:
  explicit Impl(std::int64_t history) : buffer(ros::Duration().fromNSec(history)) {}
  tf2::BufferCore buffer;
};

Tf2Peer::Tf2Peer(std::int64_t history) : impl_(std::make_unique<Impl>(history)) {}

Tf2Peer::~Tf2Peer() = default;

bool Tf2Peer::insert(const std::string& parent, const std::string& child, std::int64_t time,
                     const Pose& pose, bool is_static) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = ros_time(time);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = pose.translation[0];
  message.transform.translation.y = pose.translation[1];
  message.transform.translation.z = pose.translation[2];
  message.transform.rotation.x = pose.rotation[0];
  message.transform.rotation.y = pose.rotation[1];
  message.transform.rotation.z = pose.rotation[2];
  message.transform.rotation.w = pose.rotation[3];
  return impl_->buffer.setTransform(message, "peer", is_static);
}

Tf2Peer::Outcome Tf2Peer::lookup(const std::string& target, const std::string& source,
                                 std::int64_t time, Pose& pose) const {
  try {
    const geometry_msgs::TransformStamped found =
        impl_->buffer.lookupTransform(target, source, ros_time(time));
    const auto& [translation, rotation] =
        std::tie(found.transform.translation, found.transform.rotation);
    pose.translation = {translation.x, translation.y, translation.z};
    pose.rotation = {rotation.x, rotation.y, rotation.z, rotation.w};
    return Outcome::kFound;
  } catch (const tf2::LookupException&) {
    return Outcome::kUnknown;
  } catch (const tf2::ConnectivityException&) {
    return Outcome::kDisconnected;
  } catch (const tf2::ExtrapolationException&) {
    return Outcome::kExtrapolation;
  }
}

}  // namespace pipescout::benchmarks
