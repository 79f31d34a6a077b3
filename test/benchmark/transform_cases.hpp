// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

namespace pipescout::benchmarks {

/// Lookups of transforms, ours and tf2's, and what components cost that may look some up.
void register_transform_cases();
void add_transform_figures(Figures& figures);

}  // namespace pipescout::benchmarks
