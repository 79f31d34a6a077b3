// SPDX-License-Identifier: Apache-2.0
#include "action_server_core.hpp"

#include <action_msgs/msg/goal_status_array.hpp>
#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/goal_rejected.hpp"

namespace pipescout {

namespace {

/// Who waits for the result of one goal: more are a client that asks again and again, of which the
/// earliest requests go.
constexpr std::size_t kMaxWaiting = 100;

constexpr const char* kNotActive = "the server is not active";

void require_at_least(const std::string& action, const char* field, std::size_t value) {
  if (value < 1) {
    throw std::invalid_argument("action '" + action + "': " + field + " = 0 is not at least 1");
  }
}

/// Keeps the first exception of several handlers.
template <class Function>
void contained(std::exception_ptr& first, const Function& function) {
  try {
    function();
  } catch (...) {
    if (!first) {
      first = std::current_exception();
    }
  }
}

const char* text_of(GoalEvent event) {
  switch (event) {
    case GoalEvent::kExecute:
      return "executed";
    case GoalEvent::kRequestCancel:
      return "asked to cancel";
    case GoalEvent::kSucceed:
      return "said to have succeeded";
    case GoalEvent::kAbort:
      return "aborted";
    case GoalEvent::kCancel:
      return "said to be canceled";
  }
  return "changed";
}

}  // namespace

class ActionServerCore::Goal final : public UntypedServerGoal {
 public:
  Goal(std::shared_ptr<ActionServerCore> core, Order order, const GoalId& id, Time accepted_at,
       std::shared_ptr<const void> request)
      : core_(std::move(core)),
        order_(order),
        id_(id),
        accepted_at_(accepted_at),
        request_(std::move(request)) {}
  ~Goal() override { core_->handle_gone(order_, id_); }
  Goal(const Goal&) = delete;
  Goal& operator=(const Goal&) = delete;

  const GoalId& id() const noexcept override { return id_; }
  Time accepted_at() const noexcept override { return accepted_at_; }
  const std::shared_ptr<const void>& request() const noexcept override { return request_; }
  GoalStatus status() const override { return core_->status_of(order_); }
  bool execute() override { return core_->execute(order_); }
  bool publish_feedback(std::shared_ptr<void> message) override {
    return core_->publish_feedback(order_, id_, std::move(message));
  }
  bool end(GoalEvent event, std::shared_ptr<void> response) override {
    return core_->end(order_, event, std::move(response));
  }

 private:
  const std::shared_ptr<ActionServerCore> core_;
  const Order order_;
  const GoalId id_;
  const Time accepted_at_;
  const std::shared_ptr<const void> request_;
};

ActionServerCore::ActionServerCore(std::string name, const ActionTypes& types,
                                   UntypedActionHandlers handlers, NodeActionServerOptions options,
                                   Logger logger, std::function<Time()> now)
    : name_(std::move(name)),
      messages_(types),
      handlers_(std::move(handlers)),
      options_(std::move(options)),
      logger_(std::move(logger)),
      now_(std::move(now)) {
  if (!handlers_.accepted) {
    throw std::invalid_argument("action '" + name_ + "': the handler 'accepted' is missing");
  }
  require_at_least(name_, "max_goals", options_.max_goals);
  require_at_least(name_, "max_results", options_.max_results);
  if (options_.result_timeout < Duration::zero()) {
    throw std::invalid_argument("action '" + name_ + "': result_timeout = " +
                                std::to_string(options_.result_timeout.count()) +
                                " ns is negative");
  }
}

void ActionServerCore::attach(ActionServerEndpoints endpoints) {
  const std::lock_guard lock(mutex_);
  endpoints_ = std::move(endpoints);
}

void ActionServerCore::close() {
  ActionServerEndpoints closing;  // destroyed after the lock is released
  std::size_t aborted = 0;
  {
    const std::lock_guard lock(mutex_);
    is_accepting_ = false;
    if (!is_closed_) {
      aborted = abort_all();
    }
    is_closed_ = true;
    std::swap(closing, endpoints_);
  }
  tell_of_aborted(aborted);
}

void ActionServerCore::set_accepting(bool accepting) {
  std::size_t aborted = 0;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) {
      return;
    }
    is_accepting_ = accepting;
    if (!accepting) {
      aborted = abort_all();
    }
  }
  tell_of_aborted(aborted);
}

void ActionServerCore::tell_of_aborted(std::size_t count) const {
  if (count > 0) {
    logger_.warn("action '" + name_ + "': " + std::to_string(count) +
                 " goal(s) aborted, the server is no longer active");
  }
}

