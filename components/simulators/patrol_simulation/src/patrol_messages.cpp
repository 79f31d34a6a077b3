// SPDX-License-Identifier: Apache-2.0
#include "patrol_messages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/message_conversions/tracked_section.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::PipeTrack;
using sensor_msgs::msg::NavSatFix;
using sensor_msgs::msg::NavSatStatus;

}  // namespace

sensor_msgs::msg::NavSatFix fix_message(const simulation::GpsFix& fix,
                                        const geometry::LocalFrame& frame) {
  const geometry::GeodeticPosition place = frame.geodetic(fix.position);
  const Eigen::Matrix3d axes = frame.axes_at(place);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance =
      axes.transpose() * fix.covariance * axes;
  sensor_msgs::msg::NavSatFix message;
  message.status.status = NavSatStatus::STATUS_FIX;
  message.status.service = NavSatStatus::SERVICE_GPS;
  message.latitude = place.latitude;
  message.longitude = place.longitude;
  message.altitude = place.altitude;
  std::copy_n(covariance.data(), covariance.size(), message.position_covariance.begin());
  message.position_covariance_type = NavSatFix::COVARIANCE_TYPE_KNOWN;
  return message;
}

std::vector<pipescout_msgs::msg::LeakEvent> true_leak_messages(
    const std::vector<simulation::ThermalScene>& rows) {
  std::vector<pipescout_msgs::msg::LeakEvent> messages;
  for (const simulation::ThermalScene& row : rows) {
    for (const simulation::ThermalLeak& leak : row.parameters().leaks) {
      const Eigen::Vector3d place = row.on_tube(leak.place);
      pipescout_msgs::msg::LeakEvent& message = messages.emplace_back();
      message.kind = pipescout_msgs::msg::LeakEvent::RAISED;
      message.finding.id = messages.size();
      message.finding.state = "raised";
      message.finding.probability = 1;
      message.finding.position_known = true;
      message.finding.position.x = place.x();
      message.finding.position.y = place.y();
      message.finding.position.z = place.z();
      message.finding.length = leak.length;
      message.finding.delta = leak.rise;
    }
  }
  return messages;
}

pipescout_msgs::msg::PipeTrack true_track_message(const std::optional<simulation::PipeView>& view,
                                                  const geometry::CameraParameters& camera,
                                                  double radius, bool beside) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  pipescout_msgs::msg::PipeTrack message;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.track = beside ? 1 : 0;
  if (!view) {
    message.state = PipeTrack::STATE_LOST;
    message.reason = "not in view";
    message.since_seen = kNaN;
    message.half_width = kNaN;
    message.range = kNaN;
    return message;
  }
  const Eigen::Vector2d middle = (view->from + view->to) / 2;
  const Eigen::Vector2d along = view->to - view->from;
  message.state = PipeTrack::STATE_LOCKED;
  message.confidence = 1;
  message.estimate =
      section_message({middle.x(), middle.y(), along.norm(), std::atan(along.y() / along.x())});
  message.range = view->range;
  message.half_width = camera.focal_length * radius / view->range;
  message.whole_width = view->whole_width;
  return message;
}

}  // namespace pipescout
