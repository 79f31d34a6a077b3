// SPDX-License-Identifier: Apache-2.0
#include "core/mission_progress.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::host {
namespace {

constexpr Duration kTerminalInterval = std::chrono::milliseconds(100);
constexpr Duration kLineInterval = std::chrono::seconds(1);
constexpr double kLineStep = 0.1 - 1e-9;  // of shares that are quotients of whole numbers

}  // namespace

MissionProgress::MissionProgress(std::vector<NodeName> awaited) : awaited_(std::move(awaited)) {}

void MissionProgress::report(const NodeName& component, ComponentReport report) {
  auto& kept = reports_[component];
  if (kept.state != ComponentReport::State::kRunning) {
    return;
  }
  if (report.state != ComponentReport::State::kRunning && report.total == 0) {
    // The end of a part says nothing of its amount.
    report.done = kept.done;
    report.total = kept.total;
  }
  kept = std::move(report);
}

MissionProgress::Outcome MissionProgress::outcome() const {
  const auto is = [&](const NodeName& name, ComponentReport::State state) {
    const auto report = reports_.find(name);
    return report != reports_.end() && report->second.state == state;
  };
  if (!failure().empty()) {
    return Outcome::kFailed;
  }
  const bool complete =
      !awaited_.empty() && std::all_of(awaited_.begin(), awaited_.end(), [&](const auto& name) {
        return is(name, ComponentReport::State::kComplete);
      });
  return complete ? Outcome::kComplete : Outcome::kRunning;
}

std::string MissionProgress::failure() const {
  for (const auto& [name, report] : reports_) {
    if (report.state == ComponentReport::State::kFailed) {
      return name.fully_qualified() +
             " failed: " + (report.message.empty() ? "it gave no reason" : report.message);
    }
  }
  return {};
}

std::optional<double> MissionProgress::fraction() const {
  std::optional<double> least;
  for (const auto& name : awaited_) {
    const auto found = reports_.find(name);
    if (found == reports_.end()) {
      return std::nullopt;
    }
    const auto& report = found->second;
    double share = 1.0;
    if (report.state != ComponentReport::State::kComplete) {
      if (report.total == 0) {
        return std::nullopt;
      }
      share = std::min(1.0, static_cast<double>(report.done) / report.total);
    }
    least = std::min(least.value_or(1.0), share);
  }
  return least;
}

std::string MissionProgress::line() const {
  std::string line;
  if (const auto share = fraction()) {
    line = std::to_string(static_cast<int>(std::floor(*share * 100.0))) + " %";
  }
  for (const auto& [name, report] : reports_) {
    line += line.empty() ? "" : "  ";
    line += name.name + " " + std::to_string(report.done);
    if (report.total != 0) {
      line += "/" + std::to_string(report.total);
    }
  }
  return line;
}

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

}  // namespace pipescout::host
