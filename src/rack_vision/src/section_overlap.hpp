// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// Whether two sections of pipes, as solid bodies with flat ends, have more in common than their
/// surfaces: deeper into each other than about 2 micrometres.
[[nodiscard]] bool sections_overlap(const PipeSection& a, const PipeSection& b);

}  // namespace pipescout::rack_vision
