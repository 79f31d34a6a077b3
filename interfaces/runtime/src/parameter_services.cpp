// SPDX-License-Identifier: Apache-2.0
#include "parameter_services.hpp"

#include <exception>
#include <stdexcept>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout {

namespace {

namespace srv = rcl_interfaces::srv;

// Runs a query; a question that cannot be answered leaves the response empty, as rclcpp does.
template <class Query>
void answer(const Node& node, const Query& query) {
  try {
    query(node.parameters());
  } catch (const ParameterError& error) {
    node.logger().debug(error.what());
  }
}

SetResult set_one(Parameters& parameters, const rcl_interfaces::msg::Parameter& message) {
  try {
    return parameters.set_atomically({from_message(message)});
  } catch (const std::invalid_argument& error) {
    return SetResult::refuse(error.what());
  }
}

SetResult set_all(Parameters& parameters,
                  const std::vector<rcl_interfaces::msg::Parameter>& messages) {
  std::vector<NamedParameter> proposed;
  proposed.reserve(messages.size());
  try {
    for (const auto& message : messages) {
      proposed.push_back(from_message(message));
    }
  } catch (const std::invalid_argument& error) {
    return SetResult::refuse(error.what());
  }
  return parameters.set_atomically(proposed);
}

}  // namespace

ParameterServices::ParameterServices(Node& node) : node_(node) {
  const NodeServiceOptions unmanaged{.qos = QoS::parameters(), .managed = false};

  events_ = node.create_publisher(topics::kParameterEvents, {.managed = false});
  node.parameters().set_event_sink(
      [&node, events = events_](const ParameterChange& change) mutable {
        rcl_interfaces::msg::ParameterEvent event;
        event.stamp = to_message(node.now());
        event.node = node.node_name().fully_qualified();
        event.new_parameters = to_message(change.new_parameters);
        event.changed_parameters = to_message(change.changed_parameters);
        event.deleted_parameters = to_message(change.deleted_parameters);
        events.publish(std::move(event));
      });

  describe_ = node.create_service<srv::DescribeParameters>(
      "~/describe_parameters",
      [&node](const auto& request, auto& response) {
        answer(node, [&](const Parameters& parameters) {
          for (const auto& descriptor : parameters.describe(request.names)) {
            response.descriptors.push_back(to_message(descriptor));
          }
        });
      },
      unmanaged);
  get_types_ = node.create_service<srv::GetParameterTypes>(
      "~/get_parameter_types",
      [&node](const auto& request, auto& response) {
        answer(node, [&](const Parameters& parameters) {
          for (const ParameterType type : parameters.types(request.names)) {
            response.types.push_back(static_cast<std::uint8_t>(type));
          }
        });
      },
      unmanaged);
  get_ = node.create_service<srv::GetParameters>(
      "~/get_parameters",
      [&node](const auto& request, auto& response) {
        answer(node, [&](const Parameters& parameters) {
          for (const auto& value : parameters.get_many(request.names)) {
            response.values.push_back(to_message(value));
          }
        });
      },
      unmanaged);
  list_ = node.create_service<srv::ListParameters>(
      "~/list_parameters",
      [&node](const auto& request, auto& response) {
        response.result = to_message(node.parameters().list(request.prefixes, request.depth));
      },
      unmanaged);
  set_ = node.create_service<srv::SetParameters>(
      "~/set_parameters",
      [&node](const auto& request, auto& response) {
        for (const auto& parameter : request.parameters) {
          response.results.push_back(to_message(set_one(node.parameters(), parameter)));
        }
      },
      unmanaged);
  set_atomically_ = node.create_service<srv::SetParametersAtomically>(
      "~/set_parameters_atomically",
      [&node](const auto& request, auto& response) {
        response.result = to_message(set_all(node.parameters(), request.parameters));
      },
      unmanaged);
}

ParameterServices::~ParameterServices() {
  node_.parameters().set_event_sink({});
}

}  // namespace pipescout
