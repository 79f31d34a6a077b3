// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "cli/session.hpp"

namespace pipescout::host {
namespace {

struct Options {
  DiscoveryOptions discovery;
  bool types = false;
  bool hidden = false;
  bool count = false;
};

int list_services(Session& session, const Options& options) {
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

}  // namespace

void add_service_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("service", "Services on the network");
  group->require_subcommand(1);
  const auto [command, options] = add_session_command<Options>(
      *group, action, "list", "List the services", false, list_services);
  command->add_flag("-t,--show-types", options->types, "Show the types too");
  command->add_flag("-c,--count-services", options->count, "Print only the count");
  command->add_flag("-a,--include-hidden-services", options->hidden, "Hidden services too");
}

}  // namespace pipescout::host
