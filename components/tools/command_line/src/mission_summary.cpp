// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/mission_summary.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

#include "pipescout/command_line/text_table.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout::command_line {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Why the JSON is no section, or "".
std::string objection(const json& section) {
  if (!section.is_object()) {
    return "is not an object";
  }
  const auto is = [&](const char* key, bool (json::*test)() const noexcept) {
    const auto member = section.find(key);
    return member != section.end() && ((*member).*test)();
  };
  if (!is("title", &json::is_string)) {
    return "has no text 'title'";
  }
  if (!is("figures", &json::is_object)) {
    return "has no object 'figures'";
  }
  for (const auto& [name, value] : section["figures"].items()) {
    if (!value.is_number() && !value.is_null()) {
      return "figure '" + name + "' is not a number";
    }
  }
  const auto all_texts = [](const json& list) {
    return std::all_of(list.begin(), list.end(), [](const json& j) { return j.is_string(); });
  };
  if (!is("notes", &json::is_array) || !all_texts(section["notes"])) {
    return "has no list of texts 'notes'";
  }
  if (!is("table", &json::is_object)) {
    return "has no object 'table'";
  }
  const auto& table = section["table"];
  if (!table.contains("columns") || !table["columns"].is_array() || !all_texts(table["columns"])) {
    return "has no list of texts 'table.columns'";
  }
  if (!table.contains("rows") || !table["rows"].is_array()) {
    return "has no list 'table.rows'";
  }
  for (const auto& row : table["rows"]) {
    if (!row.is_array() || row.size() != table["columns"].size()) {
      return "has a row that is not as long as 'table.columns'";
    }
    if (std::any_of(row.begin(), row.end(), [](const json& j) { return j.is_structured(); })) {
      return "has a table cell that is neither number, text, boolean nor null";
    }
  }
  return "";
}

TextTable::Cell to_cell(const json& value) {
  if (value.is_boolean()) {
    return value.get<bool>();
  }
  if (value.is_number_integer()) {
    return value.get<std::int64_t>();
  }
  if (value.is_number()) {
    return value.get<double>();
  }
  if (value.is_string()) {
    return value.get<std::string>();
  }
  return std::monostate{};
}

std::string mission_name(const fs::path& folder) {
  try {
    const auto name = YAML::LoadFile((folder / "mission.yaml").string())["name"];
    if (name && name.IsScalar()) {
      return name.Scalar();
    }
  } catch (const YAML::Exception&) {
    // The folder of a mission that was killed early; its name says enough.
  }
  const auto absolute = fs::absolute(folder).lexically_normal();
  return (absolute.has_filename() ? absolute : absolute.parent_path()).filename().string();
}

void add_section(Summary& summary, const fs::path& file,
                 std::map<std::string, std::string>& figure_owner) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  json section;
  if (!stream) {
    summary.problems.push_back(file.string() + ": cannot be read");
    return;
  }
  try {
    section = json::parse(text);
  } catch (const json::parse_error& error) {
    summary.problems.push_back(file.string() + ": " + error.what());
    return;
  }
  if (const auto why = objection(section); !why.empty()) {
    summary.problems.push_back(file.string() + ": " + why);
    return;
  }
  const auto name = file.stem().string();
  for (const auto& [figure, value] : section["figures"].items()) {
    const auto [owner, is_new] = figure_owner.emplace(figure, name);
    if (is_new) {
      summary.figures[figure] = value;
    } else {
      summary.problems.push_back(file.string() + ": figure '" + figure +
                                 "' is also one of section '" + owner->second + "'");
    }
  }
  summary.sections[name] = std::move(section);
}

/// Whole numbers in full, others with six digits: the file has them all.
std::string figure_text(const json& value) {
  if (value.is_null()) {
    return "-";
  }
  const double number = value.get<double>();
  std::array<char, 32> text{};
  const bool whole = number == std::trunc(number) && std::abs(number) < 1e15;
  std::snprintf(text.data(), text.size(), whole ? "%.0f" : "%.6g", number);
  return text.data();
}

}  // namespace

void Summary::add(const std::string& name, const MissionSection& section) {
  sections[name] = json::parse(pipescout::to_json(section));
  figures.update(sections[name]["figures"]);
}

json Summary::to_json() const {
  return {{"mission", mission}, {"sections", sections}, {"figures", figures}};
}

Summary read_summary(const fs::path& mission_folder) {
  std::error_code error;
  if (!fs::is_directory(mission_folder, error)) {
    throw MissionFolderError(mission_folder.string() + ": no such folder");
  }
  Summary summary;
  summary.mission = mission_name(mission_folder);
  std::vector<fs::path> files;
  const auto folder = mission_folder / "sections";
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".json") {
        files.push_back(entry.path());
      }
    }
  }
  if (error) {
    throw MissionFolderError(folder.string() + ": " + error.message());
  }
  std::sort(files.begin(), files.end());
  std::map<std::string, std::string> figure_owner;
  for (const auto& file : files) {
    add_section(summary, file, figure_owner);
  }
  return summary;
}

void write_summary(const fs::path& mission_folder, const Summary& summary) {
  replace_file(mission_folder / "summary.json",
               summary.to_json().dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

void print_summary(std::ostream& out, const Summary& summary) {
  out << "Mission " << summary.mission << '\n';
  if (summary.sections.empty()) {
    out << "\nNo component wrote a section.\n";
  }
  for (const auto& [name, section] : summary.sections.items()) {
    out << '\n' << section["title"].get<std::string>() << " (" << name << ")\n\n";
    const auto& table = section["table"];
    if (!table["columns"].empty()) {
      TextTable text(table["columns"].get<std::vector<std::string>>());
      for (const auto& row : table["rows"]) {
        std::vector<TextTable::Cell> cells;
        std::transform(row.begin(), row.end(), std::back_inserter(cells), to_cell);
        text.add_row(std::move(cells));
      }
      text.print(out, "  ");
      out << '\n';
    }
    for (const auto& [figure, value] : section["figures"].items()) {
      out << "  " << figure << " = " << figure_text(value) << '\n';
    }
    for (const auto& note : section["notes"]) {
      out << "  " << note.get<std::string>() << '\n';
    }
  }
}

}  // namespace pipescout::command_line
