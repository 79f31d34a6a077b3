// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>

/// Shapes that can be tracked in images. Lengths in pixels, angles in radians, times in seconds.
namespace pipescout::tracking {

/// A shape is a point of kSize numbers, the same for what is tracked and for the regions that are
/// seen in a picture, and a distance between two of them: equations (9), (13) and (14) of
/// Ibarguren, Molina, Susperregi, Maurtua, Sensors 13 (2013). A model has
///
///   kSize      how many numbers
///   kPeriods   of each: after how much it is the same again (pi for the direction of an axis,
///   which
///              has no head and tail); 0: never
///   distance   of two points by their differences, each brought into half a period about 0: a
///              template over the type of number, for it is also called with float. Without
///              branches, so that it can be computed for many particles at once.
template <class Model>
concept ShapeModel = requires(const Model& model, const std::array<double, Model::kSize>& d,
                              const std::array<float, Model::kSize>& f) {
  requires Model::kSize >
  0 && Model::kSize <= 16;
  requires std::same_as<std::remove_cvref_t<decltype(Model::kPeriods)>,
                        std::array<double, Model::kSize>>;
  { model.distance(d) } -> std::same_as<double>;
  { model.distance(f) } -> std::same_as<float>;
  { model.validate() } -> std::same_as<void>;
};

template <ShapeModel Model>
using ShapeState = Eigen::Matrix<double, static_cast<int>(Model::kSize), 1>;

}  // namespace pipescout::tracking
