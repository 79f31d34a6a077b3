// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <ostream>
#include <string>

#include "reproduce.hpp"

namespace pipescout::reproduce {

/// Says how far work in stages is, and how long each took: a line for each that
/// is rewritten on a terminal, and otherwise printed when the stage is over.
class StageProgress {
 public:
  explicit StageProgress(const ReproduceOptions& options);

  void begin(const std::string& stage, std::size_t steps);
  void step();
  void end();

 private:
  std::ostream* out_;
  bool on_terminal_;
  std::string stage_;
  std::size_t steps_ = 0;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace pipescout::reproduce
