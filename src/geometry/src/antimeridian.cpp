// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/antimeridian.hpp"

#include <cmath>

namespace pipescout::geometry {

std::vector<std::vector<GeodeticPosition>> cut_at_antimeridian(
    std::span<const GeodeticPosition> line) {
  std::vector<std::vector<GeodeticPosition>> lines(1);
  for (GeodeticPosition point : line) {
    point.validate();
    if (std::abs(point.longitude) > 180.0) {
      point.longitude = std::remainder(point.longitude, 360.0);
    }
    if (!lines.back().empty() &&
        std::abs(point.longitude - lines.back().back().longitude) > 180.0) {
      const GeodeticPosition last = lines.back().back();
      const double side = std::copysign(180.0, last.longitude);
      const double step = point.longitude + 2.0 * side - last.longitude;
      const double share = step == 0.0 ? 0.0 : (side - last.longitude) / step;
      const GeodeticPosition crossing{std::lerp(last.latitude, point.latitude, share), side,
                                      std::lerp(last.altitude, point.altitude, share)};
      if (last.longitude != side) {
        lines.back().push_back(crossing);
      }
      lines.emplace_back();
      if (point.longitude != -side) {
        lines.back().push_back({crossing.latitude, -side, crossing.altitude});
      }
    }
    lines.back().push_back(point);
  }
  std::erase_if(lines, [](const auto& piece) { return piece.size() < 2; });
  return lines;
}

}  // namespace pipescout::geometry
