// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Pipe axes from a parameter with six numbers per pipe: x y z of both ends, m, in the map. Throws
/// std::invalid_argument naming the parameter.
[[nodiscard]] std::vector<leak_findings::PipeLine> pipe_lines(
    const Parameter<std::vector<double>>& parameter);

}  // namespace pipescout
