// SPDX-License-Identifier: Apache-2.0
#include "cli/completion.hpp"

#include <algorithm>

namespace pipescout::host {
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

std::vector<std::string> candidates(const Place& place, const std::string& begun,
                                    const NameSource& names) {
  std::vector<std::string> result;
  if (place.awaiting != nullptr) {
    return result;
  }
  if (!place.only_arguments && begun.starts_with('-')) {
    for (const auto* option : place.command->get_options()) {
      for (const auto& name : option->get_lnames()) {
        result.push_back("--" + name);
      }
      for (const auto& name : option->get_snames()) {
        result.push_back("-" + name);
      }
    }
    return result;
  }
  for (const auto* command : place.command->get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) {  // else it is hidden
      result.push_back(command->get_name());
    }
  }
  if (!result.empty()) {
    return result;
  }
  const auto arguments = place.command->get_options(
      [](const CLI::Option* option) { return option->get_positional(); });
  if (arguments.empty()) {
    return result;
  }
  // The last one may take any number of words.
  const auto* const argument = arguments[std::min(place.arguments, arguments.size() - 1)];
  if (place.arguments < arguments.size() || argument->get_items_expected_max() > 1) {
    result = names(argument->get_name(true));
  }
  return result;
}

}  // namespace

std::vector<std::string> complete(const CLI::App& app, const std::vector<std::string>& words,
                                  const NameSource& names) {
  const std::string begun = words.empty() ? "" : words.back();
  auto result = candidates(find_place(app, words), begun, names);
  std::erase_if(result, [&begun](const std::string& each) { return !each.starts_with(begun); });
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace pipescout::host
