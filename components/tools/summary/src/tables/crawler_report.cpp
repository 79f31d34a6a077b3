// SPDX-License-Identifier: Apache-2.0
#include "tables/crawler_report.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/normal.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

/// m; at a weld the two joints that it bounds are equally right.
constexpr double kAtWeld = 0.5;

}  // namespace

CrawlerReport::CrawlerReport(std::size_t maximum_rows) : maximum_rows_(maximum_rows) {}

void CrawlerReport::add_weld(const Weld& weld) {
  ++welds_;
  recognised_ += weld.id.empty() && !std::isfinite(weld.chainage) ? 0 : 1;
  if (rows_.size() < maximum_rows_) {
    rows_.push_back(weld);
  }
}

void CrawlerReport::add_truth(const Position& truth) {
  if (!truths_.empty() && truth.stamp <= truths_.back().stamp) {
    truths_.clear();
  }
  if (truths_.size() == kMaximumTruths) {
    truths_.pop_front();
  }
  truths_.push_back(truth);
}

void CrawlerReport::add_position(const Position& position) {
  ++positions_;
  distance_ = position.odometer_distance;
  if (!position.locked) {
    return;
  }
  ++locked_;
  if (!welds_to_lock_) {
    welds_to_lock_ = welds_;
  }
  const auto truth = truth_at(position.stamp);
  if (!truth) {
    return;
  }
  if (truth->joint != position.joint) {
    const Position& upper = truth->joint > position.joint ? *truth : position;
    const bool neighbours =
        std::max(truth->joint, position.joint) - std::min(truth->joint, position.joint) == 1;
    if (!neighbours || upper.into_joint > kAtWeld) {
      ++compared_;
      ++wrong_joint_;
    }
    return;
  }
  const double error = std::abs(position.into_joint - truth->into_joint);
  ++compared_;
  covered_ += error <= statistics::kNormal95 * position.standard_deviation ? 1 : 0;
  worst_ = std::max(worst_, error);
  ++errors_[static_cast<std::size_t>(std::min(error * 1000.0, static_cast<double>(kBins - 1)))];
}

std::optional<CrawlerReport::Position> CrawlerReport::truth_at(Time stamp) const {
  const auto after =
      std::lower_bound(truths_.begin(), truths_.end(), stamp,
                       [](const Position& truth, Time time) { return truth.stamp < time; });
  if (after == truths_.end() || (after == truths_.begin() && after->stamp != stamp)) {
    return std::nullopt;
  }
  if (after->stamp == stamp) {
    return *after;
  }
  const Position& before = *std::prev(after);
  if (before.joint != after->joint) {
    return std::nullopt;  // it passes a weld in between
  }
  Position truth = *after;
  const double share = to_seconds(stamp - before.stamp) / to_seconds(after->stamp - before.stamp);
  truth.into_joint = before.into_joint + share * (after->into_joint - before.into_joint);
  return truth;
}

double CrawlerReport::quantile(double share) const {
  std::uint64_t total = 0;
  for (const auto count : errors_) {
    total += count;
  }
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below += errors_[bin];
    if (below >= wanted) {
      return static_cast<double>(bin + 1) / 1000.0;
    }
  }
  return worst_;
}

MissionSection CrawlerReport::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "Crawler";
  section.columns = {"weld",       "chainage [m]", "odometer [m]", "standard deviation [m]",
                     "confidence", "probability"};
  for (const Weld& weld : rows_) {
    section.rows.push_back(
        {weld.id.empty() ? MissionCell() : MissionCell(weld.id), rounded_cell(weld.chainage, 1e3),
         rounded_cell(weld.distance, 1e3), rounded_cell(weld.standard_deviation, 1e4),
         rounded_cell(weld.confidence, 1e4), rounded_cell(weld.probability, 1e4)});
  }
  const auto set = [&](const char* name, double value) {
    section.figures[figure_prefix + "crawler_" + name] = value;
  };
  set("distance_m", std::round(distance_ * 1e3) / 1e3);
  set("welds", static_cast<double>(welds_));
  set("welds_recognised", static_cast<double>(recognised_));
  set("positions", static_cast<double>(positions_));
  set("positions_locked", static_cast<double>(locked_));
  if (welds_to_lock_) {
    set("welds_to_lock", static_cast<double>(*welds_to_lock_));
  } else {
    section.notes.push_back("The position was never locked.");
  }
  if (compared_ > 0) {
    set("wrong_joint", static_cast<double>(wrong_joint_));
    if (compared_ > wrong_joint_) {
      set("in_joint_p95_m", quantile(0.95));
      set("in_joint_worst_m", std::round(worst_ * 1e4) / 1e4);
    }
    set("coverage95_percent",
        std::round(1e4 * static_cast<double>(covered_) / static_cast<double>(compared_)) / 1e2);
    section.notes.push_back(
        "Positions are compared with the truth of the simulation while they are locked.");
  }
  if (welds_ > rows_.size()) {
    section.notes.push_back("The table shows the first " + std::to_string(rows_.size()) + " of " +
                            std::to_string(welds_) + " welds.");
  }
  return section;
}

}  // namespace pipescout::summary
