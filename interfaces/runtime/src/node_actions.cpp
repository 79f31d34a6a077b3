// SPDX-License-Identifier: Apache-2.0
#include <action_msgs/msg/goal_status_array.hpp>
#include <utility>

#include "action_client_core.hpp"
#include "action_server_core.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout {

namespace {

using action_msgs::msg::GoalStatusArray;
using CancelGoal = action_msgs::srv::CancelGoal;

/// Of all three services, on both sides: with the depth of other services, 10, a burst of goals
/// that end would push out answers before their reader has them. Depths are no matter of matching.
constexpr QoS kServices{.depth = UntypedClient::kMaxOutstandingCalls};
/// As rcl_action has it.
constexpr QoS kStatus = QoS::latched(1);

}  // namespace

std::shared_ptr<UntypedActionServer> Node::create_untyped_action_server(
    std::string_view name, const ActionTypes& types, UntypedActionHandlers handlers,
    const NodeActionServerOptions& options) {
  const std::string full = action_name(name);
  const auto core = std::make_shared<ActionServerCore>(full, types, std::move(handlers), options,
                                                       logger(), [this] { return now(); });
  const std::weak_ptr<ActionServerCore> weak(core);
  // The server itself knows when it is active: results and requests to cancel have their way also
  // when it is not.
  const NodeServiceOptions service{.qos = kServices, .group = options.group, .managed = false};
  const NodePublisherOptions publisher{.group = options.group, .managed = false};
  ActionServerEndpoints endpoints;
  endpoints.feedback =
      create_untyped_publisher(action_part_name(full, "feedback"), *types.feedback_message,
                               QoS::reliable(options.feedback_depth), publisher);
  endpoints.status = create_untyped_publisher(action_part_name(full, "status"),
                                              message_type<GoalStatusArray>(), kStatus, publisher);
  endpoints.get_result = create_untyped_service_on(
      action_part_name(full, "get_result"), *types.get_result_request, *types.get_result_response,
      [weak](const std::shared_ptr<const void>& request, const SampleIdentity& caller) {
        if (const auto alive = weak.lock()) {
          alive->result_requested(request.get(), caller);
        }
      },
      service);
  endpoints.cancel_goal = create_untyped_service_on(
      action_part_name(full, "cancel_goal"), message_type<CancelGoal::Request>(),
      message_type<CancelGoal::Response>(),
      [weak](const std::shared_ptr<const void>& request, const SampleIdentity& caller) {
        if (const auto alive = weak.lock()) {
          alive->cancel_requested(*static_cast<const CancelGoal::Request*>(request.get()), caller);
        }
      },
      service);
  endpoints.send_goal = create_untyped_service_on(
      action_part_name(full, "send_goal"), *types.send_goal_request, *types.send_goal_response,
      [weak](const std::shared_ptr<const void>& request, const SampleIdentity& caller) {
        if (const auto alive = weak.lock()) {
          alive->goal_requested(request, caller);
        }
      },
      service);
  core->attach(endpoints);
  auto server = std::make_shared<ProcessActionServer>(core);
  add_action_server(server, options.managed);
  for (const auto& ready : {endpoints.get_result, endpoints.cancel_goal, endpoints.send_goal}) {
    enable_service(ready, service);
  }
  return server;
}

std::shared_ptr<UntypedActionClient> Node::create_untyped_action_client(
    std::string_view name, const ActionTypes& types, const NodeActionClientOptions& options) {
  const std::string full = action_name(name);
  const auto core = std::make_shared<ActionClientCore>(full, types, options, logger(), context());
  const std::weak_ptr<ActionClientCore> weak(core);
  const NodeClientOptions client{.qos = kServices, .group = options.group};
  // Told of a match, who waits in an executor until the client is ready looks again.
  const NodeSubscriptionOptions looked_at{
      .events = {.matched = [](std::size_t) {}}, .group = options.group, .managed = false};
  ActionClientEndpoints endpoints;
  endpoints.feedback = create_untyped_subscription(
      action_part_name(full, "feedback"), *types.feedback_message,
      QoS::reliable(options.feedback_depth),
      [weak](const std::shared_ptr<const void>& message, const MessageInfo&) {
        if (const auto alive = weak.lock()) {
          alive->feedback_came(message);
        }
      },
      looked_at);
  endpoints.status = create_untyped_subscription(
      action_part_name(full, "status"), message_type<GoalStatusArray>(), kStatus,
      [weak](const std::shared_ptr<const void>& message, const MessageInfo&) {
        if (const auto alive = weak.lock()) {
          alive->status_came(*static_cast<const GoalStatusArray*>(message.get()));
        }
      },
      looked_at);
  endpoints.get_result =
      create_untyped_client_on(action_part_name(full, "get_result"), *types.get_result_request,
                               *types.get_result_response, client);
  endpoints.cancel_goal = create_untyped_client_on(action_part_name(full, "cancel_goal"),
                                                   message_type<CancelGoal::Request>(),
                                                   message_type<CancelGoal::Response>(), client);
  NodeClientOptions watching = client;
  watching.matched = [weak] {
    if (const auto alive = weak.lock()) {
      alive->servers_changed();
    }
  };
  endpoints.send_goal =
      create_untyped_client_on(action_part_name(full, "send_goal"), *types.send_goal_request,
                               *types.send_goal_response, watching);
  core->attach(std::move(endpoints));
  return std::make_shared<ProcessActionClient>(core);
}

}  // namespace pipescout
