// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/map_origin.hpp"

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

constexpr const char* kEarthFrame = "earth";

}  // namespace

geometry_msgs::msg::TransformStamped map_origin_transform(const geometry::LocalFrame& map,
                                                          const std::string& map_frame,
                                                          Time stamp) {
  const geometry::SE3 T_map_earth(geometry::SO3::from_matrix(map.R_local_geocentric()),
                                  map.from_geocentric(Eigen::Vector3d::Zero()));
  geometry_msgs::msg::TransformStamped message;
  message.header.stamp = to_message(stamp);
  message.header.frame_id = map_frame;
  message.child_frame_id = kEarthFrame;
  message.transform = transform_message(T_map_earth);
  return message;
}

std::optional<geometry::GeodeticPosition> map_origin(const tf2_msgs::msg::TFMessage& message) {
  std::optional<geometry::GeodeticPosition> origin;
  for (const auto& transform : message.transforms) {
    if (transform.child_frame_id == kEarthFrame) {
      const geometry::SE3 T_map_earth = from_message(transform.transform);
      // A frame of another origin, to get from geocentric to geodetic places.
      const geometry::LocalFrame any({});
      origin = any.geodetic(any.from_geocentric(T_map_earth.inverse().translation()));
    }
  }
  return origin;
}

}  // namespace pipescout
