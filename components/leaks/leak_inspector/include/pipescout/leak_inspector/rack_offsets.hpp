// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/rack_vision/rack_model.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <vector>

namespace pipescout {

/// By pipe of `rack`, m along rack x, as the rack localizer estimates them; 0 for a pipe that it
/// does not name, and where it has no estimate.
[[nodiscard]] std::vector<double> rack_offsets(const rack_vision::RackModel& rack,
                                               const pipescout_msgs::msg::RackState& state);

}  // namespace pipescout
