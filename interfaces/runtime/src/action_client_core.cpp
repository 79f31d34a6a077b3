// SPDX-License-Identifier: Apache-2.0
#include "action_client_core.hpp"

#include <exception>
#include <stdexcept>
#include <utility>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout {

namespace {

/// The end that a server tells; anything else is no end.
GoalEnd end_of(GoalStatus status) {
  switch (status) {
    case GoalStatus::kSucceeded:
      return GoalEnd::kSucceeded;
    case GoalStatus::kCanceled:
      return GoalEnd::kCanceled;
    case GoalStatus::kAborted:
      return GoalEnd::kAborted;
    default:
      return GoalEnd::kUnknown;
  }
}

}  // namespace

const char* to_string(GoalEnd end) noexcept {
  switch (end) {
    case GoalEnd::kSucceeded:
      return "succeeded";
    case GoalEnd::kCanceled:
      return "canceled";
    case GoalEnd::kAborted:
      return "aborted";
    case GoalEnd::kUnknown:
      return "unknown to the server";
    case GoalEnd::kLost:
      return "lost with its server";
    case GoalEnd::kClientGone:
      return "left by its client";
  }
  return "unknown";
}

std::string_view to_string(CancelCode code) noexcept {
  switch (code) {
    case CancelCode::kNone:
      return "canceling";
    case CancelCode::kRejected:
      return "rejected";
    case CancelCode::kUnknownGoal:
      return "unknown goal";
    case CancelCode::kTerminated:
      return "the goal has ended already";
  }
  return "unknown code";
}

ActionClientCore::ActionClientCore(std::string name, const ActionTypes& types,
                                   NodeActionClientOptions options, Logger logger, Context& context)
    : name_(std::move(name)),
      messages_(types),
      options_(std::move(options)),
      logger_(std::move(logger)),
      context_(context.weak_from_this()) {}

void ActionClientCore::attach(ActionClientEndpoints endpoints) {
  const std::lock_guard lock(mutex_);
  endpoints_ = std::move(endpoints);
}

void ActionClientCore::close() {
  ActionClientEndpoints closing;
  Goals goals;
  {
    const std::lock_guard lock(mutex_);
    std::swap(closing, endpoints_);
    goals.swap(goals_);
  }
  // Their calls are answered now; those of goals find none in the table.
  closing = {};
  for (const auto& [id, goal] : goals) {
    try {
      if (goal.server != Gid{}) {
        tell_result(id, goal, GoalEnd::kClientGone, nullptr);
      } else if (goal.callbacks->response) {
        goal.callbacks->response({.id = id, .accepted = false, .error = ServiceError::kCancelled});
      }
    } catch (...) {  // NOLINT(bugprone-empty-catch): called from a destructor, as documented
    }
  }
}

GoalId ActionClientCore::send_goal(std::shared_ptr<void> request, UntypedGoalCallbacks callbacks,
                                   Duration timeout) {
  if (!request) {
    throw std::invalid_argument("action '" + name_ + "': the goal is null");
  }
  const GoalId id = GoalId::random();
  messages_.set_id_of_goal_request(request.get(), id);
  std::shared_ptr<UntypedClient> client;
  {
    const std::lock_guard lock(mutex_);
    if (goals_.size() >= UntypedActionClient::kMaxGoals) {
      throw std::runtime_error("action '" + name_ + "': " + std::to_string(goals_.size()) +
                               " goals have no end yet");
    }
    goals_[id].callbacks = std::make_shared<const UntypedGoalCallbacks>(std::move(callbacks));
    ++statistics_.sent;
    client = endpoints_.send_goal;
  }
  try {
    client->call(
        std::move(request),
        [weak = weak_from_this(), id](const ServiceResult<void>& result) {
          if (const auto alive = weak.lock()) {
            alive->answered(id, result);
          }
        },
        timeout);
  } catch (...) {
    take(id);
    throw;
  }
  return id;
}

