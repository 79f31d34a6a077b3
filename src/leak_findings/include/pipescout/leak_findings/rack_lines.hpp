// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::leak_findings {

/// The pipes of a rack as surfaces that leaks are on, one for each section between changes of the
/// radius, with the mean of a section that is a cone. `offsets` as in rack_model.hpp. The map is
/// the rack frame.
[[nodiscard]] std::vector<PipeLine> rack_lines(const rack_vision::RackModel& rack,
                                               rack_vision::PipeOffsets offsets);

}  // namespace pipescout::leak_findings
