// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "pipescout/runtime/activity.hpp"
#include "pipescout/runtime/context.hpp"
#include "step_traffic.hpp"

namespace pipescout {

class Broker;

/// Calls when a process is quiescent after samples of other processes have arrived, with what it
/// has received and sent by then. Thread-safe.
class QuiescenceWatch : public std::enable_shared_from_this<QuiescenceWatch> {
 public:
  /// Called on the thread that ran the last callback, or on one of the process's own, one call
  /// after the other with counts that never go back; must neither block nor throw. `steps`: that
  /// had begun before the process was seen to be quiescent.
  using Quiescent = std::function<void(const StepTraffic::Counts&, std::uint64_t steps)>;

  static std::shared_ptr<QuiescenceWatch> create(std::shared_ptr<Activity> activity,
                                                 std::shared_ptr<StepTraffic> traffic,
                                                 std::shared_ptr<CallbackGroup> group,
                                                 Quiescent quiescent);
  ~QuiescenceWatch();
  QuiescenceWatch(const QuiescenceWatch&) = delete;
  QuiescenceWatch& operator=(const QuiescenceWatch&) = delete;

  /// Asks without waiting for samples. Not for threads of the transport.
  void request();
  /// For a simulation: to be called before each of its steps.
  void count_step() noexcept { ++steps_; }
  [[nodiscard]] std::uint64_t steps() const noexcept { return steps_.load(); }

 private:
  QuiescenceWatch(std::shared_ptr<Activity> activity, std::shared_ptr<StepTraffic> traffic,
                  std::shared_ptr<CallbackGroup> group, Quiescent quiescent);
  void post_request();
  void tell(Activity::Moment moment);

  const std::shared_ptr<Activity> activity_;
  const std::shared_ptr<StepTraffic> traffic_;
  const std::shared_ptr<CallbackGroup> group_;  // on a thread that no component can hold up
  const Quiescent quiescent_;
  std::mutex mutex_;  // held while `quiescent_` is called
  std::atomic<bool> requested_{false};
  std::atomic<std::uint64_t> steps_{0};
  std::shared_ptr<const std::function<void()>> on_change_;
};

/// Tells the simulation that drives a clock each time when this process, whose nodes follow it, has
/// nothing more to do. Exists while such nodes do. Thread-safe.
class StepReporter {
 public:
  /// `clock`: DDS name of the clock's topic. Throws TransportError.
  StepReporter(const std::shared_ptr<Broker>& broker, const std::shared_ptr<Activity>& activity,
               const std::string& clock);
  StepReporter(const StepReporter&) = delete;
  StepReporter& operator=(const StepReporter&) = delete;
  ~StepReporter();

  void add_node(const std::string& name);
  void remove_node(const std::string& name);
  /// Of the reports, for the graph.
  [[nodiscard]] std::shared_ptr<UntypedPublisher> publisher() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

/// A node's part in the reports of its process.
struct StepParticipation {
  StepParticipation(std::shared_ptr<StepReporter> given, std::string node)
      : reporter(std::move(given)), name(std::move(node)) {
    reporter->add_node(name);
  }
  StepParticipation(const StepParticipation&) = delete;
  StepParticipation& operator=(const StepParticipation&) = delete;
  ~StepParticipation() { reporter->remove_node(name); }
  const std::shared_ptr<StepReporter> reporter;
  const std::string name;
};

/// DDS name of the topic on which processes report to the simulation that drives a clock.
[[nodiscard]] std::string step_report_topic(const std::string& clock);

}  // namespace pipescout
