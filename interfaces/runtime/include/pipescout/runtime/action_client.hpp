// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "pipescout/runtime/action.hpp"
#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/service.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Whether a server took a goal.
struct GoalResponse {
  GoalId id;
  bool accepted = false;
  Time stamp{};  ///< when, by the clock of the server
  /// Why there is no answer; none: the server accepted or rejected the goal. A goal whose answer
  /// did not come in time may have been accepted all the same.
  std::optional<ServiceError> error;
};

/// How a goal that was accepted came to its end, as far as its client knows.
enum class GoalEnd {
  kSucceeded,
  kCanceled,
  kAborted,
  kUnknown,  ///< the server does not know the goal: it was started anew, or the result has expired
  kLost,     ///< the server is gone; whether the goal ended is not known
  kClientGone  ///< the client was destroyed before
};

[[nodiscard]] const char* to_string(GoalEnd end) noexcept;

struct UntypedGoalCallbacks {
  std::function<void(const GoalResponse&)> response;
  std::function<void(const std::shared_ptr<const void>& feedback_message)> feedback;
  /// `result_response` is null unless the goal succeeded, was canceled or aborted, and also when
  /// only the status told so: the server was gone, or the result dropped, before it came.
  std::function<void(const GoalId&, GoalEnd, const std::shared_ptr<const void>& result_response)>
      result;
};

/// What became of a request to cancel, with the numbers of action_msgs/srv/CancelGoal.
enum class CancelCode : std::int8_t {
  kNone = 0,  ///< no error: the goals in the list are canceling
  kRejected = 1,
  kUnknownGoal = 2,
  kTerminated = 3  ///< the goal has ended already
};

[[nodiscard]] std::string_view to_string(CancelCode code) noexcept;

struct CancelResponse {
  std::optional<ServiceError> error;  ///< why there is no answer; then the rest means nothing
  CancelCode code = CancelCode::kNone;
  std::vector<GoalId> canceling;  ///< goals that are canceling now
};

/// What to cancel. See action_msgs/srv/CancelGoal.
struct CancelRequest {
  GoalId id = {};  ///< this goal; zero: none in particular
  /// And those that were accepted at or before this time of the server's clock. The default: no
  /// others, or, with a zero `id`, all goals.
  Time not_after{};
};

struct ActionClientStatistics {
  std::uint64_t sent = 0;              ///< goals
  std::uint64_t ended = 0;             ///< of those that were accepted, whose end is known
  std::uint64_t lost = 0;              ///< ended with kLost or kUnknown
  std::uint64_t feedback_dropped = 0;  ///< came before the goal's response, and too many of them
};

/// How a node uses an action. A client works in every lifecycle state.
struct NodeActionClientOptions {
  /// Where the callbacks run: one that the node made; null: its default group.
  std::shared_ptr<CallbackGroup> group = nullptr;
  std::size_t feedback_depth = 10;  ///< messages kept while callbacks run; at least 1
};

/// A client of an action of types known at run time.
///
/// For each goal `response` is called once. If the goal was accepted, `feedback` follows any number
/// of times and `result` exactly once; that order holds in groups of either type. No callback runs
/// with a lock held. When a server is gone, its goals end with kLost as soon as the network tells.
class UntypedActionClient {
 public:
  /// Goals of one client without an end.
  static constexpr std::size_t kMaxGoals = UntypedClient::kMaxOutstandingCalls;

  /// Ends what has no end yet: a response with ServiceError::kCancelled, or a result with
  /// GoalEnd::kClientGone, on the destroying thread. What these callbacks throw is ignored. The
  /// servers go on with the goals.
  virtual ~UntypedActionClient() = default;
  /// Sends a SendGoal request, whose goal_id is set here and which nobody may change afterwards, to
  /// the server, which is waited for within `timeout`. Throws std::invalid_argument when it is
  /// null, std::runtime_error when `kMaxGoals` have no end yet. Thread-safe.
  virtual GoalId send_goal(std::shared_ptr<void> send_goal_request, UntypedGoalCallbacks callbacks,
                           Duration timeout) = 0;
  /// `answer` (optional) is called once, in the client's group; with kCancelled when the client
  /// goes before. Thread-safe.
  virtual void cancel(const CancelRequest& request,
                      std::function<void(const CancelResponse&)> answer, Duration timeout) = 0;
  /// Last heard of a goal of this client that has not ended; kUnknown of any other.
  [[nodiscard]] virtual GoalStatus status(const GoalId& id) const = 0;
  /// A server is matched on all its services and topics: no feedback will be missed.
  [[nodiscard]] virtual bool is_ready() const = 0;
  [[nodiscard]] virtual ActionClientStatistics statistics() const = 0;
  /// Fully qualified.
  [[nodiscard]] virtual const std::string& name() const = 0;
};

