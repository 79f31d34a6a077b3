// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_folder/mission_section.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <type_traits>
#include <utility>

namespace pipescout {

namespace {

namespace fs = std::filesystem;

nlohmann::ordered_json to_json_value(const MissionCell& cell) {
  return std::visit(
      [](const auto& value) -> nlohmann::ordered_json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
          return nullptr;
        } else {
          return value;
        }
      },
      cell);
}

/// Counts are written without a fraction.
nlohmann::ordered_json to_json_number(double value) {
  constexpr double kExact = 9007199254740992.0;  // 2^53: integers up to it are exact
  if (std::trunc(value) == value && std::abs(value) <= kExact) {
    return static_cast<std::int64_t>(value);
  }
  return value;
}

}  // namespace

std::string to_json(const MissionSection& section) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& cells : section.rows) {
    if (cells.size() != section.columns.size()) {
      throw std::invalid_argument("section '" + section.title + "': a row of " +
                                  std::to_string(cells.size()) + " cells in a table of " +
                                  std::to_string(section.columns.size()) + " columns");
    }
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (const MissionCell& cell : cells) {
      row.push_back(to_json_value(cell));
    }
    rows.push_back(std::move(row));
  }
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
  for (const auto& [name, value] : section.figures) {
    figures[name] = to_json_number(value);
  }
  const nlohmann::ordered_json document{
      {"title", section.title},
      {"table", {{"columns", section.columns}, {"rows", std::move(rows)}}},
      {"figures", std::move(figures)},
      {"notes", section.notes}};
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_mission_section(const fs::path& mission_folder, const std::string& name,
                           const MissionSection& section, Survives survives) {
  const std::string text = to_json(section);
  const fs::path folder = mission_folder / "sections";
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) {
    throw std::system_error(error, "cannot make folder " + folder.string());
  }
  replace_file(folder / (name + ".json"), text, survives);
}

std::string mission_section_name(const std::string& fully_qualified_node) {
  std::string name = fully_qualified_node.substr(fully_qualified_node.find_first_not_of('/'));
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

fs::path make_mission_data_folder(const fs::path& mission_folder, const std::string& node_namespace,
                                  const std::string& name) {
  std::error_code error;
  if (!fs::is_directory(mission_folder, error)) {
    throw std::system_error(error ? error : std::make_error_code(std::errc::not_a_directory),
                            "mission folder " + mission_folder.string());
  }
  const fs::path parent = mission_folder / fs::path(node_namespace).relative_path();
  fs::create_directories(parent, error);
  if (error) {
    throw std::system_error(error, "cannot make folder " + parent.string());
  }
  // Asking and making in one step: another component may want the same name.
  for (int attempt = 1;; ++attempt) {
    const fs::path folder = parent / (attempt == 1 ? name : name + "_" + std::to_string(attempt));
    if (fs::create_directory(folder, error)) {
      return folder;
    }
    if (error) {
      throw std::system_error(error, "cannot make folder " + folder.string());
    }
  }
}

}  // namespace pipescout
