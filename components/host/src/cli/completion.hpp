// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

/// What a shell offers when the user presses the tab key, from the commands as they are declared.
namespace pipescout::host {

/// The names of one kind ("node", "topic", "service", "container", "type", "package"): the name
/// that commands give to their arguments. Empty for a kind that it does not know.
using NameSource = std::function<std::vector<std::string>(const std::string& kind)>;

/// What can stand in the place of the last of `words`, the words behind the program's name:
/// subcommands, options when it begins with '-', else the names of the argument that stands there.
/// Sorted, all begin with the last word. Nothing where only the user knows: the shell then offers
/// files.
[[nodiscard]] std::vector<std::string> complete(const CLI::App& app,
                                                const std::vector<std::string>& words,
                                                const NameSource& names);

}  // namespace pipescout::host
