// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/completion.hpp"

#include <algorithm>
#include <iostream>
#include <sstream>
#include <utility>

namespace pipescout::command_line {
namespace {

/// The option that is written like this, or null.
const CLI::Option* option_named(const CLI::App& app, const std::string& word) {
  const auto options = app.get_options([&word](const CLI::Option* option) {
    return !option->get_positional() && option->check_name(word.substr(0, word.find('=')));
  });
  return options.empty() ? nullptr : options.front();
}

const CLI::App* subcommand_named(const CLI::App& app, const std::string& word) {
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == word) {
      return command;
    }
  }
  return nullptr;
}

/// Where the cursor stands.
struct Place {
  const CLI::App* command;
  std::size_t arguments = 0;              ///< given so far
  const CLI::Option* awaiting = nullptr;  ///< the option whose value stands there
  bool only_arguments = false;            ///< behind "--"
};

Place find_place(const CLI::App& app, const std::vector<std::string>& words) {
  Place place{.command = &app};
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const auto& word = words[i];
    if (place.awaiting != nullptr) {
      place.awaiting = nullptr;
    } else if (!place.only_arguments && word == "--") {
      place.only_arguments = true;
    } else if (!place.only_arguments && word.starts_with('-')) {
      const auto* const option = option_named(*place.command, word);
      const bool takes_value = option != nullptr && option->get_items_expected_max() > 0;
      place.awaiting = takes_value && word.find('=') == std::string::npos ? option : nullptr;
    } else if (const auto* const chosen = subcommand_named(*place.command, word)) {
      place.command = chosen;
      place.arguments = 0;
    } else {
      ++place.arguments;
    }
  }
  return place;
}

/// The values that CLI::IsMember allows: its description is part of the type's, "TEXT:{png,tiff}".
std::vector<std::string> values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{');
  const auto end = type.find('}');
  std::vector<std::string> values;
  if (begin != std::string::npos && end != std::string::npos && begin < end) {
    std::istringstream list(type.substr(begin + 1, end - begin - 1));
    for (std::string value; std::getline(list, value, ',');) {
      values.push_back(value);
    }
  }
  return values;
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> result;
  for (const auto* option : command.get_options()) {
    if (option->get_group().empty()) {  // hidden
      continue;
    }
    for (const auto& name : option->get_lnames()) {
      result.push_back("--" + name);
    }
    for (const auto& name : option->get_snames()) {
      result.push_back("-" + name);
    }
  }
  return result;
}

Completion candidates(const Place& place, const std::string& begun) {
  if (place.awaiting != nullptr) {
    return {.words = values_of(*place.awaiting), .kind = {}};
  }
  if (!place.only_arguments && begun.starts_with('-')) {
    const auto value = begun.find('=');
    if (value == std::string::npos) {
      return {.words = options_of(*place.command), .kind = {}};
    }
    const auto* const option = option_named(*place.command, begun);
    auto values = option != nullptr ? values_of(*option) : std::vector<std::string>();
    for (auto& each : values) {
      each.insert(0, begun, 0, value + 1);
    }
    return {.words = std::move(values), .kind = {}};
  }
  Completion result;
  for (const auto* command : place.command->get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) {  // else it is hidden
      result.words.push_back(command->get_name());
    }
  }
  const auto arguments = place.command->get_options(
      [](const CLI::Option* option) { return option->get_positional(); });
  if (!result.words.empty() || arguments.empty()) {
    return result;
  }
  // The last one may take any number of words.
  const auto* const argument = arguments[std::min(place.arguments, arguments.size() - 1)];
  if (place.arguments < arguments.size() || argument->get_items_expected_max() > 1) {
    result.words = values_of(*argument);
    result.kind = argument->get_name(true);
  }
  return result;
}

}  // namespace

std::vector<std::string> beginning_with(const std::string& begun, std::vector<std::string> words) {
  std::erase_if(words, [&begun](const std::string& each) { return !each.starts_with(begun); });
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return words;
}

Completion complete(const CLI::App& app, const std::vector<std::string>& words) {
  const std::string begun = words.empty() ? "" : words.back();
  auto result = candidates(find_place(app, words), begun);
  result.words = beginning_with(begun, std::move(result.words));
  return result;
}

void print_completions(const CLI::App& app, const std::vector<std::string>& words) {
  // Behind "__complete --".
  const auto result =
      complete(app, {words.begin() + std::min<std::ptrdiff_t>(2, std::ssize(words)), words.end()});
  for (const auto& word : result.words) {
    std::cout << word << '\n';
  }
  if (!result.kind.empty()) {
    std::cout << '@' << result.kind << '\n';
  }
}

}  // namespace pipescout::command_line
