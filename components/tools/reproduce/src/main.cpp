// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>

#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/files/whole_file.hpp"
#include "reproduce.hpp"
#include "revision.hpp"

namespace pipescout::reproduce {
namespace {

using command_line::Action;
using command_line::CommandError;
using command_line::kExitOk;
using command_line::suggestion;

std::string known_tables() {
  std::string text;
  for (const auto& table : reproducible_tables()) {
    text += "\n  " + std::string(table.name) + "  " + std::string(table.description);
  }
  return text;
}

struct Arguments {
  std::string table;
  std::string json;
  std::size_t seeds = ReproduceOptions::kAllSeeds;
  std::optional<std::uint64_t> seed_base;
  std::string data;
  std::string part;
  std::optional<std::size_t> trials;
  bool simulation_asked_for = false;  ///< --seeds, --seed-base or --data is given
};

/// Where the seeds of a score begin, said aloud.
std::uint64_t first_seed(const Arguments& arguments) {
  if (arguments.seed_base) {
    std::cerr << "Seeds from " << *arguments.seed_base << " on, as asked for.\n";
    return *arguments.seed_base;
  }
  const auto base = seed_base_of(PIPESCOUT_REVISION);
  if (!base) {
    throw CommandError(
        "this program was not built from a git revision, from which it would draw its seeds: give "
        "--seed-base");
  }
  std::cerr << "Seeds from " << *base << " on, drawn from revision " PIPESCOUT_REVISION ".\n";
  return *base;
}

int reproduce(const Arguments& arguments) {
  command_line::require_new_file(arguments.json);
  const std::string& name = arguments.table;
  std::vector<std::string> names;
  for (const auto& table : reproducible_tables()) {
    names.emplace_back(table.name);
    if (table.name != name) {
      continue;
    }
    if (arguments.simulation_asked_for && !table.simulates) {
      throw CommandError("table '" + name + "' has no --seeds and no --data");
    }
    if (table.parts.empty() && (arguments.trials || !arguments.part.empty())) {
      throw CommandError("table '" + name + "' has no --part and no --trials");
    }
    if (!arguments.part.empty() &&
        std::ranges::find(table.parts, arguments.part) == table.parts.end()) {
      throw CommandError("table '" + name + "' has no part '" + arguments.part + "'" +
                         suggestion(arguments.part, {table.parts.begin(), table.parts.end()}));
    }
    const auto result = table.reproduce({.seeds = arguments.seeds,
                                         .seed_base = table.simulates ? first_seed(arguments) : 0,
                                         .part = arguments.part,
                                         .trials = arguments.trials,
                                         .data = arguments.data,
                                         .progress = &std::cerr,
                                         .progress_on_terminal = isatty(STDERR_FILENO) == 1},
                                        std::cout);
    if (!arguments.json.empty()) {
      const nlohmann::json json{{"figures", result.figures},
                                {"rows", result.rows},
                                {"seeds", result.seeds},
                                {"revision", PIPESCOUT_REVISION}};
      replace_file(arguments.json, json.dump(2) + "\n");
    }
    return kExitOk;
  }
  throw CommandError((name.empty() ? "which table?" : "unknown table '" + name + "'") +
                     suggestion(name, names) + " Known tables:" + known_tables());
}

void add_command(CLI::App& app, Action& action) {
  constexpr std::size_t kMostSeeds = 1000;
  constexpr std::size_t kMostTrials = 100'000;
  constexpr std::uint64_t kLargestSeed = 4'000'000'000;
  auto arguments = std::make_shared<Arguments>();
  app.add_option("table", arguments->table, "Name of the table");
  app.add_option("--json", arguments->json, "Also write figures, rows and seeds to this file");
  const auto* seeds = app.add_option("--seeds", arguments->seeds,
                                     "Number of seeds to simulate; " +
                                         std::to_string(arguments->seeds) + " unless given")
                          ->check(CLI::Range(std::size_t{1}, kMostSeeds));
  const auto* seed_base =
      app.add_option("--seed-base", arguments->seed_base,
                     "First seed; default: drawn from the git revision that this was built from. "
                     "Development uses seeds up to 999")
          ->check(CLI::Range(std::uint64_t{1}, kLargestSeed));
  const auto* data =
      app.add_option("--data", arguments->data,
                     "Folder of real data; default: $PIPESCOUT_SHARED_DATA or ../shared/data");
  app.add_option(
      "--part", arguments->part,
      "Of table rack: features, images, noise, offsets, shapes, bodies, cameras or leaks; "
      "default: all");
  app.add_option("--trials", arguments->trials,
                 "Of table rack: trials of each figure over pipes that are not where the rack file "
                 "has them; default: 1000, 500 of those far away, and 20 of other shapes in each "
                 "renderer")
      ->check(CLI::Range(std::size_t{1}, kMostTrials));
  app.footer("Tables:" + known_tables());
  app.callback([=, &action] {
    arguments->simulation_asked_for =
        seeds->count() > 0 || seed_base->count() > 0 || data->count() > 0;
    action = [=] { return reproduce(*arguments); };
  });
}

}  // namespace
}  // namespace pipescout::reproduce

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout reproduce",
                                               pipescout::reproduce::add_command, argc, argv);
}
