// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "core/composition.hpp"
#include "pipescout/interfaces/whole_file.hpp"
#include "reproduce/reproduce.hpp"

namespace pipescout::host {
namespace {

std::string known_tables() {
  std::string text;
  for (const auto& table : reproducible_tables()) {
    text += "\n  " + std::string(table.name) + "  " + std::string(table.description);
  }
  return text;
}

int reproduce(const std::string& name, const std::string& json_file) {
  std::vector<std::string> names;
  for (const auto& table : reproducible_tables()) {
    names.emplace_back(table.name);
    if (table.name != name) {
      continue;
    }
    const auto result = table.reproduce(std::cout);
    if (!json_file.empty()) {
      const nlohmann::json json{
          {"figures", result.figures}, {"rows", result.rows}, {"seeds", result.seeds}};
      replace_file(json_file, json.dump(2) + "\n");
    }
    return kExitOk;
  }
  throw CommandError((name.empty() ? "which table?" : "unknown table '" + name + "'") +
                     suggestion(name, names) + " Known tables:" + known_tables());
}

}  // namespace

void add_reproduce_command(CLI::App& app, Action& action) {
  struct Options {
    std::string table;
    std::string json;
  };
  auto options = std::make_shared<Options>();
  auto* command =
      app.add_subcommand("reproduce", "Compute a table of a paper and print it beside the paper's");
  command->add_option("table", options->table, "Name of the table");
  command->add_option("--json", options->json, "Write figures, rows and seeds to this file too");
  command->footer("Tables:" + known_tables());
  command->callback(
      [=, &action] { action = [=] { return reproduce(options->table, options->json); }; });
}

}  // namespace pipescout::host