bool ActionServerCore::is_accepting() const {
  const std::lock_guard lock(mutex_);
  return is_accepting_;
}

std::optional<std::string> ActionServerCore::why_refused(const GoalId& id) const {
  if (!is_accepting_) {
    return kNotActive;
  }
  if (id.is_zero()) {
    return "its identifier is zero, by which nobody could cancel it";
  }
  if (orders_.contains(id) || deciding_.contains(id)) {
    return "there is a goal of that identifier";
  }
  if (!options_.preempts && active_goals() + deciding_.size() >= options_.max_goals) {
    return std::to_string(options_.max_goals) + " goals have not ended (max_goals)";
  }
  return std::nullopt;
}

void ActionServerCore::goal_requested(const std::shared_ptr<const void>& request,
                                      const SampleIdentity& caller) {
  const GoalId id = messages_.id_of_goal_request(request.get());
  std::optional<std::string> refusal;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) {
      return;
    }
    forget_expired();
    refusal = why_refused(id);
    if (!refusal) {
      deciding_.insert(id);
    }
  }
  if (refusal) {
    tell_of_rejected(id, *refusal);
    const std::lock_guard lock(mutex_);
    if (!is_closed_) {
      reject(caller);
    }
    return;
  }
  std::exception_ptr error;
  GoalDecision decision = handlers_.decide ? GoalDecision::kReject : GoalDecision::kAccept;
  if (handlers_.decide) {
    std::string why = "the server gives no reason";
    contained(error, [&] {
      try {
        decision = handlers_.decide(id, request);
      } catch (const GoalRejected& rejected) {
        why = rejected.what();
      }
    });
    if (decision == GoalDecision::kReject) {
      tell_of_rejected(id, error ? "the server failed to look at it" : why);
    }
  }
  if (decision != GoalDecision::kReject && options_.preempts) {
    contained(error, [this] { preempt_others(); });
  }
  GoalHandle goal;
  {
    const std::lock_guard lock(mutex_);
    deciding_.erase(id);
    if (is_closed_) {
      return;
    }
    goal = accept(id, request, decision, caller);
  }
  if (!goal && decision != GoalDecision::kReject) {
    tell_of_rejected(id, kNotActive);
  }
  if (goal) {
    contained(error, [&] { handlers_.accepted(std::exchange(goal, nullptr)); });
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

void ActionServerCore::tell_of_rejected(const GoalId& id, const std::string& why) const {
  logger_.warn("action '" + name_ + "': goal " + to_string(id) + " rejected: " + why);
}

void ActionServerCore::reject(const SampleIdentity& caller) {
  ++statistics_.rejected;
  endpoints_.send_goal->respond(caller, messages_.goal_response(false, {}));
}

ActionServerCore::GoalHandle ActionServerCore::accept(const GoalId& id,
                                                      const std::shared_ptr<const void>& request,
                                                      GoalDecision decision,
                                                      const SampleIdentity& caller) {
  if (decision == GoalDecision::kReject || !is_accepting_) {
    reject(caller);
    return nullptr;
  }
  if (options_.preempts) {
    abort_all();  // what the handler left, or what came meanwhile in another thread
  }
  const Time now = now_();
  const Order order = ++last_order_;
  auto goal = std::make_shared<Goal>(shared_from_this(), order, id, now, request);
  Record& record = goals_[order];
  record.id = id;
  record.stamp = to_message(now);
  record.status = decision == GoalDecision::kDefer ? GoalStatus::kAccepted : GoalStatus::kExecuting;
  record.handle = goal;
  orders_[id] = order;
  ++statistics_.accepted;
  endpoints_.send_goal->respond(caller, messages_.goal_response(true, record.stamp));
  publish_status();
  return goal;
}

void ActionServerCore::preempt_others() {
  if (!handlers_.preempted) {
    return;
  }
  std::vector<GoalHandle> others;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [order, record] : goals_) {
      if (auto handle = is_active(record.status) ? record.handle.lock() : nullptr) {
        others.push_back(std::move(handle));
      }
    }
  }
  for (const GoalHandle& other : others) {
    handlers_.preempted(other);
  }
}

