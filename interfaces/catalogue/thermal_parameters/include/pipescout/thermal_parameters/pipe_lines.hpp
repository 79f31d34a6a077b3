// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Of a parameter with six numbers for each pipe: x y z of one end and of the other end of its
/// axis, m, in the map. Throws std::invalid_argument naming the parameter.
[[nodiscard]] std::vector<leak_findings::PipeLine> pipe_lines(
    const Parameter<std::vector<double>>& parameter);

}  // namespace pipescout
