// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/inspection_score.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "pipescout/csv/csv_table.hpp"

namespace pipescout::odometry_study {
namespace {

constexpr double kFoot = 0.3048;          // m
constexpr double kDetectionSigma = 0.03;  // m

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
  const CsvTable table(text, name);
  const auto index = [&](std::string_view column) {
    const auto found = table.find_column(column);
    if (!found) {
      throw CsvError(table.path(), table.header_line(), "no column '" + std::string(column) + "'");
    }
    return *found;
  };
  const std::size_t key_column = index(columns.key);
  const std::size_t chainage_column = index(columns.chainage);
  const std::size_t kind_column = index(columns.kind);
  const std::size_t clock_column = index(columns.clock);
  const std::size_t comment_column = index(columns.comment);
  InspectionList list;
  std::string key;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ListedFeature feature{.chainage = table.required(row, chainage_column) * kFoot,
                          .kind = lower_case(table.cell(row, kind_column)),
                          .clock = table.cell(row, clock_column),
                          .comment = table.cell(row, comment_column),
                          .key = key};
    if (feature.kind == "girth weld" || feature.kind == "girthweld") {
      key = table.cell(row, key_column);
      list.welds.push_back({.chainage = feature.chainage, .key = key});
    } else {
      list.features.push_back(std::move(feature));
    }
  }
  if (list.welds.empty()) {
    throw CsvError(table.path(), 0, "no girth welds");
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
