// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/mounting_parameters.hpp"

#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>

#include "pipescout/rack_vision/visual_servo.hpp"

namespace pipescout {

std::optional<Eigen::Vector3d> three(const Parameter<std::vector<double>>& parameter) {
  const std::vector<double>& values = *parameter.share();
  if (values.empty()) {
    return std::nullopt;
  }
  const Eigen::Vector3d result =
      values.size() == 3 ? Eigen::Vector3d(values[0], values[1], values[2])
                         : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (!result.allFinite()) {
    throw std::invalid_argument("parameter '" + parameter.name() +
                                "' must be empty or three finite numbers");
  }
  return result;
}

geometry::SE3 camera_mounting(const Parameter<std::vector<double>>& position,
                              const Parameter<std::vector<double>>& roll_pitch_yaw) {
  const Eigen::Vector3d place = three(position).value_or(Eigen::Vector3d::Zero());
  const auto angles = three(roll_pitch_yaw);
  return angles ? geometry::SE3(geometry::SO3::from_roll_pitch_yaw(*angles), place)
                : rack_vision::downward_camera(place);
}

std::string file_content(const Parameter<std::string>& parameter) {
  const std::string file = parameter.get();
  std::ifstream stream(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) {
    throw std::invalid_argument("parameter '" + parameter.name() + "': '" + file +
                                "' cannot be read");
  }
  return content;
}

}  // namespace pipescout
