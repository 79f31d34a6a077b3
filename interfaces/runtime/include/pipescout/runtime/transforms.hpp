// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "pipescout/runtime/transform_buffer.hpp"

namespace pipescout {

class CallbackGroup;
class Node;
class TransformListener;

/// What became of the transforms that a process received.
struct TransformStatistics {
  std::uint64_t received = 0;
  std::map<TransformFault, std::uint64_t> refused;
  /// What was wrong with the last one that was refused, with the nodes that publish it; empty:
  /// none.
  std::string last_refused;
};

/// A wait that `Transforms::wait_for` began. Destroying it ends the wait: the callback does not
/// begin afterwards, and may only be running still when another thread than that of its group
/// destroys it.
class [[nodiscard]] TransformWait {
 public:
  class State;
  TransformWait() = default;
  explicit TransformWait(std::shared_ptr<State> state) : state_(std::move(state)) {}
  TransformWait(TransformWait&&) noexcept = default;
  TransformWait& operator=(TransformWait&& other) noexcept;
  ~TransformWait();

  /// False once the callback has begun.
  [[nodiscard]] bool is_waiting() const;

 private:
  std::shared_ptr<State> state_;
};

/// The transforms of a node's robot: those of `tf` and `tf_static`, relative to the node's
/// namespace and remapped as any topic. See `Node::transforms`.
///
/// All nodes of a process with the same topics share one subscription of each and one buffer, which
/// take every message once, on the thread that brings it: whoever looks a transform up in a
/// callback has all that was published before in this process. A node that looks nothing up costs
/// nothing.
///
/// Transforms that are refused are counted by their fault on `/diagnostics` of each component that
/// asks for transforms, and the first of each kind and child is logged. When the time on `/clock`
/// goes back, what moves is forgotten. Thread-safe.
class Transforms {
 public:
  using Callback = std::function<void(const TransformResult&)>;

  /// By `Node::transforms`; the node outlives it.
  explicit Transforms(Node& node);
  Transforms(const Transforms&) = delete;
  Transforms& operator=(const Transforms&) = delete;
  ~Transforms();

  /// The buffer keeps at least so much, for all nodes of the process; 10 s unless somebody asks for
  /// more.
  void require_history(Duration history);

  /// As those of the buffer.
  TransformResult lookup(std::string_view target, std::string_view source,
                         Time time = kLatestTransform) const;
  TransformResult lookup(std::string_view target, Time target_time, std::string_view source,
                         Time source_time, std::string_view fixed) const;
  [[nodiscard]] bool can_transform(std::string_view target, std::string_view source,
                                   Time time = kLatestTransform,
                                   TransformFailure* reason = nullptr) const;

  /// Calls `callback` once in `group` (null: the node's default group): with the transform as soon
  /// as it is known, or after `timeout` with the reason why it is not. The timeout is measured by
  /// the node's clock, as timers are. No thread waits. A time before the history will not become
  /// known, and is answered at once; so is the wait when 1000 others of the process go on already
  /// (kTooManyWaits). Throws std::invalid_argument for a negative timeout.
  TransformWait wait_for(std::string_view target, std::string_view source, Time time,
                         Duration timeout, Callback callback,
                         std::shared_ptr<CallbackGroup> group = nullptr);

  [[nodiscard]] const TransformBuffer& buffer() const;
  [[nodiscard]] TransformStatistics statistics() const;

 private:
  friend class Node;
  /// The node follows that clock from now on; null: its machine's.
  void follow(std::shared_ptr<class SimulatedClock> clock);

  Node& node_;
  std::shared_ptr<TransformListener> listener_;
};

}  // namespace pipescout
