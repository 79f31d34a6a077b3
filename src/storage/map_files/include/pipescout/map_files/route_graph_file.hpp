// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout {

/// A graph of Nav2's route server: a GeoJSON FeatureCollection of Points (nodes: `id`, `frame`) and
/// LineStrings or MultiLineStrings (directed edges: `id`, `startid`, `endid`, `cost`), in m. The
/// `metadata` of an edge may have `speed` (m/s), `width` (m), `pipe_side` (none, left, right,
/// both), `one_way`, and `closed_until` (s, or "further notice"). Other properties are left alone.
/// Throws MapFileError naming file, feature and field.
[[nodiscard]] navigation::RouteGraph read_route_graph(const std::filesystem::path& path);

/// Throws std::system_error naming the file.
void write_route_graph(const std::filesystem::path& path, const navigation::RouteGraph& graph);

}  // namespace pipescout
