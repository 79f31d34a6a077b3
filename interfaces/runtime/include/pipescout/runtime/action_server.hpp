// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "pipescout/runtime/action.hpp"
#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

enum class GoalDecision {
  kReject,
  kAccept,  ///< and execute: the goal is executing when `accepted` is called
  kDefer    ///< accept; the goal waits until `execute` is called
};

enum class CancelDecision { kReject, kAccept };

struct ActionServerStatistics {
  std::uint64_t accepted = 0;
  std::uint64_t rejected = 0;  ///< by the handler, as a duplicate, while inactive, or too many
  std::uint64_t succeeded = 0;
  std::uint64_t canceled = 0;
  std::uint64_t aborted = 0;  ///< all that were, also those of the next line
  std::uint64_t dropped = 0;  ///< aborted, since the last handle went before the goal ended
  /// Results that nobody had asked for when they made room for newer ones.
  std::uint64_t results_lost = 0;
};

/// How a node serves an action.
struct NodeActionServerOptions {
  /// Where the handlers run: one that the node made; null: its default group.
  std::shared_ptr<CallbackGroup> group = nullptr;
  /// A managed server takes goals only while its component is active; all goals that have not ended
  /// are aborted when it no longer is.
  bool managed = true;
  /// One goal at a time: a new one ends the one before, as aborted, unless the handler `preempted`
  /// ends it otherwise.
  bool preempts = false;
  std::size_t max_goals = 100;     ///< that have not ended; further ones are rejected; at least 1
  std::size_t max_results = 1000;  ///< kept at most; those that were fetched go first; at least 1
  /// How long a result is kept after the end of its goal, by the node's clock; not negative.
  Duration result_timeout = std::chrono::minutes(15);
  std::size_t feedback_depth = 10;  ///< messages kept for a slow reader; at least 1
};

/// A goal on the side of the server, of a type known at run time. When the last handle goes before
/// the goal has ended, it is aborted, which is logged and counted. Thread-safe.
class UntypedServerGoal {
 public:
  virtual ~UntypedServerGoal() = default;
  [[nodiscard]] virtual const GoalId& id() const noexcept = 0;
  /// When it was accepted, by the node's clock.
  [[nodiscard]] virtual Time accepted_at() const noexcept = 0;
  /// The send_goal request; `goal_in` finds the goal in it.
  [[nodiscard]] virtual const std::shared_ptr<const void>& request() const noexcept = 0;
  [[nodiscard]] virtual GoalStatus status() const = 0;
  /// Begins a deferred goal. False when it is executing, canceling or over already.
  virtual bool execute() = 0;
  /// Publishes a FeedbackMessage, whose goal_id is set here and which nobody may change afterwards.
  /// False when the goal is over. Throws std::invalid_argument when it is null.
  virtual bool publish_feedback(std::shared_ptr<void> feedback_message) = 0;
  /// Ends the goal by kSucceed, kAbort or kCancel with a GetResult response, whose status is set
  /// here and which nobody may change afterwards. False when the goal is over: what was told first
  /// stays. Throws std::logic_error when its state does not allow the event: kSucceed before
  /// `execute`, kCancel when nobody asked for it; std::invalid_argument when the response is null.
  virtual bool end(GoalEvent event, std::shared_ptr<void> result_response) = 0;
};

struct UntypedActionHandlers {
  using Goal = std::shared_ptr<UntypedServerGoal>;
  std::function<GoalDecision(const GoalId&, const std::shared_ptr<const void>& request)> decide;
  std::function<CancelDecision(const Goal&)> cancel;
  std::function<void(const Goal&)> accepted;
  std::function<void(const Goal&)> canceling;
  std::function<void(const Goal&)> preempted;
};

/// Serves an action of types known at run time. Thread-safe.
class UntypedActionServer {
 public:
  /// Aborts the goals that have not ended.
  virtual ~UntypedActionServer() = default;
  /// While it accepts nothing, goals are rejected; those that have not ended are aborted when that
  /// begins. Goals are cancelled and results given all the same.
  virtual void set_accepting(bool accepting) = 0;
  [[nodiscard]] virtual bool is_accepting() const = 0;
  /// For good: as if it were destroyed.
  virtual void close() = 0;
  [[nodiscard]] virtual ActionServerStatistics statistics() const = 0;
  /// Fully qualified: "/robot/navigate_to_pose".
  [[nodiscard]] virtual const std::string& name() const = 0;
};

/// A goal that a server has accepted. A handle: copies share the goal. When the last one goes
/// before the goal has ended, it is aborted, which is logged and counted; so whoever works on a
/// goal keeps its handle. Thread-safe, except for assigning.
template <ActionTag A>
class ServerGoal {
 public:
  using Goal = typename ActionType<A>::Goal;
  using Result = typename ActionType<A>::Result;
  using Feedback = typename ActionType<A>::Feedback;

  ServerGoal() = default;
  explicit ServerGoal(std::shared_ptr<UntypedServerGoal> untyped) : untyped_(std::move(untyped)) {}

