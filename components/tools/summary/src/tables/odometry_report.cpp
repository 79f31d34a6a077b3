// SPDX-License-Identifier: Apache-2.0
#include "tables/odometry_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipescout/validation/number_text.hpp"
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

double OdometryReport::offset(std::size_t odometer) const {
  return options_.offsets && odometer < options_.offsets->size() ? (*options_.offsets)[odometer]
                                                                 : 0.0;
}

bool OdometryReport::has_offsets() const {
  return options_.offsets &&
         std::ranges::any_of(*options_.offsets, [](double added) { return added != 0.0; });
}

/// As a weighted mean is; true too where it was not fused.
bool OdometryReport::is_between_its_readings(const Row& row) const {
  constexpr double kRounding = 1e-6;  // m
  if (!row.fused || !row.fused->has_consensus) {
    return true;
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto& members = row.fused->in_fusion_set;
  for (std::size_t i = 0; i < std::min(members.size(), row.distance.size()); ++i) {
    if (members[i]) {
      low = std::min(low, row.distance[i] + offset(i));
      high = std::max(high, row.distance[i] + offset(i));
    }
  }
  return row.fused->distance >= low - kRounding && row.fused->distance <= high + kRounding;
}

void OdometryReport::add_notes_on_offsets(MissionSection& section) const {
  if (has_offsets()) {
    std::string offsets;
    for (const double added : *options_.offsets) {
      offsets += (offsets.empty() ? "" : ", ") + validation::number_text(added);
    }
    section.notes.push_back("Readings as they were fused, with the offsets " + offsets +
                            " m added; readings.csv has them as measured, and by those the support "
                            "set is chosen.");
  }
  std::size_t apart = 0;
  for (const Row& row : rows_) {
    apart += is_between_its_readings(row) ? 0U : 1U;
  }
  if (apart > 0) {
    section.notes.push_back(
        "In " + std::to_string(apart) + " of " + std::to_string(rows_.size()) +
        " rows the fused distance is not between the readings that were fused: " +
        (options_.offsets ? "the offsets were changed during the run."
                          : "offsets were added to them that the bag does not tell."));
  }
}

MissionSection OdometryReport::section(const std::string& figure_prefix) const {
  const bool has_reference = !options_.reference.empty();
  MissionSection section;
  section.title = "Odometry";
  section.columns.push_back("reading");
  for (std::size_t i = 0; i < options_.odometers.size(); ++i) {
    const double added = offset(i);
    section.columns.push_back(
        options_.odometers[i] +
        (added == 0.0 ? ""
                      : (added > 0 ? " + " : " - ") + validation::number_text(std::abs(added))) +
        " [m]");
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
    for (std::size_t k = 0; k < row.distance.size(); ++k) {
      cells.push_back(rounded_cell(row.distance[k] + offset(k), kParts));
    }
    cells.emplace_back(row.fused ? MissionCell(format_fusion_set(row.fused->in_fusion_set))
                                 : MissionCell());
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
  add_notes_on_offsets(section);
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
