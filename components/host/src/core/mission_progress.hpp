// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/runtime/names.hpp"

namespace pipescout::host {

/// What a component said last on `mission/status`.
struct ComponentReport {
  enum class State : std::uint8_t { kRunning, kComplete, kFailed };
  State state = State::kRunning;
  std::uint32_t done = 0;
  std::uint32_t total = 0;  ///< 0: unknown
  std::string message;
};

/// How far a mission is, from the reports of its components.
class MissionProgress {
 public:
  enum class Outcome : std::uint8_t {
    kRunning,
    kComplete,  ///< all awaited components are complete; never when none is awaited
    kFailed     ///< a component, awaited or not, has failed
  };

  explicit MissionProgress(std::vector<NodeName> awaited);

  /// What a component says after it was complete or has failed changes nothing.
  void report(const NodeName& component, ComponentReport report);

  [[nodiscard]] Outcome outcome() const;
  /// "/fusion failed: message"; empty unless the outcome is kFailed.
  [[nodiscard]] std::string failure() const;
  /// Between 0 and 1: the least of the awaited components' shares. Nothing while one of them has
  /// not said how much it has to do.
  [[nodiscard]] std::optional<double> fraction() const;
  /// "70 %  odometer_replay 10/10  bag_recorder 7/10"; empty before the first report. Once
  /// complete: "finished  bag_recorder 4/4  rack_simulation stopped at 990", where the last one had
  /// not ended and was not awaited.
  [[nodiscard]] std::string line() const;

 private:
  std::vector<NodeName> awaited_;
  std::map<NodeName, ComponentReport> reports_;
};

}  // namespace pipescout::host