void ActionClientCore::answered(const GoalId& id, const ServiceResult<void>& result) {
  GoalResponse response{.id = id};
  if (!result) {
    response.error = result.error();
    if (result.error() == ServiceError::kNoServer) {
      warn_without_server();
    }
  } else {
    response.accepted = messages_.is_accepted(result.shared().get());
    response.stamp = from_message(messages_.stamp_of(result.shared().get()));
  }
  if (response.accepted) {
    accepted(id, response, result.server());
    return;
  }
  const Goal goal = take(id);
  if (goal.callbacks && goal.callbacks->response) {
    goal.callbacks->response(response);
  }
}

void ActionClientCore::accepted(const GoalId& id, const GoalResponse& response, const Gid& server) {
  std::shared_ptr<const UntypedGoalCallbacks> callbacks;
  {
    const std::lock_guard lock(mutex_);
    const auto found = goals_.find(id);
    if (found == goals_.end()) {
      return;
    }
    found->second.server = server;
    if (found->second.status == GoalStatus::kUnknown) {
      found->second.status = GoalStatus::kAccepted;
    }
    callbacks = found->second.callbacks;
  }
  std::exception_ptr error;
  try {
    if (callbacks->response) {
      callbacks->response(response);
    }
    tell_held_feedback(id);
  } catch (...) {
    error = std::current_exception();
  }
  // Only now, so that the result is told last; the server keeps it.
  ask_for_result(id);
  if (error) {
    std::rethrow_exception(error);
  }
}

void ActionClientCore::tell_held_feedback(const GoalId& id) {
  while (true) {
    std::shared_ptr<const void> message;
    std::shared_ptr<const UntypedGoalCallbacks> callbacks;
    {
      const std::lock_guard lock(mutex_);
      const auto found = goals_.find(id);
      if (found == goals_.end()) {
        return;
      }
      Goal& goal = found->second;
      if (goal.feedback.empty()) {
        goal.is_told = true;
        return;
      }
      message = std::move(goal.feedback.front());
      goal.feedback.pop_front();
      callbacks = goal.callbacks;
    }
    callbacks->feedback(message);
  }
}

void ActionClientCore::ask_for_result(const GoalId& id) {
  Goals lost;
  {
    const std::lock_guard lock(mutex_);
    const auto found = goals_.find(id);
    if (found == goals_.end()) {
      return;
    }
    Goal& goal = found->second;
    goal.is_told = true;
    goal.feedback.clear();  // left over when a callback threw
    goal.result_call = endpoints_.get_result->call(
        messages_.result_request(id),
        [weak = weak_from_this(), id](const ServiceResult<void>& result) {
          if (const auto alive = weak.lock()) {
            alive->result_came(id, result);
          }
        },
        Duration::max());
    // The server may have gone before anybody looked for its goals.
    take_if_lost(found, lost);
  }
  tell_lost(lost);
}

void ActionClientCore::result_came(const GoalId& id, const ServiceResult<void>& result) {
  const Goal goal = take(id);
  if (!goal.callbacks) {
    return;
  }
  if (!result && result.error() == ServiceError::kServerGone) {
    tell_lost({{id, goal}});
    return;
  }
  const GoalEnd end =
      result ? end_of(messages_.status_of(result.shared().get())) : GoalEnd::kUnknown;
  if (end == GoalEnd::kUnknown) {
    // The result has expired, or was lost with the server; how the goal ended may be known still.
    tell_result(id, goal, end_of(goal.status), nullptr);
  } else {
    tell_result(id, goal, end, result.shared());
  }
}

void ActionClientCore::tell_result(const GoalId& id, const Goal& goal, GoalEnd end,
                                   const std::shared_ptr<const void>& response) {
  {
    const std::lock_guard lock(mutex_);
    ++statistics_.ended;
    statistics_.lost += end == GoalEnd::kLost || end == GoalEnd::kUnknown ? 1 : 0;
  }
  if (goal.callbacks->result) {
    goal.callbacks->result(id, end, response);
  }
}

void ActionClientCore::servers_changed() {
  Goals lost;
  {
    const std::lock_guard lock(mutex_);
    for (auto goal = goals_.begin(); goal != goals_.end();) {
      take_if_lost(goal++, lost);
    }
  }
  tell_lost(lost);
}

void ActionClientCore::take_if_lost(Goals::iterator goal, Goals& lost) {
  if (goal->second.result_call != 0 && !endpoints_.send_goal->is_matched(goal->second.server)) {
    endpoints_.get_result->forget(goal->second.result_call);
    lost.insert(goals_.extract(goal));
  }
}

