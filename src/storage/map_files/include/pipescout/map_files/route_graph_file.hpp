// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout {

/// A graph of Nav2's route server: a GeoJSON FeatureCollection of Points (nodes: `id`, `frame`) and
/// LineStrings or MultiLineStrings (directed edges: `id`, `startid`, `endid`, `cost`,
/// `overridable`), in m. Points of an edge may be nested in either type, and be missing, as Nav2's
/// own saver leaves them: the edge is then straight. `cost` does not count where `overridable` is
/// true, as in Nav2. The `metadata` of an edge may have `speed` or Nav2's `abs_speed_limit` (m/s),
/// `width` (m), `pipe_side` (none, left, right, both), `one_way`, and `closed_until` (s, or
/// "further notice").
///
/// `remarks` gets a sentence, with the file, for each kind of thing that is not used: other
/// metadata, operations, edges from a node to itself, costs that may be overridden; and for ids
/// that name no edge since two have them. Throws MapFileError naming file, feature and field.
[[nodiscard]] navigation::RouteGraph read_route_graph(const std::filesystem::path& path,
                                                      std::vector<std::string>& remarks);

/// Throws std::system_error naming the file.
void write_route_graph(const std::filesystem::path& path, const navigation::RouteGraph& graph);

}  // namespace pipescout
