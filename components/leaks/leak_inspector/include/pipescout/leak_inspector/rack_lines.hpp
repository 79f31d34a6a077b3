// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/rack_vision/rack_model.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <span>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout {

/// The pipes of a rack as surfaces that leaks are on, one for each section between changes of the
/// radius, with the mean of a section that is a cone. `offsets` as in rack_model.hpp. The map is
/// the rack frame.
[[nodiscard]] std::vector<leak_findings::PipeLine> rack_lines(const rack_vision::RackModel& rack,
                                                              rack_vision::PipeOffsets offsets);

/// By pipe of `rack`, m along rack x, as the rack localizer estimates them; 0 for a pipe that it
/// does not name, and where it has no estimate.
[[nodiscard]] std::vector<double> rack_offsets(const rack_vision::RackModel& rack,
                                               const pipescout_msgs::msg::RackState& state);

}  // namespace pipescout
