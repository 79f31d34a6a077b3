// SPDX-License-Identifier: Apache-2.0
#include "cli/service_commands.hpp"

#include <iostream>

#include "cli/name_commands.hpp"
#include "cli/session.hpp"
#include "cli/topic_source.hpp"

namespace pipescout::host {
namespace {

struct ServiceListOptions {
  DiscoveryOptions discovery;
  bool types = false;
  bool hidden = false;
  bool count = false;
};

int list_services(Session& session, const ServiceListOptions& options) {
  session.settle();
  auto services = session.graph().services();
  std::erase_if(services,
                [&](const auto& entry) { return !options.hidden && is_hidden(entry.first); });
  if (options.count) {
    std::cout << services.size() << '\n';
    return kExitOk;
  }
  for (const auto& [name, types] : services) {
    std::cout << name;
    if (options.types) {
      const char* separator = " [";
      for (const auto& type : types) {
        std::cout << separator << type;
        separator = ", ";
      }
      std::cout << ']';
    }
    std::cout << '\n';
  }
  return kExitOk;
}

struct InfoOptions {
  DiscoveryOptions discovery;
  std::string service;
};

int service_info(Session& session, const InfoOptions& options) {
  const auto name = topic_name(options.service);
  auto& graph = session.graph();
  if (!session.wait_for([&] { return graph.services().contains(name); })) {
    throw CommandError("Unknown service '" + options.service + "'");
  }
  session.settle();
  // A client writes requests, a server reads them.
  const auto requests = mangle_topic_name(name, DdsTopicKind::kServiceRequest);
  std::size_t clients = 0;
  std::size_t servers = 0;
  for (const auto& endpoint : graph.endpoints()) {
    if (endpoint.wire_topic == requests) {
      ++(endpoint.is_publisher ? clients : servers);
    }
  }
  const auto types = graph.services()[name];
  for (const auto& type : types) {
    std::cout << "Type: " << type << '\n';
  }
  std::cout << "Clients count: " << clients << "\nServices count: " << servers << '\n';
  return kExitOk;
}

}  // namespace

void add_service_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("service", "Services on the network");
  group->require_subcommand(1);
  const auto [command, options] = add_graph_command<ServiceListOptions>(
      *group, action, "list", "List the services", list_services);
  command->add_flag("-t,--show-types", options->types, "Show the types too");
  command->add_flag("-c,--count-services", options->count, "Print only the count");
  command->add_flag("-a,--include-hidden-services", options->hidden, "Hidden services too");
  add_service_call(*group, action);
  add_name_commands(*group, action, "service",
                    [](Session& session) { return session.graph().services(); });
  const auto [info, info_options] = add_graph_command<InfoOptions>(
      *group, action, "info", "Show type, clients and servers of a service", service_info);
  info->add_option("service", info_options->service, "Name of the service")->required();
}

}  // namespace pipescout::host
