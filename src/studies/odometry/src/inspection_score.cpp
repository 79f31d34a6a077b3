// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/inspection_score.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "pipescout/csv/csv_rows.hpp"

namespace pipescout::odometry_study {
namespace {

constexpr double kFoot = 0.3048;          // m
constexpr double kDetectionSigma = 0.03;  // m

[[noreturn]] void refuse(std::string_view name, std::size_t line, const std::string& what) {
  throw std::runtime_error(std::string(name) + ":" + std::to_string(line) + ": " + what);
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// What tells a fixed feature from others of its kind in the same joint: o'clock of a tap or tee,
/// direction of a bend; its radius and angle are each tool's estimate.
std::string mark(const ListedFeature& feature) {
  return feature.kind == "bend" ? feature.comment.substr(feature.comment.rfind(' ') + 1)
                                : feature.clock;
}

using Place = std::tuple<std::string, std::string, std::string>;

std::map<Place, std::vector<double>> fixed_features(const InspectionList& list) {
  static const std::set<std::string> kKinds = {"bend",   "tap",     "valve", "tee",
                                               "flange", "support", "magnet"};
  std::map<Place, std::vector<double>> places;
  for (const ListedFeature& feature : list.features) {
    if (kKinds.contains(feature.kind)) {
      places[{feature.key, feature.kind, mark(feature)}].push_back(feature.chainage);
    }
  }
  return places;
}

}  // namespace

InspectionList read_inspection_list(std::string_view text, const ListColumns& columns,
                                    std::string_view name) {
  const auto table = read_csv_rows(text);
  if (table.rows.empty()) {
    refuse(name, 1, "is empty");
  }
  const auto& header = table.rows.front().cells;
  const auto index = [&](std::string_view column) {
    const auto found = std::find(header.begin(), header.end(), column);
    if (found == header.end()) {
      refuse(name, table.rows.front().line, "no column '" + std::string(column) + "'");
    }
    return static_cast<std::size_t>(found - header.begin());
  };
  const std::size_t key_column = index(columns.key);
  const std::size_t chainage_column = index(columns.chainage);
  const std::size_t kind_column = index(columns.kind);
  const std::size_t clock_column = index(columns.clock);
  const std::size_t comment_column = index(columns.comment);
  InspectionList list;
  std::string key;
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    if (row.cells.size() != header.size()) {
      refuse(
          name, row.line,
          std::to_string(row.cells.size()) + " cells instead of " + std::to_string(header.size()));
    }
    const std::string& distance = row.cells[chainage_column];
    double feet = 0.0;
    const char* end = distance.data() + distance.size();
    const auto parsed = std::from_chars(distance.data(), end, feet);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !std::isfinite(feet)) {
      refuse(name, row.line,
             "column '" + std::string(columns.chainage) + "': '" + distance + "' is not a number");
    }
    ListedFeature feature{.chainage = feet * kFoot,
                          .kind = lower_case(row.cells[kind_column]),
                          .clock = row.cells[clock_column],
                          .comment = row.cells[comment_column],
                          .key = key};
    if (feature.kind == "girth weld" || feature.kind == "girthweld") {
      key = row.cells[key_column];
      list.welds.push_back({.chainage = feature.chainage, .key = key});
    } else {
      list.features.push_back(std::move(feature));
    }
  }
  if (list.welds.empty()) {
    refuse(name, 1, "no girth welds");
  }
  return list;
}

std::vector<odometry::WeldPosition> weld_positions(const InspectionList& list) {
  std::vector<odometry::WeldPosition> positions;
  positions.reserve(list.welds.size());
  for (const ListedWeld& weld : list.welds) {
    positions.push_back({.chainage = weld.chainage, .standard_deviation = kDetectionSigma});
  }
  return positions;
}

std::vector<std::pair<double, double>> common_features(const InspectionList& then,
                                                       const InspectionList& later) {
  const auto earlier_places = fixed_features(then);
  const auto later_places = fixed_features(later);
  std::vector<std::pair<double, double>> common;
  for (const auto& [place, chainages] : earlier_places) {
    const auto other = later_places.find(place);
    if (other != later_places.end() && other->second.size() == chainages.size()) {
      for (std::size_t k = 0; k < chainages.size(); ++k) {
        common.emplace_back(chainages[k], other->second[k]);
      }
    }
  }
  return common;
}

InspectionScore score_inspection(const InspectionList& then, const InspectionList& later) {
  const auto alignment = odometry::align_welds(weld_positions(then), weld_positions(later));
  InspectionScore score;
  std::set<std::string> keys;
  for (const ListedWeld& weld : later.welds) {
    keys.insert(weld.key);
  }
  for (const ListedWeld& weld : then.welds) {
    score.common += keys.contains(weld.key) ? 1 : 0;
  }
  for (const odometry::WeldMatch& match : alignment.matches) {
    const bool same = then.welds[match.a].key == later.welds[match.b].key;
    ++(same ? score.right : score.wrong);
  }
  for (const auto& [before, after] : common_features(then, later)) {
    score.feature_errors.push_back(std::abs(alignment.a_to_b.map(before).chainage - after));
    score.unaligned.push_back(std::abs(before - after));
  }
  return score;
}

}  // namespace pipescout::odometry_study
