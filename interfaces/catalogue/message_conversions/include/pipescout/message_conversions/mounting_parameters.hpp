// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/parameters.hpp"

/// Poses of sensors on a robot, from parameters.
namespace pipescout {

/// The values of a parameter that is empty or has three. Throws std::invalid_argument naming the
/// parameter when it has another number of values, or one that is not finite.
[[nodiscard]] std::optional<Eigen::Vector3d> three(const Parameter<std::vector<double>>& parameter);

/// T_base_camera of a camera's parameters: `position`, m, of the optical frame in the base frame;
/// empty: at its origin. `roll_pitch_yaw`, rad; empty: straight down, the upper border of the image
/// forward. Throws as `three`.
[[nodiscard]] geometry::SE3 camera_mounting(const Parameter<std::vector<double>>& position,
                                            const Parameter<std::vector<double>>& roll_pitch_yaw);

/// The content of the robot description file that a parameter names. Throws std::invalid_argument
/// naming the parameter and the file when it cannot be read.
[[nodiscard]] std::string file_content(const Parameter<std::string>& parameter);

}  // namespace pipescout
