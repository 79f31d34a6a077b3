// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "pipescout/planning/motion_primitives.hpp"

namespace pipescout::navigation_study {

/// Of all primitives, the largest: where the vehicle ended from where the primitive says.
struct PrimitiveReplay {
  std::size_t primitives = 0;
  double position = 0;  ///< m
  double heading = 0;   ///< rad
};

/// Each primitive driven by the simulated vehicle with its delays, steering rate and understeer, on
/// level ground without slip: it turns its wheels at a standstill, then drives along each piece.
[[nodiscard]] PrimitiveReplay replay_primitives(const navigation::LatticePrimitives& lattice);

}  // namespace pipescout::navigation_study
