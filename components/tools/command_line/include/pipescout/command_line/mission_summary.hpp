// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/mission_folder/mission_section.hpp"

/// The summary of a mission folder: the sections that its components wrote, put together. Format:
/// docs/mission_folder.md.
namespace pipescout::command_line {

/// A file of a mission folder cannot be read or written.
class MissionFolderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Summary {
  std::string mission;
  nlohmann::json sections = nlohmann::json::object();  ///< by section name
  nlohmann::json figures = nlohmann::json::object();   ///< of all sections
  /// Sections that could not be used, and figures that two sections claim: "file: reason".
  std::vector<std::string> problems;

  /// A section that no file has; its figures replace those of the same name.
  void add(const std::string& name, const MissionSection& section);
  [[nodiscard]] nlohmann::json to_json() const;
};

/// Reads `sections/*.json`. Throws MissionFolderError when there is no such folder.
[[nodiscard]] Summary read_summary(const std::filesystem::path& mission_folder);

/// Writes `summary.json`. Throws std::system_error naming the file.
void write_summary(const std::filesystem::path& mission_folder, const Summary& summary);

/// Every section as a table with its figures and notes.
void print_summary(std::ostream& out, const Summary& summary);

}  // namespace pipescout::command_line
