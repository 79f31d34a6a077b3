// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <optional>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Where a map is on the Earth, as a static transform: the frame `earth` of REP 105 (Earth-centred,
/// Earth-fixed) is a child of the map's, so that the map stays the root of the robot's tree.
[[nodiscard]] geometry_msgs::msg::TransformStamped map_origin_transform(
    const geometry::LocalFrame& map, const std::string& map_frame, Time stamp);

/// The origin of the map that such a transform tells of: to a millimetre. Nothing where none of the
/// transforms is one. Throws std::invalid_argument for one that is not finite or not normalised.
[[nodiscard]] std::optional<geometry::GeodeticPosition> map_origin(
    const tf2_msgs::msg::TFMessage& message);

}  // namespace pipescout