ActionServerCore::CancelChoice ActionServerCore::choose(const CancelGoal::Request& request) const {
  const GoalId id = from_message(request.goal_info.goal_id);
  const Time not_after = from_message(request.goal_info.stamp);
  const bool has_time = not_after != Time{};
  CancelChoice choice;
  choice.is_of_one = !id.is_zero() && !has_time;
  const bool is_of_all = id.is_zero() && !has_time;
  if (choice.is_of_one) {
    const auto found = orders_.find(id);
    if (found == orders_.end()) {
      choice.response.return_code = CancelGoal::Response::ERROR_UNKNOWN_GOAL_ID;
      return choice;
    }
    if (!is_active(goals_.at(found->second).status)) {
      choice.response.return_code = CancelGoal::Response::ERROR_GOAL_TERMINATED;
      return choice;
    }
  }
  for (const auto& [order, record] : goals_) {
    const bool is_meant =
        is_of_all || record.id == id || (has_time && from_message(record.stamp) <= not_after);
    if (!is_meant || !is_active(record.status)) {
      continue;
    }
    if (record.status == GoalStatus::kCanceling) {
      // Asked twice it is canceling still; the code for "has ended", which rcl_action gives here,
      // would mislead.
      choice.response.goals_canceling.push_back(info_of(record));
    } else if (auto handle = record.handle.lock()) {
      choice.candidates.emplace_back(order, std::move(handle));
    }
  }
  return choice;
}

void ActionServerCore::cancel_requested(const CancelGoal::Request& request,
                                        const SampleIdentity& caller) {
  CancelChoice choice;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) {
      return;
    }
    forget_expired();
    choice = choose(request);
  }
  std::exception_ptr error;
  std::size_t rejected = 0;
  if (handlers_.cancel) {
    rejected = std::erase_if(choice.candidates, [&](const auto& candidate) {
      CancelDecision decision = CancelDecision::kReject;
      contained(error, [&] { decision = handlers_.cancel(candidate.second); });
      return decision == CancelDecision::kReject;
    });
  }
  std::vector<GoalHandle> canceling;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) {
      return;
    }
    auto& response = choice.response;
    for (auto& [order, handle] : choice.candidates) {
      const auto found = goals_.find(order);
      if (found == goals_.end()) {
        continue;
      }
      // While the handler was asked, the goal may have ended.
      if (const auto next = next_status(found->second.status, GoalEvent::kRequestCancel)) {
        found->second.status = *next;
        canceling.push_back(std::move(handle));
      } else if (found->second.status != GoalStatus::kCanceling) {
        continue;
      }
      response.goals_canceling.push_back(info_of(found->second));
    }
    if (response.goals_canceling.empty() &&
        response.return_code == CancelGoal::Response::ERROR_NONE) {
      if (rejected > 0) {
        response.return_code = CancelGoal::Response::ERROR_REJECTED;
      } else if (choice.is_of_one) {
        response.return_code = CancelGoal::Response::ERROR_GOAL_TERMINATED;
      }
    }
    if (!canceling.empty()) {
      publish_status();
    }
    endpoints_.cancel_goal->respond(
        caller, std::make_shared<const CancelGoal::Response>(std::move(response)));
  }
  if (handlers_.canceling) {
    for (const GoalHandle& goal : canceling) {
      contained(error, [&] { handlers_.canceling(goal); });
    }
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

void ActionServerCore::result_requested(const void* request, const SampleIdentity& caller) {
  const GoalId id = messages_.id_of_result_request(request);
  const std::lock_guard lock(mutex_);
  if (is_closed_) {
    return;
  }
  forget_expired();
  const auto found = orders_.find(id);
  if (found == orders_.end()) {
    endpoints_.get_result->respond(caller, messages_.result_response(GoalStatus::kUnknown));
    return;
  }
  Record& record = goals_.at(found->second);
  if (record.result) {
    record.is_fetched = true;
    endpoints_.get_result->respond(caller, record.result);
    return;
  }
  if (record.waiting.size() >= kMaxWaiting) {
    record.waiting.erase(record.waiting.begin());
  }
  record.waiting.push_back(caller);
}

GoalStatus ActionServerCore::status_of(Order order) const {
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(order);
  return found == goals_.end() ? GoalStatus::kUnknown : found->second.status;
}

bool ActionServerCore::execute(Order order) {
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(order);
  const auto next =
      found == goals_.end() ? std::nullopt : next_status(found->second.status, GoalEvent::kExecute);
  if (!next) {
    return false;
  }
  found->second.status = *next;
  publish_status();
  return true;
}

bool ActionServerCore::publish_feedback(Order order, const GoalId& id,
                                        std::shared_ptr<void> message) {
  if (!message) {
    throw std::invalid_argument("action '" + name_ + "': the feedback is null");
  }
  std::shared_ptr<UntypedPublisher> publisher;
  {
    const std::lock_guard lock(mutex_);
    const auto found = goals_.find(order);
    if (found == goals_.end() || !is_active(found->second.status)) {
      return false;
    }
    publisher = endpoints_.feedback;
  }
  messages_.set_id_of_feedback(message.get(), id);
  // Without the lock: feedback may be large, and other goals need not wait for it.
  publisher->publish(std::move(message), {});
  return true;
}

bool ActionServerCore::end(Order order, GoalEvent event, std::shared_ptr<void> response) {
  if (!response) {
    throw std::invalid_argument("action '" + name_ + "': the result is null");
  }
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(order);
  if (found == goals_.end() || !is_active(found->second.status)) {
    return false;
  }
  Record& record = found->second;
  const auto next = next_status(record.status, event);
  if (!next || is_active(*next)) {
    throw std::logic_error("action '" + name_ + "': a goal that is " +
                           std::string(to_string(record.status)) + " cannot be " + text_of(event));
  }
  end_goal(order, record, *next, std::move(response));
  goals_ended();
  return true;
}

void ActionServerCore::handle_gone(Order order, const GoalId& id) noexcept {
  try {
    {
      const std::lock_guard lock(mutex_);
      const auto found = goals_.find(order);
      if (found == goals_.end() || !is_active(found->second.status)) {
        return;
      }
      ++statistics_.dropped;
      end_goal(order, found->second, GoalStatus::kAborted,
               messages_.result_response(GoalStatus::kAborted));
      goals_ended();
    }
    logger_.warn("action '" + name_ + "': goal " + to_string(id) +
                 " aborted, its last handle went before it ended");
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): there is nobody to tell
  }
}

