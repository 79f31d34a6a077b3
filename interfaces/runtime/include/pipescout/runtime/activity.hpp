// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace pipescout {

/// Tells when the nodes of a process are quiescent: no callback of theirs is queued, held back or
/// running, on any executor. Timers that are not due and messages in other processes do not count.
/// A simulation steps, and a replay goes on, when its consumers are quiescent; then the result does
/// not depend on the machine's load. Each context has one. Costs nothing while nobody asks.
/// Thread-safe.
class Activity {
 public:
  /// What one executor has to do. Implemented by executors.
  class Source {
   public:
    virtual ~Source() = default;
    /// Nodes with a callback that is queued, held back or running. `units_of_work`: how much has
    /// arrived ever, so that two looks tell whether something happened in between.
    virtual void look(std::set<std::string>& busy_nodes, std::uint64_t& units_of_work) = 0;
  };

  /// A moment at which the process was quiescent.
  using Moment = std::uint64_t;
  /// Called on the thread that ran the last callback, or on that of the caller. Must neither block
  /// nor throw.
  using Quiescent = std::function<void(Moment)>;

  /// Calls once, when the process is quiescent: at once if it is. The callback that asks is running
  /// itself, so for it that is after its return.
  void when_quiescent(Quiescent quiescent);
  /// True when no work has arrived since, on any executor.
  [[nodiscard]] bool is_quiescent_since(Moment moment);
  /// Nodes that are not quiescent.
  [[nodiscard]] std::set<std::string> busy_nodes();

  /// Does not count the callbacks of this node any more: it hangs, and the others must go on.
  void leave_out(const std::string& node);

  // For executors.

  /// Added once however often it is called. The activity does not keep it.
  void add(const std::shared_ptr<Source>& source);
  [[nodiscard]] bool is_awaited() const noexcept { return awaited_.load(); }
  /// A source has become idle.
  void check();

 private:
  /// Under mutex_; 0: not quiescent. Otherwise the same number until some work arrives.
  [[nodiscard]] Moment quiescent_moment();
  /// Under mutex_. Returns how much work has ever arrived.
  std::uint64_t look(std::set<std::string>& busy);

  std::atomic<bool> awaited_{false};
  std::mutex mutex_;
  std::vector<std::weak_ptr<Source>> sources_;
  std::vector<Quiescent> waiting_;
  std::set<std::string> left_out_;
};

}  // namespace pipescout
