// SPDX-License-Identifier: Apache-2.0
#include "fibonacci_server.hpp"

#include <string>
#include <utility>

#include "pipescout/runtime/goal_rejected.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace tutorial {

using pipescout::CallbackReturn;
using pipescout::GoalDecision;

namespace {

// The 47th does not fit into 32 bits.
constexpr std::int32_t kMaxOrder = 45;

}  // namespace

FibonacciServer::FibonacciServer(pipescout::ComponentOptions options)
    : Component(std::move(options)) {
  period_ = parameters().declare<double>(
      "period", 0.5,
      {.description = "time that a number takes, s",
       .floating_point_range = pipescout::FloatingPointRange{0.01, 10}});
}

CallbackReturn FibonacciServer::on_configure() {
  server_ = create_action_server<Fibonacci>(
      "fibonacci",
      {.decide =
           [](const pipescout::GoalId&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
             if (goal->order < 1 || goal->order > kMaxOrder) {
               throw pipescout::GoalRejected("order is not in 1 to " + std::to_string(kMaxOrder));
             }
             return GoalDecision::kAccept;
           },
       .accepted = [this](Goal goal) { begin(std::move(goal)); },
       .canceling = [this](const Goal& goal) { goal.canceled(result()); },
       .preempted = [this](const Goal& goal) { goal.abort(result()); }},
      {.preempts = true});
  timer_ = create_timer(pipescout::from_seconds(period_.get()), [this] { compute_next(); });
  return CallbackReturn::kSuccess;
}

CallbackReturn FibonacciServer::on_deactivate() {
  goal_ = {};  // the server has aborted it
  return CallbackReturn::kSuccess;
}

CallbackReturn FibonacciServer::on_cleanup() {
  goal_ = {};
  timer_.reset();
  server_ = {};
  return CallbackReturn::kSuccess;
}

void FibonacciServer::begin(Goal goal) {
  goal_ = std::move(goal);
  sequence_ = {0, 1};
  timer_->reset();
}

void FibonacciServer::compute_next() {
  if (!goal_ || !goal_.is_active()) {
    return;
  }
  sequence_.push_back(*(sequence_.end() - 1) + *(sequence_.end() - 2));
  if (sequence_.size() == static_cast<std::size_t>(goal_.goal().order) + 2) {
    goal_.succeed(result());
    return;
  }
  Fibonacci::Feedback feedback;
  feedback.sequence = sequence_;
  goal_.publish_feedback(std::move(feedback));
}

FibonacciServer::Fibonacci::Result FibonacciServer::result() const {
  Fibonacci::Result result;
  result.sequence = sequence_;
  return result;
}

}  // namespace tutorial

PIPESCOUT_REGISTER_COMPONENT(tutorial::FibonacciServer)
