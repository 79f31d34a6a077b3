// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/progress_printer.hpp"

namespace pipescout::command_line {
namespace {

constexpr Duration kTerminalInterval = std::chrono::milliseconds(100);
constexpr Duration kLineInterval = std::chrono::seconds(1);
constexpr double kLineStep = 0.1 - 1e-9;  // of shares that are quotients of whole numbers

}  // namespace

ProgressPrinter::ProgressPrinter(std::ostream& out, bool terminal)
    : out_(out), terminal_(terminal) {}

void ProgressPrinter::show(const std::string& line, std::optional<double> fraction,
                           SteadyTime now) {
  latest_ = line;
  latest_fraction_ = fraction;
  if (latest_ == shown_ || latest_.empty()) {
    return;
  }
  const auto interval = terminal_ ? kTerminalInterval : kLineInterval;
  if (shown_at_ && now - *shown_at_ < interval) {
    return;
  }
  const bool small_step = fraction && shown_fraction_ && *fraction >= *shown_fraction_ &&
                          *fraction - *shown_fraction_ < kLineStep;
  if (!terminal_ && shown_at_ && small_step) {
    return;
  }
  print(now);
}

void ProgressPrinter::print(SteadyTime now) {
  if (terminal_) {
    // The cursor goes back to the first column, so that a log line takes the place of this one.
    out_ << "\r\x1b[K" << latest_ << '\r' << std::flush;
  } else {
    out_ << latest_ << std::endl;
  }
  shown_ = latest_;
  shown_fraction_ = latest_fraction_;
  shown_at_ = now;
}

void ProgressPrinter::finish() {
  if (latest_ != shown_) {
    print(shown_at_.value_or(SteadyTime{}));
  }
  if (terminal_ && !shown_.empty()) {
    out_ << std::endl;
  }
  latest_.clear();
  shown_.clear();
}

std::optional<SteadyTime> ProgressPrinter::due() const {
  if (!terminal_ || latest_ == shown_ || latest_.empty() || !shown_at_) {
    return std::nullopt;
  }
  return *shown_at_ + kTerminalInterval;
}

}  // namespace pipescout::command_line
