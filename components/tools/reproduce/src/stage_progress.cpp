// SPDX-License-Identifier: Apache-2.0
#include "stage_progress.hpp"

#include <array>
#include <cstdio>

namespace pipescout::reproduce {

StageProgress::StageProgress(const ReproduceOptions& options)
    : out_(options.progress), on_terminal_(options.progress_on_terminal) {}

void StageProgress::begin(const std::string& stage, std::size_t steps) {
  stage_ = stage;
  steps_ = steps;
  done_ = 0;
  begun_ = std::chrono::steady_clock::now();
  if (out_ != nullptr) {
    *out_ << stage_ << (on_terminal_ ? "" : " ...") << std::flush;
  }
}

void StageProgress::step() {
  ++done_;
  if (out_ != nullptr && on_terminal_) {
    *out_ << '\r' << stage_ << ": " << done_ << " of " << steps_ << std::flush;
  }
}

void StageProgress::end() {
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun_;
  if (out_ != nullptr) {
    std::array<char, 32> seconds{};
    std::snprintf(seconds.data(), seconds.size(), "%.1f s", took.count());
    constexpr const char* kClearToEnd = "\x1b[K";
    if (on_terminal_) {
      *out_ << '\r' << stage_ << ": " << seconds.data() << kClearToEnd << std::endl;
    } else {
      *out_ << ' ' << seconds.data() << std::endl;
    }
  }
}

}  // namespace pipescout::reproduce
