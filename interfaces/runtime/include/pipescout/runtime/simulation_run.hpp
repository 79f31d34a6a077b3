// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/lock_step.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// What simulators have in common: their steps begin once the awaited nodes have subscribed, run in
/// lock step with those that follow the clock, and no faster than a rate. Parameters of the node:
/// `rate`, `step_time_out`, and `wait_for_subscribers.<topic>`, see AwaitedSubscribers. They take
/// effect in `configure`. To be used in the node's default group.
class SimulationRun {
 public:
  /// One step; false: it was the last.
  using Step = std::function<bool()>;
  /// Component::report_fault
  using ReportFault = std::function<void(std::string_view counter, std::string_view text)>;

  /// `topics`: names of those whose subscribers may be awaited.
  SimulationRun(Node& node, const std::vector<std::string>& topics);

  /// For PublisherEvents::matched of the publishers of `topics`.
  [[nodiscard]] std::function<void(std::size_t)> on_matched() { return awaited_.on_matched(); }
  /// `clock` and `publishers` (one for each of the topics) must exist until `clean_up`; `period`:
  /// simulated time of a step. Throws std::invalid_argument for an invalid node name in a
  /// parameter.
  void configure(const UntypedPublisher& clock,
                 const std::vector<std::shared_ptr<UntypedPublisher>>& publishers, Duration period,
                 Step step, ReportFault report_fault);
  /// Steps begin, or go on, unless the last one is made.
  void activate();
  void deactivate();
  void clean_up();

  /// See AwaitedSubscribers.
  [[nodiscard]] bool all_there() const { return awaited_.all_there(); }
  [[nodiscard]] std::string missing() const { return awaited_.missing(); }

 private:
  void resume();

  Node& node_;
  Parameter<double> rate_;
  Parameter<double> step_time_out_;
  AwaitedSubscribers awaited_;
  std::optional<LockStep> lock_step_;
  bool active_ = false;
  bool has_ended_ = false;
};

}  // namespace pipescout
