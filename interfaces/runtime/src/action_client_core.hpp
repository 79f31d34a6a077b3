// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <action_msgs/msg/goal_status_array.hpp>
#include <action_msgs/srv/cancel_goal.hpp>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "action_messages.hpp"
#include "pipescout/runtime/action_client.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/subscription.hpp"

namespace pipescout {

struct ActionClientEndpoints {
  std::shared_ptr<UntypedSubscription> feedback;
  std::shared_ptr<UntypedSubscription> status;
  std::shared_ptr<UntypedClient> send_goal;
  std::shared_ptr<UntypedClient> cancel_goal;
  std::shared_ptr<UntypedClient> get_result;
};

/// The goals of an action client, from sending to their end. Shared with the callbacks of its
/// endpoints. A goal leaves the table once, under the lock, and whoever took it out tells of its
/// end; so each has one end. Lock order: this one before those of the endpoints; none is held while
/// a callback runs.
class ActionClientCore : public std::enable_shared_from_this<ActionClientCore> {
 public:
  using CancelGoal = action_msgs::srv::CancelGoal;

  /// Throws std::invalid_argument.
  ActionClientCore(std::string name, const ActionTypes& types, NodeActionClientOptions options,
                   Logger logger, Context& context);

  void attach(ActionClientEndpoints endpoints);
  void close();

  GoalId send_goal(std::shared_ptr<void> request, UntypedGoalCallbacks callbacks, Duration timeout);
  void cancel(const CancelRequest& request, std::function<void(const CancelResponse&)> answer,
              Duration timeout);
  [[nodiscard]] GoalStatus status(const GoalId& id) const;
  [[nodiscard]] bool is_ready() const;
  [[nodiscard]] ActionClientStatistics statistics() const;
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  // What the endpoints bring.
  void feedback_came(const std::shared_ptr<const void>& message);
  void status_came(const action_msgs::msg::GoalStatusArray& message);
  void servers_changed();

 private:
  struct Goal {
    std::shared_ptr<const UntypedGoalCallbacks> callbacks;
    GoalStatus status = GoalStatus::kUnknown;
    Gid server;                                        // its reply writer; zero before the response
    bool is_told = false;                              // the response, and all feedback before it
    std::deque<std::shared_ptr<const void>> feedback;  // until it is told
    std::uint64_t result_call = 0;                     // 0: not asked for yet
  };
  using Goals = std::map<GoalId, Goal>;

  void answered(const GoalId& id, const ServiceResult<void>& result);
  void accepted(const GoalId& id, const GoalResponse& response, const Gid& server);
  /// Calls back what came before the response was told, then what comes is told at once.
  void tell_held_feedback(const GoalId& id);
  void ask_for_result(const GoalId& id);
  void result_came(const GoalId& id, const ServiceResult<void>& result);
  /// Moves a goal from the table to `lost` when its server is gone; under mutex_.
  void take_if_lost(Goals::iterator goal, Goals& lost);
  void tell_lost(const Goals& lost);
  void tell_result(const GoalId& id, const Goal& goal, GoalEnd end,
                   const std::shared_ptr<const void>& response);
  /// The goal, which is no longer in the table; its callbacks are null when it was not there.
  Goal take(const GoalId& id);
  void warn_without_server() const;

  const std::string name_;
  const ActionMessages messages_;
  const NodeActionClientOptions options_;
  const Logger logger_;
  const std::weak_ptr<Context> context_;

  mutable std::mutex mutex_;
  ActionClientEndpoints endpoints_;  // all null before attach and after close
  Goals goals_;
  ActionClientStatistics statistics_;
};

/// The handle: closes the client when it goes.
class ProcessActionClient final : public UntypedActionClient {
 public:
  explicit ProcessActionClient(std::shared_ptr<ActionClientCore> core) : core_(std::move(core)) {}
  ~ProcessActionClient() override { core_->close(); }
  ProcessActionClient(const ProcessActionClient&) = delete;
  ProcessActionClient& operator=(const ProcessActionClient&) = delete;

  GoalId send_goal(std::shared_ptr<void> request, UntypedGoalCallbacks callbacks,
                   Duration timeout) override {
    return core_->send_goal(std::move(request), std::move(callbacks), timeout);
  }
  void cancel(const CancelRequest& request, std::function<void(const CancelResponse&)> answer,
              Duration timeout) override {
    core_->cancel(request, std::move(answer), timeout);
  }
  GoalStatus status(const GoalId& id) const override { return core_->status(id); }
  bool is_ready() const override { return core_->is_ready(); }
  ActionClientStatistics statistics() const override { return core_->statistics(); }
  const std::string& name() const override { return core_->name(); }

 private:
  const std::shared_ptr<ActionClientCore> core_;
};

}  // namespace pipescout
