// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/odometry/weld_positioning.hpp>
#include <span>
#include <string>
#include <vector>

namespace pipescout {

/// What a weld ledger says about the pipe, as positioning needs it.
struct Tally {
  std::vector<std::string> ids;  ///< of the welds; one more than joints
  std::vector<odometry::TallyJoint> joints;
  std::vector<double> chainages;  ///< m, of the welds, as the joints add up
  std::vector<double> variances;  ///< m^2, of `chainages`, the first weld exact
};

/// Reads a weld ledger or a tally (docs/weld_ledger.md). A joint without a standard deviation gets
/// that of `odometry::TallyJoint`.
/// Throws std::runtime_error naming the file, and the line and column where there is one.
[[nodiscard]] Tally read_tally(const std::string& path);

/// A ledger of the joints that a crawler has measured itself, from the first to the last that it
/// observed; empty when there is none.
[[nodiscard]] std::string format_learnt_tally(std::span<const odometry::LearntJoint> joints,
                                              double first_weld_chainage);

}  // namespace pipescout
