// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/tracked_section.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace pipescout {

pipescout_msgs::msg::TrackedSection section_message(const Eigen::Vector4d& section) {
  pipescout_msgs::msg::TrackedSection message;
  message.u = section[0];
  message.v = section[1];
  message.length = section[2];
  message.angle = section[3];
  return message;
}

Eigen::Vector4d from_message(const pipescout_msgs::msg::TrackedSection& message) {
  const Eigen::Vector4d section(message.u, message.v, message.length, message.angle);
  constexpr const char* kFields[] = {"u", "v", "length", "angle"};
  for (Eigen::Index i = 0; i < section.size(); ++i) {
    if (!std::isfinite(section[i])) {
      throw std::invalid_argument(std::string(kFields[i]) + " is not finite");
    }
  }
  if (section[2] < 0) {
    throw std::invalid_argument("length is negative");
  }
  return section;
}

bool whole_width_in_view(const Eigen::Vector4d& section, double half_width, double width,
                         double height) {
  const Eigen::Vector2d middle = section.head<2>();
  const Eigen::Vector2d along(std::cos(section[3]), std::sin(section[3]));
  // Across the picture's border that the pipe runs along.
  const Eigen::Index across = std::abs(along.x()) >= std::abs(along.y()) ? 1 : 0;
  const double largest = (across == 1 ? height : width) - 1;
  const double edge = half_width / std::abs(along[1 - across]);
  for (const double end : {-0.5, 0.5}) {
    const double place = middle[across] + end * section[2] * along[across];
    if (!(place - edge >= 0 && place + edge <= largest)) {
      return false;
    }
  }
  return true;
}

}  // namespace pipescout
