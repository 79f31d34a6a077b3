// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// What a shell offers when the user presses the tab key, from the commands as they are declared.
namespace pipescout::command_line {

/// The hidden first word with which a shell asks an executable: "__complete -- bag in".
inline constexpr const char* kComplete = "__complete";

struct Completion {
  /// What can stand there, sorted: subcommands; options when the word begins with '-'; the values
  /// of an option that has only a few. All begin with the word.
  std::vector<std::string> words;
  /// The name that the command gives to the argument that stands there, such as "node" or "topic";
  /// empty where no argument can stand. Whoever knows the names of this kind offers them, else the
  /// shell offers files.
  std::string kind;
};

/// What can stand in the place of the last of `words`, the words behind the program's name.
[[nodiscard]] Completion complete(const CLI::App& app, const std::vector<std::string>& words);

/// Sorted, without doubles, those that begin with `begun`.
[[nodiscard]] std::vector<std::string> beginning_with(const std::string& begun,
                                                      std::vector<std::string> words);

/// Answers a shell: `words` from kComplete on. A line each; the kind as "@KIND", which
/// components/host/environment/completion.bash has `pipescout` replace by names.
void print_completions(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace pipescout::command_line
