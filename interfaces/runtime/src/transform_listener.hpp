// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/clock.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/transforms.hpp"

namespace tf2_msgs::msg {
struct TFMessage;
}

namespace pipescout {

/// One buffer of a process and what fills it from two subscriptions, shared by the nodes that use
/// the same topics. Runs on the threads that bring the messages. Thread-safe.
class TransformListener : public std::enable_shared_from_this<TransformListener> {
 public:
  /// Topics by their fully qualified names. The subscriptions end with the last copy of the pointer
  /// that is returned. They do not belong to the object itself, which a callback keeps while it
  /// runs: it must not be the one that destroys its own subscription.
  [[nodiscard]] static std::shared_ptr<TransformListener> create(
      Context& context, const std::string& tf_topic, const std::string& tf_static_topic);
  explicit TransformListener(Context& context);

  [[nodiscard]] TransformBuffer& buffer();
  /// The two, to be listed in the graph, for as long as they are there.
  [[nodiscard]] std::vector<std::shared_ptr<UntypedSubscription>> subscriptions() const;

  /// Who logs what is refused: the first whose group is still there.
  void add_reporter(const Logger& logger, const std::shared_ptr<CallbackGroup>& group);
  /// Null: the time of this machine. When the clock is set back, what moves is forgotten.
  void follow(std::shared_ptr<SimulatedClock> clock);

  /// Takes part in the notifications until it is removed or gone. False when there are too many.
  bool add(const std::shared_ptr<TransformWait::State>& wait);
  void remove(const TransformWait::State* wait);

  [[nodiscard]] TransformStatistics statistics() const;

 private:
  struct Refusal {
    TransformRefusal refusal;
    Gid publisher;
  };

  void take(const tf2_msgs::msg::TFMessage& message, bool is_static, const Gid& publisher);
  void refuse(TransformRefusal refusal, const std::string& child, const Gid& publisher);
  void notify();
  /// With the names of the nodes that publish.
  [[nodiscard]] std::string describe(const Refusal& refused) const;

  TransformBuffer buffer_;
  const std::weak_ptr<Context> context_;

  mutable std::mutex mutex_;
  std::shared_ptr<SimulatedClock> clock_;
  std::shared_ptr<void> clock_set_back_;
  std::uint64_t received_ = 0;
  std::map<TransformFault, std::uint64_t> refused_;
  std::optional<Refusal> last_;
  std::set<std::pair<TransformFault, std::string>> logged_;
  std::vector<std::pair<Logger, std::weak_ptr<CallbackGroup>>> reporters_;

  std::mutex waits_mutex_;  // before the group's and the buffer's
  std::map<const TransformWait::State*, std::weak_ptr<TransformWait::State>> waits_;
  std::atomic<std::size_t> waiting_ = 0;  // as many as waits_

  std::vector<std::weak_ptr<UntypedSubscription>> subscriptions_;  // since `create`
};

/// A wait and the work that answers it.
class TransformWait::State final : public Waitable,
                                   public std::enable_shared_from_this<TransformWait::State> {
 public:
  State(std::shared_ptr<TransformListener> listener, std::string target, std::string source,
        Time time, Transforms::Callback callback, std::shared_ptr<CallbackGroup> group,
        std::shared_ptr<SimulatedClock> clock);

  /// Schedules the end of the wait.
  void begin(Duration timeout);
  /// Schedules the answer if there is one; true then. Called with the listener's lock on waits.
  bool answer_if_known();
  /// Refuses at once.
  void refuse(TransformFailure failure);
  void cancel();
  [[nodiscard]] bool is_waiting() const;

  void execute() override;

 private:
  const std::shared_ptr<TransformListener> listener_;
  const std::string target_;
  const std::string source_;
  const Time time_;
  const std::shared_ptr<CallbackGroup> group_;
  const std::shared_ptr<SimulatedClock> clock_;  // null: the steady clock

  mutable std::mutex mutex_;
  Transforms::Callback callback_;  // empty: answered or cancelled
  std::optional<TransformResult> answer_;
};

}  // namespace pipescout
