// SPDX-License-Identifier: Apache-2.0
#include "lifecycle_services.hpp"

#include <deque>
#include <string>
#include <utility>

namespace pipescout {

namespace {

namespace srv = lifecycle_msgs::srv;

lifecycle_msgs::msg::State state_message(LifecycleState state) {
  lifecycle_msgs::msg::State message;
  message.id = static_cast<std::uint8_t>(state);
  message.label = std::string(to_string(state));
  return message;
}

lifecycle_msgs::msg::Transition transition_message(const LifecycleEdge& edge) {
  lifecycle_msgs::msg::Transition message;
  message.id = edge.id;
  message.label = std::string(edge.label);
  return message;
}

lifecycle_msgs::msg::TransitionDescription description(const LifecycleEdge& edge) {
  lifecycle_msgs::msg::TransitionDescription message;
  message.transition = transition_message(edge);
  message.start_state = state_message(edge.start);
  message.goal_state = state_message(edge.goal);
  return message;
}

}  // namespace

/// Requests of `change_state`, carried out one after the other: what a request means depends on the
/// state that the one before leaves. Used in the component's default group only.
class LifecycleServices::Requests : public std::enable_shared_from_this<Requests> {
 public:
  explicit Requests(Component& component) : component_(component) {}

  void add(lifecycle_msgs::msg::Transition wanted, Responder<srv::ChangeState> responder) {
    waiting_.push_back({std::move(wanted), std::move(responder)});
    proceed();
  }

 private:
  struct Request {
    lifecycle_msgs::msg::Transition wanted;
    Responder<srv::ChangeState> responder;
  };

  void proceed() {
    while (!busy_ && !waiting_.empty()) {
      const Request request = std::move(waiting_.front());
      waiting_.pop_front();
      const auto transition =
          requested_transition(component_.state(), request.wanted.id, request.wanted.label);
      if (!transition) {
        refuse(request);
        continue;
      }
      busy_ = true;
      component_.request_transition(
          *transition,
          [self = weak_from_this(), responder = request.responder](const TransitionResult& result) {
            answer(responder, result.success);
            if (const auto requests = self.lock()) {
              requests->busy_ = false;
              requests->proceed();
            }
          });
    }
  }

  void refuse(const Request& request) const {
    const std::string wanted = request.wanted.label.empty() ? std::to_string(request.wanted.id)
                                                            : "'" + request.wanted.label + "'";
    component_.logger().error("change_state: transition " + wanted + " is not possible in state '" +
                              std::string(to_string(component_.state())) + "'");
    answer(request.responder, false);
  }

  static void answer(const Responder<srv::ChangeState>& responder, bool success) {
    srv::ChangeState::Response response;
    response.success = success;
    responder.respond(std::move(response));
  }

  Component& component_;
  std::deque<Request> waiting_;
  bool busy_ = false;
};

LifecycleServices::LifecycleServices(Component& component)
    : component_(component), requests_(std::make_shared<Requests>(component)) {
  const NodeServiceOptions unmanaged{.managed = false};

  // Reliable and volatile, as rclcpp_lifecycle publishes it.
  events_ = component.create_publisher<lifecycle_msgs::msg::TransitionEvent>(
      "~/transition_event", QoS::reliable(), {.managed = false});

  change_state_ = component.create_service<srv::ChangeState>(
      "~/change_state",
      [requests = requests_](const std::shared_ptr<const srv::ChangeState::Request>& request,
                             Responder<srv::ChangeState> responder) {
        requests->add(request->transition, std::move(responder));
      },
      unmanaged);
  get_state_ = component.create_service<srv::GetState>(
      "~/get_state",
      [&component](const srv::GetState::Request&, srv::GetState::Response& response) {
        response.current_state = state_message(component.state());
      },
      unmanaged);
  get_available_states_ = component.create_service<srv::GetAvailableStates>(
      "~/get_available_states",
      [](const srv::GetAvailableStates::Request&, srv::GetAvailableStates::Response& response) {
        for (const LifecycleState state : lifecycle_states()) {
          response.available_states.push_back(state_message(state));
        }
      },
      unmanaged);
  get_available_transitions_ = component.create_service<srv::GetAvailableTransitions>(
      "~/get_available_transitions",
      [&component](const srv::GetAvailableTransitions::Request&,
                   srv::GetAvailableTransitions::Response& response) {
        const LifecycleState state = component.state();
        for (const LifecycleEdge& edge : lifecycle_edges()) {
          if (edge.start == state) {
            response.available_transitions.push_back(description(edge));
          }
        }
      },
      unmanaged);
  get_transition_graph_ = component.create_service<srv::GetAvailableTransitions>(
      "~/get_transition_graph",
      [](const srv::GetAvailableTransitions::Request&,
         srv::GetAvailableTransitions::Response& response) {
        for (const LifecycleEdge& edge : lifecycle_edges()) {
          response.available_transitions.push_back(description(edge));
        }
      },
      unmanaged);
}

LifecycleServices::~LifecycleServices() = default;

void LifecycleServices::publish_transition(const LifecycleEdge& edge) {
  lifecycle_msgs::msg::TransitionEvent event;
  event.timestamp = static_cast<std::uint64_t>(component_.now().time_since_epoch().count());
  event.transition = transition_message(edge);
  event.start_state = state_message(edge.start);
  event.goal_state = state_message(edge.goal);
  events_.publish(std::move(event));
}

}  // namespace pipescout
