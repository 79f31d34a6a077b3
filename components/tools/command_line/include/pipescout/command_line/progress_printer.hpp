// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <ostream>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout::command_line {

/// Shows progress: on a terminal one line that is overwritten; else a line at most once a second
/// and, when the share is known, at most every 10 %.
class ProgressPrinter {
 public:
  ProgressPrinter(std::ostream& out, bool terminal);

  void show(const std::string& line, std::optional<double> fraction, SteadyTime now);
  /// Shows the last state if that is not shown yet, and leaves the line.
  void finish();
  /// When a held back line should be shown by another call of `show`.
  [[nodiscard]] std::optional<SteadyTime> due() const;

 private:
  void print(SteadyTime now);

  std::ostream& out_;
  bool terminal_;
  std::string latest_;
  std::optional<double> latest_fraction_;
  std::string shown_;
  std::optional<double> shown_fraction_;
  std::optional<SteadyTime> shown_at_;
};

}  // namespace pipescout::command_line
