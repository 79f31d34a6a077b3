// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <pipescout_msgs/msg/tracked_section.hpp>

namespace pipescout {

/// Conversions from and to [x y l alpha]: px, px, px, rad.
[[nodiscard]] pipescout_msgs::msg::TrackedSection section_message(const Eigen::Vector4d& section);
/// Throws std::invalid_argument naming the field that is not finite, or a length that is negative.
[[nodiscard]] Eigen::Vector4d from_message(const pipescout_msgs::msg::TrackedSection& message);

/// Whether both edges of a section, `half_width` pixels from its axis, are within an image of
/// `width` x `height` pixels over its whole length, so that neither is cut lengthwise. Ends at the
/// border do not matter. False for values that are not finite. Pure.
[[nodiscard]] bool whole_width_in_view(const Eigen::Vector4d& section, double half_width,
                                       double width, double height);

}  // namespace pipescout
