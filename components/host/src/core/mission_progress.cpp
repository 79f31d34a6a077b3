// SPDX-License-Identifier: Apache-2.0
#include "core/mission_progress.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::host {

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
  const bool has_finished = outcome() == Outcome::kComplete;
  if (has_finished) {
    line = "finished";
  } else if (const auto share = fraction()) {
    line = std::to_string(static_cast<int>(std::floor(*share * 100.0))) + " %";
  }
  for (const auto& [name, report] : reports_) {
    // What nobody waited for: a simulation whose robot is through before its time is over.
    const bool stops_early = has_finished && report.state == ComponentReport::State::kRunning;
    line += line.empty() ? "" : "  ";
    line += name.name + (stops_early ? " stopped at " : " ") + std::to_string(report.done);
    if (report.total != 0 && !stops_early) {
      line += "/" + std::to_string(report.total);
    }
  }
  return line;
}

}  // namespace pipescout::host
