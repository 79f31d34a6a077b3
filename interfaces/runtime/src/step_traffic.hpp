// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// Whether a simulation in lock step waits for samples of this DDS topic: not for those on which
/// nodes report on themselves by the wall clock.
[[nodiscard]] bool is_step_traffic(std::string_view dds_topic);

/// Up to which sample a process has sent to each other process, and has received from each writer
/// there. Nothing is under way between processes when the numbers agree (Mattern, Algorithms for
/// distributed termination detection, 1987). Counts only once it was enabled. Thread-safe.
class StepTraffic {
 public:
  struct Counts {
    /// By writer of this process and participant of the reader.
    std::map<std::pair<Gid, Gid>, std::int64_t> sent;
    /// By writer of another process.
    std::map<Gid, std::int64_t> received;
    bool operator==(const Counts&) const = default;
  };

  void enable() noexcept { enabled_ = true; }
  [[nodiscard]] bool is_enabled() const noexcept { return enabled_.load(); }

  void sent(const Gid& writer, const std::vector<Gid>& participants, std::int64_t sequence_number);
  /// The readers of a writer are in these participants now: what was sent to others is not under
  /// way any more.
  void readers_changed(const Gid& writer, const std::vector<Gid>& participants);
  /// To be called when the sample waits in the queues of its subscriptions.
  void received(const SampleIdentity& sample);
  [[nodiscard]] Counts counts() const;

  /// `call` is called after each change of what is under way to or from this process that is not
  /// made by this process's own callbacks, on the thread that makes it, while `call` exists. It
  /// must return soon and must not publish.
  void on_change(const std::shared_ptr<const std::function<void()>>& call);

 private:
  using Listeners = std::vector<std::shared_ptr<const std::function<void()>>>;
  [[nodiscard]] Listeners listeners();  // under mutex_
  static void tell(const Listeners& listeners);

  std::atomic<bool> enabled_{false};
  mutable std::mutex mutex_;
  Counts counts_;
  std::vector<std::weak_ptr<const std::function<void()>>> listeners_;
};

}  // namespace pipescout
