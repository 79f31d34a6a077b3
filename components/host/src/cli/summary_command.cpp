// SPDX-License-Identifier: Apache-2.0
#include "core/summary.hpp"

#include <iostream>
#include <memory>

#include "cli/command.hpp"

namespace pipescout::host {

void add_summary_command(CLI::App& app, Action& action) {
  auto folder = std::make_shared<std::string>();
  auto* command = app.add_subcommand(
      "summary", "Merge the sections of a mission folder and print them as tables");
  command->add_option("folder", *folder, "Mission folder")->required();
  command->callback([=, &action] {
    action = [=] {
      const auto summary = read_summary(*folder);
      write_summary(*folder, summary);
      print_summary(std::cout, summary);
      for (const auto& problem : summary.problems) {
        std::cerr << "error: " << problem << '\n';
      }
      return summary.problems.empty() ? kExitOk : kExitError;
    };
  });
}

}  // namespace pipescout::host
