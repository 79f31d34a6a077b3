// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <action_msgs/msg/goal_status_array.hpp>
#include <action_msgs/srv/cancel_goal.hpp>
#include <cstdint>
#include <example_interfaces/action/fibonacci.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/goal_rejected.hpp"
#include "pipescout/runtime/node.hpp"

/// What the tests of actions serve and ask for.
namespace pipescout {

using example_interfaces::action::Fibonacci;
using CancelGoal = action_msgs::srv::CancelGoal;

/// A process with one node.
struct ActionProcess {
  explicit ActionProcess(const std::string& name, std::unique_ptr<Transport> transport = nullptr)
      : ActionProcess(name, Context::create(std::move(transport))) {}
  ActionProcess(const std::string& name, std::shared_ptr<Context> shared)
      : context(std::move(shared)),
        node({.context = context,
              .executor = &executor,
              .name = {"/robot", name},
              .standard_interfaces = false}) {}

  Executor executor;
  std::shared_ptr<Context> context;
  Node node;
};

inline Fibonacci::Goal order(std::int32_t numbers) {
  Fibonacci::Goal goal;
  goal.order = numbers;
  return goal;
}
inline Fibonacci::Result numbers(std::vector<std::int32_t> sequence) {
  Fibonacci::Result result;
  result.sequence = std::move(sequence);
  return result;
}
inline Fibonacci::Feedback so_far(std::vector<std::int32_t> sequence) {
  Fibonacci::Feedback feedback;
  feedback.sequence = std::move(sequence);
  return feedback;
}

/// A server that keeps the goals it accepts, and notes what it is asked, as "accepted 3": the
/// handler and the goal's order.
struct FibonacciServer {
  explicit FibonacciServer(Node& node, const NodeActionServerOptions& options = {},
                           const std::string& name = "fibonacci")
      : server(node.create_action_server<Fibonacci>(
            name,
            {.decide =
                 [this](const GoalId&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
                   note("decide", goal->order);
                   if (rejection) {
                     throw GoalRejected(*rejection);
                   }
                   return decision;
                 },
             .accepted =
                 [this](ServerGoal<Fibonacci> goal) {
                   note("accepted", goal.goal().order);
                   goals.push_back(std::move(goal));
                 },
             .cancel =
                 [this](const ServerGoal<Fibonacci>& goal) {
                   note("cancel", goal.goal().order);
                   return cancel_decision;
                 },
             .canceling =
                 [this](const ServerGoal<Fibonacci>& goal) {
                   note("canceling", goal.goal().order);
                 },
             .preempted =
                 [this](const ServerGoal<Fibonacci>& goal) {
                   note("preempted", goal.goal().order);
                 }},
            options)) {}

  void note(const std::string& what, std::int32_t numbers) {
    events.push_back(what + " " + std::to_string(numbers));
  }

  GoalDecision decision = GoalDecision::kAccept;
  std::optional<std::string> rejection;  // the reason of it
  CancelDecision cancel_decision = CancelDecision::kAccept;
  std::vector<std::string> events;
  std::vector<ServerGoal<Fibonacci>> goals;
  ActionServer<Fibonacci> server;
};

/// A client that notes what it is told: "accepted", "feedback 1", "succeeded [0 1]".
struct FibonacciClient {
  explicit FibonacciClient(Node& node, const NodeActionClientOptions& options = {},
                           const std::string& name = "fibonacci")
      : client(node.create_action_client<Fibonacci>(name, options)) {}

  GoalId send(std::int32_t numbers, Duration timeout = std::chrono::seconds(30)) {
    return client.send_goal(order(numbers), callbacks(), timeout);
  }
  GoalCallbacks<Fibonacci> callbacks() {
    return {.response =
                [this](const GoalResponse& response) {
                  told.emplace_back(response.error      ? to_string(*response.error)
                                    : response.accepted ? "accepted"
                                                        : "rejected");
                },
            .feedback =
                [this](const std::shared_ptr<const Fibonacci::Feedback>& feedback) {
                  told.push_back("feedback " + text(feedback->sequence));
                },
            .result =
                [this](const GoalOutcome<Fibonacci>& outcome) {
                  told.push_back(to_string(outcome.end) +
                                 (outcome.result ? " " + text(outcome.result->sequence) : ""));
                }};
  }
  std::function<void(const CancelResponse&)> note_cancel() {
    return [this](const CancelResponse& response) {
      told.push_back("cancel: " + (response.error ? std::string(to_string(*response.error))
                                                  : std::string(to_string(response.code)) + " " +
                                                        std::to_string(response.canceling.size())));
    };
  }
  static std::string text(const std::vector<std::int32_t>& sequence) {
    std::string result = "[";
    for (const std::int32_t number : sequence) {
      result += (result.size() > 1 ? " " : "") + std::to_string(number);
    }
    return result + "]";
  }

  std::vector<std::string> told;
  ActionClient<Fibonacci> client;
};

}  // namespace pipescout
