// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "weld_alignment_model.hpp"

namespace pipescout::odometry::alignment {

/// Two welds that may be one: the middle of a stretch of joints that agree without gaps.
struct Proposal {
  double score = 0.0;
  std::size_t a = 0;
  std::size_t b = 0;
};

/// The best stretch of each diagonal, best first; ties by place. At most `count`.
[[nodiscard]] std::vector<Proposal> propose(const AlignmentModel& model, std::size_t count);

}  // namespace pipescout::odometry::alignment
