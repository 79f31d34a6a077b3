// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "pipescout/geometry/geodesy.hpp"

namespace pipescout::geometry {

/// A line on a map as lines that do not cross the antimeridian (180 degrees of longitude), as RFC
/// 7946, section 3.1.9, has GeoJSON: two points more than 180 degrees apart are taken to be joined
/// the other way round, and the line is cut where it crosses, with latitude and altitude
/// interpolated linearly. Longitudes become those in [-180, 180]. Lines of fewer than two points
/// are left out. Throws as GeodeticPosition::validate.
[[nodiscard]] std::vector<std::vector<GeodeticPosition>> cut_at_antimeridian(
    std::span<const GeodeticPosition> line);

}  // namespace pipescout::geometry
