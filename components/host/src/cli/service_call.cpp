// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <set>
#include <string>

#include "cli/message_text.hpp"
#include "cli/service_commands.hpp"
#include "cli/session.hpp"
#include "cli/topic_source.hpp"
#include "cli/yaml_message.hpp"
#include "core/interfaces.hpp"

namespace pipescout::host {

namespace {

struct CallOptions {
  DiscoveryOptions discovery;
  std::string service;
  std::string type;
  std::string values;
  double rate = 0.0;  ///< Hz; 0: one call
};

/// "std_srvs/srv/Trigger", also from "std_srvs/Trigger". Throws CommandError.
InterfaceName service_type(const std::string& text) {
  const auto slash = text.find('/');
  const bool is_short =
      slash != std::string::npos && text.find('/', slash + 1) == std::string::npos;
  try {
    auto name =
        parse_interface_name(is_short ? text.substr(0, slash) + "/srv" + text.substr(slash) : text);
    if (name.kind == InterfaceKind::kService) {
      return name;
    }
  } catch (const std::invalid_argument&) {
    // Said below.
  }
  throw CommandError("'" + text + "' is no service type such as std_srvs/srv/Trigger");
}

/// The types under which others serve it.
std::set<std::string> served_types(const Graph& graph, const std::string& service) {
  // A server reads requests.
  const auto requests = mangle_topic_name(service, DdsTopicKind::kServiceRequest);
  std::set<std::string> types;
  for (const auto& endpoint : graph.endpoints()) {
    if (endpoint.wire_topic == requests && !endpoint.is_publisher && !endpoint.in_this_process) {
      types.insert(demangle_service_type_name(endpoint.wire_type).value_or(endpoint.wire_type));
    }
  }
  return types;
}

/// Throws CommandError when there is no server, or none of that type.
void wait_for_server(Session& session, const std::string& service, const std::string& type) {
  std::set<std::string> served;
  if (!session.wait_for([&] {
        served = served_types(session.graph(), service);
        return !served.empty();
      })) {
    throw CommandError("service " + service + " is not available");
  }
  if (!served.contains(type)) {
    throw CommandError("The service '" + service + "' is served as " + joined(served) +
                       ", not as " + type);
  }
}

int call(Session& session, const CallOptions& options) {
  const auto name = topic_name(options.service);
  const auto type = service_type(options.type);
  const MessageType* request_type = nullptr;
  const MessageType* response_type = nullptr;
  try {
    const auto parts = parts_of(type);
    request_type = parts.at(0);
    response_type = parts.at(1);
  } catch (const MessageTypeError& error) {
    throw CommandError("The service type '" + options.type +
                       "' is not one of this installation: " + error.what());
  }
  const std::shared_ptr<void> request = request_type->create();
  try {
    set_from_yaml(options.values, *request_type, request.get());
  } catch (const YamlMessageError& error) {
    throw CommandError("Failed to populate field: " + std::string(error.what()));
  }
  const MessageFormat in_full{.truncate = std::nullopt};
  const auto client = session.create_client(name, *request_type, *response_type);
  wait_for_server(session, name, type.text());
  for (;;) {
    std::cout << "requester: making request: "
              << to_yaml({request_type, request.get()}, {.truncate = std::nullopt, .flow = true})
              << std::endl;
    const auto response = session.call(*client, request, name);
    std::cout << "response:\n" << to_yaml({response_type, response.get()}, in_full) << std::endl;
    if (options.rate <= 0.0 || !std::cout) {
      return kExitOk;
    }
    session.spin_for(from_seconds(1.0 / options.rate));
  }
}

}  // namespace

void add_service_call(CLI::App& group, Action& action) {
  const auto [command, options] =
      add_session_command<CallOptions>(group, action, "call", "Call a service", true, call);
  command->add_option("service", options->service, "Name of the service")->required();
  command->add_option("type", options->type, "Its type, such as std_srvs/srv/Trigger")->required();
  command->add_option("values", options->values,
                      "Fields of the request as YAML, such as \"{data: true}\"; others keep their "
                      "defaults");
  command->add_option("-r,--rate", options->rate, "Call again and again, so often a second")
      ->check(CLI::Range(1e-6, 1e6));
}

}  // namespace pipescout::host
