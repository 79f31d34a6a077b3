// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/planning/motion_primitives.hpp"

namespace pipescout {

/// Primitives of Nav2's lattice planner, as its generator writes them: `lattice_metadata` and
/// `primitives` with `poses`, of which the start is left out. Their arcs are computed from where
/// and with which heading they end. Throws MapFileError naming file, primitive and field, also
/// where the middle of a primitive's poses is not on those arcs (within a spacing), as with flipped
/// headings.
[[nodiscard]] navigation::LatticePrimitives read_lattice(const std::filesystem::path& path);

/// Throws std::system_error naming the file.
void write_lattice(const std::filesystem::path& path, const navigation::LatticePrimitives& lattice);

}  // namespace pipescout
