// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_model.hpp"

#include <algorithm>

namespace pipescout::rack_vision {

double Pipe::largest_radius() const {
  return std::ranges::max_element(radii, {}, &RadiusAt::radius)->radius;
}

std::vector<Pipe> row_of_pipes(std::span<const RowPipe> row) {
  std::vector<Pipe> pipes;
  double left = 0;
  for (const RowPipe& entry : row) {
    Pipe pipe{.name = entry.name, .radii = entry.radii};
    const double radius = pipe.largest_radius();
    left += pipes.empty() ? 0 : entry.gap;
    pipe.start = {left + radius, 0, radius};
    pipe.movable = !pipes.empty();
    left += 2 * radius;
    pipes.push_back(std::move(pipe));
  }
  return pipes;
}

void append_sections(const Pipe& pipe, double offset, std::vector<PipeSection>& sections) {
  const Eigen::Vector3d start = pipe.start + offset * Eigen::Vector3d::UnitX();
  for (std::size_t i = 1; i < pipe.radii.size(); ++i) {
    const RadiusAt& from = pipe.radii[i - 1];
    const RadiusAt& to = pipe.radii[i];
    if (to.along > from.along) {
      sections.push_back({start + from.along * pipe.direction, pipe.direction,
                          to.along - from.along, from.radius, to.radius});
    }
  }
}

}  // namespace pipescout::rack_vision
