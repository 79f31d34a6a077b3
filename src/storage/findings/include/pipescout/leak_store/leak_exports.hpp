// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/leak_findings/finding.hpp"

/// Findings in formats that other programs read. Pure. Times are s since 1970 UTC, written as
/// ISO 8601. `datum`: where on the Earth the map's origin is, x east, y north; without it no
/// finding has a place on the Earth.
namespace pipescout {

/// A FeatureCollection (RFC 7946), a Feature a finding, with all that is known as properties; its
/// geometry is null where the place is not known. Lengths in m, temperatures in K.
[[nodiscard]] std::string leaks_geojson(std::span<const leak_findings::Finding> findings,
                                        const std::optional<geometry::GeodeticPosition>& datum);

/// KML 2.2, a Placemark a finding, styled by severity; those without a place have no Point.
[[nodiscard]] std::string leaks_kml(std::span<const leak_findings::Finding> findings,
                                    const std::optional<geometry::GeodeticPosition>& datum);

/// A line a finding, after one with the names of columns; fields that are not known are empty.
[[nodiscard]] std::string leaks_csv(std::span<const leak_findings::Finding> findings,
                                    const std::optional<geometry::GeodeticPosition>& datum);

/// "2013-04-16T20:12:26.104Z"; empty for what is not finite or outside the years 1 to 9999.
[[nodiscard]] std::string iso_time(double seconds);

}  // namespace pipescout