/// The end of a goal, with its result.
template <ActionTag A>
struct GoalOutcome {
  using Result = typename ActionType<A>::Result;
  GoalId id;
  GoalEnd end = GoalEnd::kUnknown;
  /// Null unless the goal succeeded, was canceled or aborted, and also when only the status told
  /// so: the server was gone, or the result dropped, before it came.
  std::shared_ptr<const Result> result;

  /// It succeeded.
  [[nodiscard]] explicit operator bool() const noexcept { return end == GoalEnd::kSucceeded; }
};

/// What a client is told of a goal. Each may be empty.
template <ActionTag A>
struct GoalCallbacks {
  using Feedback = typename ActionType<A>::Feedback;
  std::function<void(const GoalResponse&)> response = {};
  std::function<void(const std::shared_ptr<const Feedback>&)> feedback = {};
  std::function<void(const GoalOutcome<A>&)> result = {};
};

/// A handle: the client ends with the last copy. See UntypedActionClient.
template <ActionTag A>
class ActionClient {
 public:
  using Goal = typename ActionType<A>::Goal;

  ActionClient() = default;
  explicit ActionClient(std::shared_ptr<UntypedActionClient> untyped)
      : untyped_(std::move(untyped)) {}

  /// Never blocks. The server is waited for within `timeout`. Throws std::runtime_error when
  /// UntypedActionClient::kMaxGoals have no end yet.
  GoalId send_goal(Goal goal, GoalCallbacks<A> callbacks = {},
                   Duration timeout = std::chrono::seconds(5)) {
    auto request = std::make_shared<typename ActionType<A>::SendGoal::Request>();
    request->goal = std::move(goal);
    return untyped_->send_goal(std::move(request), untyped_callbacks(std::move(callbacks)),
                               timeout);
  }
  /// Cancels one goal.
  void cancel(const GoalId& id, std::function<void(const CancelResponse&)> answer = {},
              Duration timeout = std::chrono::seconds(5)) {
    untyped_->cancel({.id = id}, std::move(answer), timeout);
  }
  /// Cancels every goal of the server, also those of other clients.
  void cancel_all(std::function<void(const CancelResponse&)> answer = {},
                  Duration timeout = std::chrono::seconds(5)) {
    untyped_->cancel({}, std::move(answer), timeout);
  }
  /// Cancels the goals that were accepted at or before that time of the server's clock, which is
  /// not zero, also those of other clients.
  void cancel_not_after(Time time, std::function<void(const CancelResponse&)> answer = {},
                        Duration timeout = std::chrono::seconds(5)) {
    untyped_->cancel({.not_after = time}, std::move(answer), timeout);
  }
  [[nodiscard]] GoalStatus status(const GoalId& id) const { return untyped_->status(id); }
  [[nodiscard]] bool is_ready() const { return untyped_->is_ready(); }
  [[nodiscard]] ActionClientStatistics statistics() const { return untyped_->statistics(); }
  [[nodiscard]] const std::shared_ptr<UntypedActionClient>& untyped() const { return untyped_; }
  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }

 private:
  static UntypedGoalCallbacks untyped_callbacks(GoalCallbacks<A> callbacks) {
    using Type = ActionType<A>;
    using Response = typename Type::GetResult::Response;
    UntypedGoalCallbacks result;
    if (callbacks.feedback) {
      result.feedback =
          [told = std::move(callbacks.feedback)](const std::shared_ptr<const void>& message) {
            const auto* typed = static_cast<const typename Type::FeedbackMessage*>(message.get());
            told(std::shared_ptr<const typename Type::Feedback>(message, &typed->feedback));
          };
    }
    result.response = std::move(callbacks.response);
    if (callbacks.result) {
      result.result = [told = std::move(callbacks.result)](
                          const GoalId& id, GoalEnd end,
                          const std::shared_ptr<const void>& response) {
        GoalOutcome<A> outcome{.id = id, .end = end, .result = nullptr};
        if (response) {
          outcome.result = std::shared_ptr<const typename Type::Result>(
              response, &static_cast<const Response*>(response.get())->result);
        }
        told(outcome);
      };
    }
    return result;
  }

  std::shared_ptr<UntypedActionClient> untyped_;
};

}  // namespace pipescout
