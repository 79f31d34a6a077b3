// SPDX-License-Identifier: Apache-2.0
#include "tables/estimator_report.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/statistics/chi_square.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kSourcesFollowed = 32;

double percent(std::uint64_t part, std::uint64_t whole) {
  return rounded(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1e2);
}

}  // namespace

void EstimatorReport::add_estimate(const Estimate& estimate) {
  ++estimates_;
  pairing_.add_estimate(estimate, [this](const Estimate& known, const geometry::SE3& truth) {
    compare(known, truth);
  });
}

void EstimatorReport::add_truth(Time stamp, const geometry::SE3& T_map_base) {
  pairing_.add_truth(stamp, T_map_base, [this](const Estimate& known, const geometry::SE3& truth) {
    compare(known, truth);
  });
}

void EstimatorReport::compare(const Estimate& estimate, const geometry::SE3& truth) {
  Error result;
  result.error.head<3>() = estimate.T_map_base.translation() - truth.translation();
  result.error.tail<3>() = (estimate.T_map_base.rotation() * truth.rotation().inverse()).log();
  const Eigen::Matrix3d of_position = estimate.covariance.topLeftCorner<3, 3>();
  result.position_nees = of_position.llt().matrixL().solve(result.error.head<3>()).squaredNorm();
  result.pose_nees = estimate.covariance.llt().matrixL().solve(result.error).squaredNorm();
  position_.add(result.error.head<3>().norm());
  orientation_.add(result.error.tail<3>().norm());
  static const double ellipsoid_95 = statistics::chi_square_quantile(0.95, 3);
  in_ellipsoid_ += result.position_nees <= ellipsoid_95 ? 1 : 0;
  sum_of_position_nees_ += result.position_nees;
  sum_of_pose_nees_ += result.pose_nees;
  use_(estimate, result);
}

std::vector<std::size_t> EstimatorReport::add_state(const State& state) {
  follow_phase(state);
  const bool runs = state.phase == "running" || state.phase == "coasting";
  keyframes_ += runs ? 1 : 0;
  std::vector<std::size_t> changed;
  for (std::size_t k = 0; k < state.source.size(); ++k) {
    auto found = sources_.find(state.source[k]);
    if (found == sources_.end()) {
      if (sources_.size() == kSourcesFollowed) {
        continue;
      }
      found = sources_.try_emplace(state.source[k]).first;
    }
    Source& source = found->second;
    if (source.state != state.source_state[k]) {
      source.state = state.source_state[k];
      changed.push_back(k);
    }
    source.trusted += runs && source.state == "trusted" ? 1 : 0;
    source.accepted.said(state.source_accepted[k]);
    source.gated.said(state.source_gated[k]);
    source.held.said(state.source_held[k]);
    source.refused.said(state.source_refused[k]);
  }
  return changed;
}

void EstimatorReport::follow_phase(const State& state) {
  const Time stamp = from_message(state.header.stamp);
  // Before its first message an estimator knows no time.
  if (!first_state_ && stamp != Time{}) {
    first_state_ = stamp;
  }
  if (!until_running_ && first_state_ && state.phase == "running") {
    until_running_ = stamp - *first_state_;
  }
  waits_for_ = state.waits_for;
  const std::uint64_t before = restarts_.total();
  restarts_.said(state.restarts);
  if (restarts_.total() > before) {
    restart_reason_ = state.restart_reason;
  }
}

MissionSection EstimatorReport::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "State estimator";
  const auto set = [&](const std::string& name, double value) {
    section.figures[figure_prefix + "estimator_" + name] = value;
  };
  set("estimates", static_cast<double>(estimates_));
  set("keyframes", static_cast<double>(keyframes_));
  set("restarts", static_cast<double>(restarts_.total()));
  if (until_running_) {
    set("time_until_running_s", rounded(to_seconds(*until_running_), 1e3));
  }
  for (const auto& [name, source] : sources_) {
    set(name + "_accepted", static_cast<double>(source.accepted.total()));
    set(name + "_gated", static_cast<double>(source.gated.total()));
  }
  if (position_.count() > 0) {
    add_error_figures(set);
  }
  add_table(section);
  add_notes(section);
  return section;
}

void EstimatorReport::add_error_figures(
    const std::function<void(const std::string&, double)>& set) const {
  const auto count = static_cast<double>(position_.count());
  set("position_rmse_m", position_.root_mean_square());
  set("position_p95_m", position_.quantile(0.95));
  set("position_worst_m", position_.largest());
  set("orientation_rmse_deg", orientation_.root_mean_square() / kDegree);
  set("in_ellipsoid_percent", percent(in_ellipsoid_, position_.count()));
  set("position_nees", rounded(sum_of_position_nees_ / count, 1e4));
  set("pose_nees", rounded(sum_of_pose_nees_ / count, 1e4));
}

void EstimatorReport::add_table(MissionSection& section) const {
  section.columns = {"source", "state", "accepted", "gated", "held", "refused", "trusted [%]"};
  for (const auto& [name, source] : sources_) {
    section.rows.push_back(
        {name, source.state, count_cell(source.accepted.total()), count_cell(source.gated.total()),
         count_cell(source.held.total()), count_cell(source.refused.total()),
         keyframes_ > 0 ? MissionCell(percent(source.trusted, keyframes_)) : MissionCell()});
  }
}

void EstimatorReport::add_notes(MissionSection& section) const {
  if (!until_running_ && first_state_) {
    section.notes.push_back("The estimator did not start; it waits for: " + waits_for_ + ".");
  }
  if (estimates_ > 0) {
    section.notes.push_back(
        position_.count() > 0
            ? "Errors of " + std::to_string(position_.count()) +
                  " estimates compared with the truth of the simulation. A consistent estimator "
                  "has 95 % of them in its ellipsoid, a position NEES of 3 and a pose NEES of 6."
            : "No ground truth is available at the times of the estimates.");
  }
  if (restarts_.total() > 0) {
    section.notes.push_back("The state was reset or discarded " +
                            std::to_string(restarts_.total()) +
                            (restarts_.total() == 1 ? " time" : " times") +
                            ", the last time for: " + restart_reason_ + ".");
  }
}

}  // namespace pipescout::summary
