// SPDX-License-Identifier: Apache-2.0
#include "tables/odometry_report.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

/// 0.1 mm: below what an odometer resolves.
constexpr double kParts = 1e4;

/// Takes the value that has waited longest under a key.
template <class Value>
std::optional<Value> take(std::multimap<Time, Value>& waiting, Time stamp) {
  const auto found = waiting.lower_bound(stamp);
  if (found == waiting.end() || found->first != stamp) {
    return std::nullopt;
  }
  std::optional<Value> value = std::move(found->second);
  waiting.erase(found);
  return value;
}

template <class Value>
void put(std::multimap<Time, Value>& waiting, Time stamp, const Value& value, std::size_t limit) {
  if (waiting.size() >= limit) {
    waiting.erase(waiting.begin());
  }
  waiting.emplace(stamp, value);
}

}  // namespace

OdometryReport::OdometryReport(Options options) : options_(std::move(options)) {}

std::uint64_t OdometryReport::add_reading(Time stamp, const std::vector<double>& distance) {
  const std::uint64_t reading = ++readings_;
  if (rows_.size() < options_.maximum_rows) {
    rows_.push_back({distance, std::nullopt});
  }
  if (const auto fused = take(waiting_fused_, stamp)) {
    pair(reading, *fused);
  } else {
    put(waiting_readings_, stamp, reading, kMaximumWaiting);
  }
  return reading;
}

std::optional<std::uint64_t> OdometryReport::add_fused(const Fused& fused) {
  ++fused_;
  without_consensus_ += fused.has_consensus ? 0 : 1;
  const auto reading = take(waiting_readings_, fused.stamp);
  if (reading) {
    pair(*reading, fused);
  } else {
    put(waiting_fused_, fused.stamp, fused, kMaximumWaiting);
  }
  return reading;
}

void OdometryReport::pair(std::uint64_t reading, const Fused& fused) {
  ++pairs_;
  if (reading <= rows_.size()) {
    rows_[reading - 1].fused = fused;
  }
  const double difference = std::abs(fused.distance - reference(reading));
  if (fused.has_consensus && std::isfinite(difference) &&
      (!largest_difference_ || difference > *largest_difference_)) {
    largest_difference_ = difference;
    largest_difference_reading_ = reading;
  }
}

double OdometryReport::reference(std::uint64_t reading) const {
  return reading <= options_.reference.size() ? options_.reference[reading - 1]
                                              : std::numeric_limits<double>::quiet_NaN();
}

MissionSection OdometryReport::section(const std::string& figure_prefix) const {
  const bool has_reference = !options_.reference.empty();
  MissionSection section;
  section.title = "Odometry";
  section.columns.push_back("reading");
  for (const std::string& odometer : options_.odometers) {
    section.columns.push_back(odometer + " [m]");
  }
  section.columns.insert(section.columns.end(),
                         {"support set", "fused [m]", "standard deviation [m]"});
  if (has_reference) {
    section.columns.insert(section.columns.end(),
                           {options_.reference_name + " [m]", "difference [m]"});
  }

  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    std::vector<MissionCell> cells{static_cast<std::int64_t>(i + 1)};
    for (const double distance : row.distance) {
      cells.push_back(rounded_cell(distance, kParts));
    }
    cells.emplace_back(row.fused ? MissionCell(row.fused->fusion_set) : MissionCell());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double fused = row.fused ? row.fused->distance : nan;
    cells.push_back(rounded_cell(fused, kParts));
    cells.push_back(rounded_cell(row.fused ? row.fused->standard_deviation : nan, kParts));
    if (has_reference) {
      cells.push_back(rounded_cell(reference(i + 1), kParts));
      cells.push_back(rounded_cell(fused - reference(i + 1), kParts));
    }
    section.rows.push_back(std::move(cells));
  }

  section.figures[figure_prefix + "odometry_readings"] = static_cast<double>(readings_);
  section.figures[figure_prefix + "odometry_fused"] = static_cast<double>(fused_);
  section.figures[figure_prefix + "odometry_without_consensus"] =
      static_cast<double>(without_consensus_);
  if (largest_difference_) {
    section.figures[figure_prefix + "odometry_max_abs_difference_m"] = *largest_difference_;
    section.notes.push_back("The largest difference to " + options_.reference_name +
                            " is at reading " + std::to_string(largest_difference_reading_) + ".");
  }
  if (readings_ > rows_.size()) {
    section.notes.push_back("The table shows the first " + std::to_string(rows_.size()) + " of " +
                            std::to_string(readings_) + " readings.");
  }
  return section;
}

std::string format_fusion_set(const std::vector<bool>& in_fusion_set) {
  std::string text;
  for (std::size_t i = 0; i < in_fusion_set.size(); ++i) {
    if (in_fusion_set[i]) {
      text.append(text.empty() ? "" : " ").append(std::to_string(i + 1));
    }
  }
  return text;
}

}  // namespace pipescout::summary
