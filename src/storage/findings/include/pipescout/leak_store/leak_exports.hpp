// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/leak_findings/finding.hpp"

/// Findings in formats of other programs. Pure. Times are s since 1970 UTC, written as ISO 8601.
/// `datum`: geodetic position of the map's origin, x east, y north; without it findings have no
/// geodetic position.
namespace pipescout {

/// A FeatureCollection (RFC 7946) with one Feature per finding and its estimates as properties; the
/// geometry is null if the position is unknown. Lengths in m, temperatures in K.
[[nodiscard]] std::string leaks_geojson(std::span<const leak_findings::Finding> findings,
                                        const std::optional<geometry::GeodeticPosition>& datum);

/// KML 2.2 with one Placemark per finding, styled by severity; those without a position have no
/// Point.
[[nodiscard]] std::string leaks_kml(std::span<const leak_findings::Finding> findings,
                                    const std::optional<geometry::GeodeticPosition>& datum);

/// One line per finding after a header line; unknown fields are empty.
[[nodiscard]] std::string leaks_csv(std::span<const leak_findings::Finding> findings,
                                    const std::optional<geometry::GeodeticPosition>& datum);

/// "2013-04-16T20:12:26.104Z"; empty for what is not finite or outside the years 1 to 9999.
[[nodiscard]] std::string iso_time(double seconds);

}  // namespace pipescout
