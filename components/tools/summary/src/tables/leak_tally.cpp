// SPDX-License-Identifier: Apache-2.0
#include "tables/leak_tally.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/validation/number_text.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

using pipescout_msgs::msg::LeakFinding;

Eigen::Vector3d position(const LeakFinding& finding) {
  return {finding.position.x, finding.position.y, finding.position.z};
}

double percent(std::size_t part, std::size_t whole) {
  return rounded(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1e3);
}

/// Of three degrees of freedom; infinite for a covariance that is none.
double normalised_square(const Eigen::Vector3d& error, const LeakFinding& finding) {
  Eigen::Matrix3d covariance;
  for (Eigen::Index i = 0; i < 9; ++i) {
    covariance(i / 3, i % 3) = finding.position_covariance[static_cast<std::size_t>(i)];
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(covariance);
  return factor.info() == Eigen::Success ? error.dot(factor.solve(error))
                                         : std::numeric_limits<double>::infinity();
}

}  // namespace

void LeakTally::add(const pipescout_msgs::msg::LeakDetections& detections) {
  ++pictures_;
  with_pipe_ += detections.pipes.empty() ? 0 : 1;
  with_leak_ += detections.leaks.empty() ? 0 : 1;
  failed_ += detections.fault.empty() ? 0 : 1;
}

void LeakTally::add(const pipescout_msgs::msg::LeakEvent& event) {
  ++events_;
  findings_[event.finding.id] = event.finding;
}

void LeakTally::add_truth(const LeakFinding& leak) {
  truth_[leak.id] = leak;
}

MissionSection LeakTally::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "Leaks";
  section.columns = {"leak",   "state",      "severity",    "x [m]",   "y [m]",
                     "z [m]",  "length [m]", "dT [K]",      "low [K]", "high [K]",
                     "passes", "pictures",   "growth [K/h]"};
  std::uint64_t raised = 0;
  for (const auto& [id, finding] : findings_) {
    raised += finding.state == "raised" ? 1 : 0;
    std::vector<MissionCell> row{count_cell(id), finding.state, finding.severity};
    for (const double coordinate : position(finding)) {
      row.push_back(finding.position_known ? rounded_cell(coordinate, 100) : MissionCell());
    }
    row.insert(row.end(), {rounded_cell(finding.length, 100), rounded_cell(finding.delta, 10),
                           rounded_cell(finding.delta_low, 10),
                           rounded_cell(finding.delta_high, 10), count_cell(finding.passes),
                           count_cell(finding.frames), rounded_cell(finding.delta_growth, 10)});
    section.rows.push_back(std::move(row));
  }
  const auto set = [&](const std::string& name, std::uint64_t value) {
    section.figures[figure_prefix + name] = static_cast<double>(value);
  };
  set("leak_pictures", pictures_);
  set("leak_pictures_with_pipe", with_pipe_);
  set("leak_pictures_with_leak", with_leak_);
  set("leak_pictures_failed", failed_);
  set("leaks_raised", raised);
  if (!truth_.empty()) {
    add_figures_of_truth(section, figure_prefix);
  }
  return section;
}

void LeakTally::add_figures_of_truth(MissionSection& section, const std::string& prefix) const {
  const double ellipsoid_95 = statistics::chi_square_quantile(0.95, 3);
  std::vector<double> errors;
  std::size_t covered = 0;
  std::size_t found = 0;
  std::size_t wrong = 0;
  std::vector<std::uint64_t> taken;
  for (const auto& [id, finding] : findings_) {
    if (finding.state != "raised") {
      continue;
    }
    std::optional<std::uint64_t> nearest;
    Eigen::Vector3d error = Eigen::Vector3d::Constant(kSame);
    for (const auto& [true_id, leak] : truth_) {
      const Eigen::Vector3d away = position(finding) - position(leak);
      if (finding.position_known && away.norm() < std::min(kSame, error.norm()) &&
          std::ranges::find(taken, true_id) == taken.end()) {
        nearest = true_id;
        error = away;
      }
    }
    if (!nearest) {
      ++wrong;
      continue;
    }
    ++found;
    taken.push_back(*nearest);
    errors.push_back(error.norm());
    covered += normalised_square(error, finding) <= ellipsoid_95 ? 1 : 0;
  }
  section.figures[prefix + "leaks_found_percent"] = percent(found, truth_.size());
  section.figures[prefix + "leaks_false"] = static_cast<double>(wrong);
  if (!errors.empty()) {
    section.figures[prefix + "leak_position_worst_m"] = *std::ranges::max_element(errors);
    section.figures[prefix + "leak_in_ellipsoid_percent"] = percent(covered, errors.size());
  }
  for (const auto& [id, leak] : truth_) {
    if (std::ranges::find(taken, id) == taken.end()) {
      section.notes.push_back("Not found: the true leak " + std::to_string(id) + " at x " +
                              validation::number_text(rounded(leak.position.x, 10)) + " m.");
    }
  }
}

}  // namespace pipescout::summary
