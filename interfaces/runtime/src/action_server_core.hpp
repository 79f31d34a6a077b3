// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <action_msgs/msg/goal_info.hpp>
#include <action_msgs/srv/cancel_goal.hpp>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "action_messages.hpp"
#include "pipescout/runtime/action_server.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/service.hpp"

namespace pipescout {

struct ActionServerEndpoints {
  std::shared_ptr<UntypedPublisher> feedback;
  std::shared_ptr<UntypedPublisher> status;
  std::shared_ptr<UntypedService> send_goal;
  std::shared_ptr<UntypedService> cancel_goal;
  std::shared_ptr<UntypedService> get_result;
};

/// The goals of an action server, from request to result. Shared with the handlers of its services
/// and with the handles of goals, which may outlive the server. Each change of a goal's state, with
/// all that is told of it, happens under one lock; so a goal ends once, and result, status and
/// answers to requests agree. Lock order: this one before those of clock and endpoints; none is
/// held while a handler is called.
class ActionServerCore : public std::enable_shared_from_this<ActionServerCore> {
 public:
  using CancelGoal = action_msgs::srv::CancelGoal;
  using GoalHandle = std::shared_ptr<UntypedServerGoal>;

  /// `now`: the node's clock, not asked any more after `close`. Throws std::invalid_argument.
  ActionServerCore(std::string name, const ActionTypes& types, UntypedActionHandlers handlers,
                   NodeActionServerOptions options, Logger logger, std::function<Time()> now);

  /// Before the services are enabled.
  void attach(ActionServerEndpoints endpoints);
  void close();
  void set_accepting(bool accepting);
  [[nodiscard]] bool is_accepting() const;

  // What the services bring.
  void goal_requested(const std::shared_ptr<const void>& request, const SampleIdentity& caller);
  void cancel_requested(const CancelGoal::Request& request, const SampleIdentity& caller);
  void result_requested(const void* request, const SampleIdentity& caller);

  [[nodiscard]] ActionServerStatistics statistics() const;
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  class Goal;
  using Order = std::uint64_t;  // of acceptance

  struct Record {
    GoalId id;
    builtin_interfaces::msg::Time stamp;  // of acceptance, as told
    GoalStatus status = GoalStatus::kUnknown;
    std::weak_ptr<UntypedServerGoal> handle;
    std::vector<SampleIdentity> waiting;  // for the result
    std::shared_ptr<const void> result;   // once it ended, as the next two
    Time ended{};
    bool is_fetched = false;
  };

  /// Which goals a request to cancel means.
  struct CancelChoice {
    CancelGoal::Response response;
    std::vector<std::pair<Order, GoalHandle>> candidates;
    bool is_of_one = false;
  };

  // What handles do.
  GoalStatus status_of(Order order) const;
  bool execute(Order order);
  bool publish_feedback(Order order, const GoalId& id, std::shared_ptr<void> message);
  bool end(Order order, GoalEvent event, std::shared_ptr<void> response);
  void handle_gone(Order order, const GoalId& id) noexcept;

  void tell_of_aborted(std::size_t count) const;
  void tell_of_rejected(const GoalId& id, const std::string& why) const;
  void preempt_others();
  CancelChoice choose(const CancelGoal::Request& request) const;

  // All that follow under mutex_.
  [[nodiscard]] std::optional<std::string> why_refused(const GoalId& id) const;
  void reject(const SampleIdentity& caller);
  GoalHandle accept(const GoalId& id, const std::shared_ptr<const void>& request,
                    GoalDecision decision, const SampleIdentity& caller);
  std::size_t abort_all();
  void end_goal(Order order, Record& record, GoalStatus status, std::shared_ptr<void> response);
  void forget_expired();
  void forget(Order order);
  /// Tells of it, and drops results that are too many.
  void goals_ended();
  void publish_status();
  [[nodiscard]] std::size_t active_goals() const { return goals_.size() - ended_.size(); }
  static action_msgs::msg::GoalInfo info_of(const Record& record);

  const std::string name_;
  const ActionMessages messages_;
  const UntypedActionHandlers handlers_;
  const NodeActionServerOptions options_;
  const Logger logger_;
  const std::function<Time()> now_;

  mutable std::mutex mutex_;
  ActionServerEndpoints endpoints_;  // all null before attach and after close
  bool is_accepting_ = true;         // false once closed
  bool is_closed_ = false;
  Order last_order_ = 0;
  std::map<Order, Record> goals_;
  std::map<GoalId, Order> orders_;
  std::set<GoalId> deciding_;  // the handler is being asked
  std::deque<Order> ended_;    // in the order of ending
  ActionServerStatistics statistics_;
};

/// The handle: closes the server when it goes.
class ProcessActionServer final : public UntypedActionServer {
 public:
  explicit ProcessActionServer(std::shared_ptr<ActionServerCore> core) : core_(std::move(core)) {}
  ~ProcessActionServer() override { core_->close(); }
  ProcessActionServer(const ProcessActionServer&) = delete;
  ProcessActionServer& operator=(const ProcessActionServer&) = delete;

  void set_accepting(bool accepting) override { core_->set_accepting(accepting); }
  bool is_accepting() const override { return core_->is_accepting(); }
  void close() override { core_->close(); }
  ActionServerStatistics statistics() const override { return core_->statistics(); }
  const std::string& name() const override { return core_->name(); }

 private:
  const std::shared_ptr<ActionServerCore> core_;
};

}  // namespace pipescout
