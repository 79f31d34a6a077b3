// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_findings/rack_lines.hpp"

namespace pipescout::leak_findings {

std::vector<PipeLine> rack_lines(const rack_vision::RackModel& rack,
                                 rack_vision::PipeOffsets offsets) {
  std::vector<rack_vision::PipeSection> sections;
  for (std::size_t i = 0; i < rack.pipes.size(); ++i) {
    append_sections(rack.pipes[i], offsets.empty() ? 0 : offsets[i], sections);
  }
  std::vector<PipeLine> lines;
  for (const rack_vision::PipeSection& section : sections) {
    lines.push_back({.from = section.start,
                     .to = section.start + section.length * section.direction,
                     .radius = (section.radius_start + section.radius_end) / 2});
  }
  return lines;
}

}  // namespace pipescout::leak_findings
