// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/odometry/weld_positioning.hpp>
#include <span>
#include <string>
#include <vector>

namespace pipescout {

/// The content of a weld ledger in the form for positioning.
struct Tally {
  std::vector<std::string> ids;  ///< of the welds; one more than joints
  std::vector<odometry::TallyJoint> joints;
  std::vector<double> chainages;           ///< m, of the welds, by the sum of the joints
  std::vector<double> variances;           ///< m^2, of `chainages`, the first weld exact
  std::vector<odometry::TallyBend> bends;  ///< those of the landmarks, by chainage
  std::vector<std::string> notes;          ///< how the file was read, where that is a guess
};

/// Reads a weld ledger or a tally (docs/weld_ledger.md). A joint without a standard deviation gets
/// that of `odometry::TallyJoint`; a bend of unknown angle may have any up to a half turn.
/// Throws std::runtime_error, mostly CsvError, naming the file, and the line and column where there
/// is one.
[[nodiscard]] Tally read_tally(const std::string& path);

/// A ledger of the joints measured by a crawler, from the first to the last observed one; empty
/// when there is none.
[[nodiscard]] std::string format_learnt_tally(std::span<const odometry::LearntJoint> joints,
                                              double first_weld_chainage);

}  // namespace pipescout
