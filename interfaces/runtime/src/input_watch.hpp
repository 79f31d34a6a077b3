// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// What was found of one watched input.
struct InputReport {
  std::string topic{};                          ///< ROS name
  std::map<std::string, std::string> values{};  ///< "rate_hz", "age_s", as far as they are known
  DiagnosticLevel level = DiagnosticLevel::kOk;
  std::string message{};  ///< what is wrong; empty at kOk
};

/// Watches rate and age of the inputs of a component, as it declares them (`expected` of
/// NodeSubscriptionOptions) or the parameters `inputs.*` do. Judges while the component is active,
/// over the last second of its clock, or as long as five messages take at the declared rate. An
/// input of which nothing has come yet is STALE, which is no fault: its source has not begun.
///
/// In the component's default group.
class InputWatch {
 public:
  /// Declares the parameters.
  explicit InputWatch(Component& component);

  /// Reads the parameters. Throws std::invalid_argument, naming the parameter, when the lists
  /// differ in length, a topic is no name or stands there twice, or a limit is negative or not
  /// finite.
  void configure();

  /// Looks at all watched inputs now.
  [[nodiscard]] std::vector<InputReport> look();

 private:
  /// Messages received until then.
  struct Count {
    Time time;
    std::uint64_t received;
  };
  struct History {
    std::deque<Count> counts;  // the oldest is the last one before the window
    Time changed{};            // when `received` was last seen to grow
  };

  using Histories = std::map<std::weak_ptr<const UntypedSubscription>, History,
                             std::owner_less<std::weak_ptr<const UntypedSubscription>>>;

  [[nodiscard]] static InputReport judge(const UntypedSubscription& subscription, History& history,
                                         const InputExpectation& expected, Time now);

  Component& component_;
  Parameter<std::vector<std::string>> topics_;
  Parameter<std::vector<double>> minimum_rates_;
  Parameter<std::vector<double>> maximum_ages_;
  std::map<std::string, InputExpectation> declared_;  // by the parameters; ROS name
  Histories histories_;
};

}  // namespace pipescout
