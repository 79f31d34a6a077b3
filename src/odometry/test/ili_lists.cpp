// SPDX-License-Identifier: Apache-2.0
#include "ili_lists.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

namespace pipescout::odometry::test {
namespace {

constexpr double kFoot = 0.3048;  // m

/// Cells of the next line; quotes may hold commas. Empty at the end of the file.
std::vector<std::string> next_row(std::istream& file) {
  std::string line;
  if (!std::getline(file, line)) {
    return {};
  }
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

struct Columns {
  const char* chainage;
  const char* kind;
  const char* clock;
  const char* comment;
};

InspectionList load(const std::filesystem::path& path, const Columns& columns) {
  std::ifstream file(path);
  std::map<std::string, std::size_t> index;
  for (const std::string& name : next_row(file)) {
    const std::size_t column = index.size();
    index.emplace(name, column);
  }
  InspectionList list;
  std::string key;
  for (auto row = next_row(file); !row.empty(); row = next_row(file)) {
    const auto cell = [&](const char* name) { return row.at(index.at(name)); };
    ListedFeature feature{.chainage = std::stod(cell(columns.chainage)) * kFoot,
                          .kind = cell(columns.kind),
                          .clock = cell(columns.clock),
                          .comment = cell(columns.comment),
                          .key = key};
    std::transform(feature.kind.begin(), feature.kind.end(), feature.kind.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (feature.kind == "girth weld" || feature.kind == "girthweld") {
      key = cell("J. no.");
      list.welds.push_back({.chainage = feature.chainage, .key = key});
    } else {
      list.features.push_back(feature);
    }
  }
  if (list.welds.empty()) {
    throw std::runtime_error(path.string() + ": no girth welds");
  }
  return list;
}

}  // namespace

std::optional<InspectionRuns> load_inspection_runs() {
  const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
  if (shared == nullptr) {
    return std::nullopt;
  }
  const std::filesystem::path folder = std::filesystem::path(shared) / "ili_pipeline";
  if (!exists(folder / "2007.csv") || !exists(folder / "2015.csv")) {
    return std::nullopt;
  }
  return InspectionRuns{
      .run_2007 = load(folder / "2007.csv", {"log dist. [ft]", "event", "o'clock", "comment"}),
      .run_2015 = load(folder / "2015.csv",
                       {"Log Dist. [ft]", "Event Description", "O'clock", "Comments"})};
}

}  // namespace pipescout::odometry::test
