// SPDX-License-Identifier: Apache-2.0
#include "shape_contour.hpp"

#include <vector>

namespace pipescout::rack_vision {
namespace {

constexpr double kStep = 1e-5;  // m and rad, of the central differences

}  // namespace

std::optional<double> distance_to_contour(const Pipe& pipe, const EdgeId& edge,
                                          const CameraView& view, const Eigen::Vector2d& pixel,
                                          const Eigen::Vector2d& normal) {
  std::vector<PipeSection> sections;
  append_sections(pipe, 0, sections);
  ContourLine lines[2];
  ImageLine line;
  if (edge.part >= sections.size() || !contour_lines(sections[edge.part], view.centre, lines) ||
      !image_line(view, lines[edge.side], line)) {
    return std::nullopt;
  }
  return -line.line.dot(pixel.homogeneous()) / line.line.head<2>().dot(normal);
}

ShapeVector distance_by_shape(const Pipe& pipe, const ShapeVector& at, const EdgeId& edge,
                              const CameraView& view, const Eigen::Vector2d& pixel,
                              const Eigen::Vector2d& normal) {
  ShapeVector derivative = ShapeVector::Zero();
  for (int k = 0; k < kShapeUnknowns; ++k) {
    const auto distance = [&](double step) {
      ShapeVector shape = at;
      shape(k) += step;
      return distance_to_contour(shaped(pipe, to_shape(shape)), edge, view, pixel, normal);
    };
    const std::optional<double> more = distance(kStep);
    const std::optional<double> less = distance(-kStep);
    if (!more || !less) {
      return ShapeVector::Zero();
    }
    derivative(k) = (*more - *less) / (2 * kStep);
  }
  return derivative;
}

}  // namespace pipescout::rack_vision
