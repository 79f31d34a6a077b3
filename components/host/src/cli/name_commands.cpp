// SPDX-License-Identifier: Apache-2.0
#include "cli/name_commands.hpp"

#include <iostream>

#include "cli/topic_source.hpp"

namespace pipescout::host {
namespace {

struct NameOptions {
  DiscoveryOptions discovery;
  std::string name;
  bool hidden = false;
  bool count = false;
};

}  // namespace

void add_name_commands(CLI::App& group, Action& action, const char* what,
                       NamesAndTypes (*names)(Session& session)) {
  const std::string thing(what);
  const auto type_text = "Print the type of a " + thing;
  const auto [type, type_options] = add_graph_command<NameOptions>(
      group, action, "type", type_text.c_str(),
      [names, thing](Session& session, const NameOptions& options) {
        const auto name = topic_name(options.name);
        NamesAndTypes found;
        const bool known = session.wait_for([&] {
          found = names(session);
          return found.contains(name);
        });
        if (!known) {
          throw CommandError("Unknown " + thing + " '" + options.name + "'");
        }
        for (const auto& each : found.at(name)) {
          std::cout << each << '\n';
        }
        return kExitOk;
      });
  type->add_option(what, type_options->name, "Name of the " + thing)->required();

  const auto find_text = "List the " + thing + "s of a type";
  const auto [find, find_options] = add_graph_command<NameOptions>(
      group, action, "find", find_text.c_str(),
      [names](Session& session, const NameOptions& options) {
        session.settle();
        std::size_t found = 0;
        for (const auto& [name, types] : names(session)) {
          if (types.contains(options.name) && (options.hidden || !is_hidden(name))) {
            ++found;
            if (!options.count) {
              std::cout << name << '\n';
            }
          }
        }
        if (options.count) {
          std::cout << found << '\n';
        }
        return kExitOk;
      });
  find->add_option("type", find_options->name, "Such as std_msgs/msg/String, std_srvs/srv/Trigger")
      ->required();
  find->add_flag("-c,--count-" + thing + "s", find_options->count, "Print only how many there are");
  find->add_flag("--include-hidden-" + thing + "s", find_options->hidden, "Hidden ones too");
}

}  // namespace pipescout::host
