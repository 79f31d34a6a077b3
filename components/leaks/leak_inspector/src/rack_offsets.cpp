// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/rack_offsets.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout {

std::vector<double> rack_offsets(const rack_vision::RackModel& rack,
                                 const pipescout_msgs::msg::RackState& state) {
  std::vector<double> offsets(rack.pipes.size(), 0.0);
  const std::size_t told = std::min(state.pipe.size(), state.offset.size());
  for (std::size_t i = 0; i < rack.pipes.size(); ++i) {
    const auto named = std::find(state.pipe.begin(), state.pipe.end(), rack.pipes[i].name);
    const auto which = static_cast<std::size_t>(named - state.pipe.begin());
    if (which < told && std::isfinite(state.offset[which])) {
      offsets[i] = state.offset[which];
    }
  }
  return offsets;
}

}  // namespace pipescout
