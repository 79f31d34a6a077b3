// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_folder/mission_section.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace pipescout {

namespace {

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

std::string mission_section_name(const std::string& fully_qualified_node) {
  std::string name = fully_qualified_node.substr(fully_qualified_node.find_first_not_of('/'));
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

}  // namespace pipescout