  [[nodiscard]] const Goal& goal() const { return request().goal; }
  /// Keeps the goal's message, not the goal.
  [[nodiscard]] std::shared_ptr<const Goal> shared_goal() const {
    return {untyped_->request(), &request().goal};
  }
  [[nodiscard]] const GoalId& id() const noexcept { return untyped_->id(); }
  [[nodiscard]] Time accepted_at() const noexcept { return untyped_->accepted_at(); }
  [[nodiscard]] GoalStatus status() const { return untyped_->status(); }
  /// It has not ended.
  [[nodiscard]] bool is_active() const { return pipescout::is_active(status()); }
  /// A client asked to cancel it, and it has not ended.
  [[nodiscard]] bool is_canceling() const { return status() == GoalStatus::kCanceling; }

  // What all return: false when the goal is over, because of the server's own component too (see
  // NodeActionServerOptions): what was told first stays.

  /// Begins a deferred goal. False too when it is executing or canceling already.
  bool execute() const { return untyped_->execute(); }
  bool publish_feedback(Feedback feedback) const {
    auto message = std::make_shared<typename ActionType<A>::FeedbackMessage>();
    message->feedback = std::move(feedback);
    return untyped_->publish_feedback(std::move(message));
  }
  /// Throws std::logic_error when it was deferred and is not executing.
  bool succeed(Result result = {}) const { return end(GoalEvent::kSucceed, std::move(result)); }
  bool abort(Result result = {}) const { return end(GoalEvent::kAbort, std::move(result)); }
  /// Throws std::logic_error unless it is canceling.
  bool canceled(Result result = {}) const { return end(GoalEvent::kCancel, std::move(result)); }

  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }
  /// The same goal.
  bool operator==(const ServerGoal&) const = default;
  [[nodiscard]] const std::shared_ptr<UntypedServerGoal>& untyped() const { return untyped_; }

 private:
  using Request = typename ActionType<A>::SendGoal::Request;
  const Request& request() const { return *static_cast<const Request*>(untyped_->request().get()); }
  bool end(GoalEvent event, Result result) const {
    auto response = std::make_shared<typename ActionType<A>::GetResult::Response>();
    response->result = std::move(result);
    return untyped_->end(event, std::move(response));
  }

  std::shared_ptr<UntypedServerGoal> untyped_;
};

/// What a component does with goals. All run in the server's callback group, none with a lock held;
/// each may end the goal. What one throws goes where exceptions of callbacks go; the goal is
/// rejected, not cancelled or aborted then.
template <ActionTag A>
struct ActionHandlers {
  using Goal = std::shared_ptr<const typename ActionType<A>::Goal>;

  /// Whether to take a goal. Empty: kAccept.
  std::function<GoalDecision(const GoalId&, const Goal&)> decide = {};
  /// A goal was taken; its client knows. Must keep the handle, or end the goal. Needed.
  std::function<void(ServerGoal<A>)> accepted = {};
  /// Whether a client may cancel a goal. Empty: kAccept.
  std::function<CancelDecision(const ServerGoal<A>&)> cancel = {};
  /// The goal is canceling; its client knows. The place to stop the work and call `canceled`; the
  /// goal may still succeed or abort. Empty: whoever works on it asks `is_canceling`.
  std::function<void(const ServerGoal<A>&)> canceling = {};
  /// With `preempts`: the goal is about to make room for another. The place to stop the work. May
  /// end the goal with a result of its own; it is aborted with an empty one otherwise.
  std::function<void(const ServerGoal<A>&)> preempted = {};

  [[nodiscard]] UntypedActionHandlers untyped() &&;
};

/// A handle: the server ends with the last copy.
template <ActionTag A>
class ActionServer {
 public:
  ActionServer() = default;
  explicit ActionServer(std::shared_ptr<UntypedActionServer> untyped)
      : untyped_(std::move(untyped)) {}
  [[nodiscard]] ActionServerStatistics statistics() const { return untyped_->statistics(); }
  [[nodiscard]] const std::shared_ptr<UntypedActionServer>& untyped() const { return untyped_; }
  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }

 private:
  std::shared_ptr<UntypedActionServer> untyped_;
};

template <ActionTag A>
UntypedActionHandlers ActionHandlers<A>::untyped() && {
  using Request = typename ActionType<A>::SendGoal::Request;
  using Untyped = std::shared_ptr<UntypedServerGoal>;
  UntypedActionHandlers result;
  if (decide) {
    result.decide = [handler = std::move(decide)](const GoalId& id,
                                                  const std::shared_ptr<const void>& request) {
      return handler(id, Goal(request, &static_cast<const Request*>(request.get())->goal));
    };
  }
  const auto typed = [](auto handler) {
    return [handler = std::move(handler)](const Untyped& goal) {
      return handler(ServerGoal<A>(goal));
    };
  };
  if (cancel) {
    result.cancel = typed(std::move(cancel));
  }
  if (accepted) {
    result.accepted = typed(std::move(accepted));
  }
  if (canceling) {
    result.canceling = typed(std::move(canceling));
  }
  if (preempted) {
    result.preempted = typed(std::move(preempted));
  }
  return result;
}

}  // namespace pipescout