void ActionClientCore::tell_lost(const Goals& lost) {
  std::exception_ptr error;
  for (const auto& [id, goal] : lost) {
    const GoalEnd known = end_of(goal.status);
    const GoalEnd end = known == GoalEnd::kUnknown ? GoalEnd::kLost : known;
    logger_.warn("action '" + name_ + "': the server is gone, goal " + to_string(id) + " " +
                 to_string(end));
    try {
      tell_result(id, goal, end, nullptr);
    } catch (...) {
      error = std::current_exception();
    }
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

void ActionClientCore::feedback_came(const std::shared_ptr<const void>& message) {
  const GoalId id = messages_.id_of_feedback(message.get());
  std::shared_ptr<const UntypedGoalCallbacks> callbacks;
  {
    const std::lock_guard lock(mutex_);
    const auto found = goals_.find(id);
    // Every client of the action gets the feedback of every goal.
    if (found == goals_.end() || !found->second.callbacks->feedback) {
      return;
    }
    Goal& goal = found->second;
    if (!goal.is_told) {
      if (goal.feedback.size() >= options_.feedback_depth) {
        goal.feedback.pop_front();
        ++statistics_.feedback_dropped;
      }
      goal.feedback.push_back(message);
      return;
    }
    callbacks = goal.callbacks;
  }
  callbacks->feedback(message);
}

void ActionClientCore::status_came(const action_msgs::msg::GoalStatusArray& message) {
  const std::lock_guard lock(mutex_);
  if (goals_.empty()) {
    return;
  }
  for (const auto& entry : message.status_list) {
    const auto found = goals_.find(from_message(entry.goal_info.goal_id));
    if (found != goals_.end()) {
      found->second.status = static_cast<GoalStatus>(entry.status);
    }
  }
}

void ActionClientCore::cancel(const CancelRequest& request,
                              std::function<void(const CancelResponse&)> answer, Duration timeout) {
  auto message = std::make_shared<CancelGoal::Request>();
  message->goal_info.goal_id = to_message(request.id);
  message->goal_info.stamp = to_message(request.not_after);
  std::shared_ptr<UntypedClient> client;
  {
    const std::lock_guard lock(mutex_);
    client = endpoints_.cancel_goal;
  }
  client->call(
      std::move(message),
      [answer = std::move(answer)](const ServiceResult<void>& result) {
        if (!answer) {
          return;
        }
        CancelResponse response;
        if (result) {
          const auto& told = *static_cast<const CancelGoal::Response*>(result.shared().get());
          response.code = static_cast<CancelCode>(told.return_code);
          for (const auto& info : told.goals_canceling) {
            response.canceling.push_back(from_message(info.goal_id));
          }
        } else {
          response.error = result.error();
        }
        answer(response);
      },
      timeout);
}

ActionClientCore::Goal ActionClientCore::take(const GoalId& id) {
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(id);
  if (found == goals_.end()) {
    return {};
  }
  Goal goal = std::move(found->second);
  goals_.erase(found);
  return goal;
}

void ActionClientCore::warn_without_server() const {
  const auto context = context_.lock();
  if (!context) {
    return;
  }
  const auto topics = context->graph().topics();
  const auto found = topics.find(action_part_name(name_, "feedback"));
  if (found == topics.end()) {
    return;
  }
  for (const std::string& type : found->second) {
    if (type != messages_.types().feedback_message->name) {
      logger_.warn("action '" + name_ + "': no server of type " +
                   std::string(messages_.types().name) + ", but somebody uses the name with " +
                   type);
    }
  }
}

GoalStatus ActionClientCore::status(const GoalId& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(id);
  return found == goals_.end() ? GoalStatus::kUnknown : found->second.status;
}

bool ActionClientCore::is_ready() const {
  const std::lock_guard lock(mutex_);
  return endpoints_.send_goal && endpoints_.send_goal->is_ready() &&
         endpoints_.cancel_goal->is_ready() && endpoints_.get_result->is_ready() &&
         endpoints_.feedback->publisher_count() > 0 && endpoints_.status->publisher_count() > 0;
}

ActionClientStatistics ActionClientCore::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

}  // namespace pipescout