std::size_t ActionServerCore::abort_all() {
  std::size_t aborted = 0;
  for (auto& [order, record] : goals_) {
    if (is_active(record.status)) {
      end_goal(order, record, GoalStatus::kAborted,
               messages_.result_response(GoalStatus::kAborted));
      ++aborted;
    }
  }
  if (aborted > 0) {
    goals_ended();
  }
  return aborted;
}

void ActionServerCore::end_goal(Order order, Record& record, GoalStatus status,
                                std::shared_ptr<void> response) {
  messages_.set_status(response.get(), status);
  record.status = status;
  record.result = std::move(response);
  record.ended = now_();
  record.is_fetched = !record.waiting.empty();
  for (const SampleIdentity& caller : std::exchange(record.waiting, {})) {
    endpoints_.get_result->respond(caller, record.result);
  }
  ended_.push_back(order);
  ++(status == GoalStatus::kSucceeded  ? statistics_.succeeded
     : status == GoalStatus::kCanceled ? statistics_.canceled
                                       : statistics_.aborted);
}

void ActionServerCore::goals_ended() {
  publish_status();
  while (ended_.size() > options_.max_results) {
    const auto fetched = std::find_if(ended_.begin(), ended_.end(),
                                      [this](Order order) { return goals_.at(order).is_fetched; });
    const auto oldest = fetched != ended_.end() ? fetched : ended_.begin();
    if (fetched == ended_.end()) {
      ++statistics_.results_lost;
    }
    const Order order = *oldest;
    ended_.erase(oldest);
    forget(order);
  }
}

void ActionServerCore::forget_expired() {
  // Results go when somebody may ask for them: no timer is needed, and `max_results` bounds what is
  // kept. They are in the order of their ends, but for a clock that was set back.
  const Time now = now_();
  while (!ended_.empty() &&
         add_saturated(goals_.at(ended_.front()).ended, options_.result_timeout) < now) {
    forget(ended_.front());
    ended_.pop_front();
  }
}

void ActionServerCore::forget(Order order) {
  const auto found = goals_.find(order);
  orders_.erase(found->second.id);
  goals_.erase(found);
}

void ActionServerCore::publish_status() {
  auto message = std::make_shared<action_msgs::msg::GoalStatusArray>();
  message->status_list.reserve(goals_.size());
  for (const auto& [order, record] : goals_) {
    auto& entry = message->status_list.emplace_back();
    entry.goal_info = info_of(record);
    entry.status = static_cast<std::int8_t>(record.status);
  }
  endpoints_.status->publish(std::move(message), {});
}

action_msgs::msg::GoalInfo ActionServerCore::info_of(const Record& record) {
  action_msgs::msg::GoalInfo info;
  info.goal_id = to_message(record.id);
  info.stamp = record.stamp;
  return info;
}

ActionServerStatistics ActionServerCore::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

}  // namespace pipescout
