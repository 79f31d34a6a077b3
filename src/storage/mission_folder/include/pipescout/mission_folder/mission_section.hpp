// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

/// A component's part of a mission's summary, see docs/mission_folder.md.
namespace pipescout {

/// A cell of a table; std::monostate: no value.
using MissionCell = std::variant<std::monostate, bool, std::int64_t, double, std::string>;

struct MissionSection {
  std::string title;
  std::vector<std::string> columns;            ///< of the table, units in brackets: "fused [m]"
  std::vector<std::vector<MissionCell>> rows;  ///< each as long as `columns`
  std::map<std::string, double> figures;       ///< name with unit at its end -> value
  std::vector<std::string> notes;
};

/// The content of a section file. Numbers that are not finite become null, bytes that are no UTF-8
/// become U+FFFD. Throws std::invalid_argument when a row is not as long as `columns`.
[[nodiscard]] std::string to_json(const MissionSection& section);

/// The node's name in a mission folder: "/robot_1/recorder" -> "robot_1.recorder".
[[nodiscard]] std::string mission_section_name(const std::string& fully_qualified_node);

}  // namespace pipescout
