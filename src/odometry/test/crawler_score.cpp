// SPDX-License-Identifier: Apache-2.0
#include "crawler_score.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::test {
namespace {

constexpr double kTolerance = 0.15;  // m
constexpr double kBand = 1.959963984540054;

/// The slip that a flag at this path can be about, or the number of slips.
std::size_t slip_behind(const CrawlerRun& run, double path, double reach) {
  for (std::size_t i = 0; i < run.double_slip_end.size(); ++i) {
    // Its first weld may lie within the slip.
    if (path > run.double_slip_end[i] - 12.0 && path < run.double_slip_end[i] + reach) {
      return i;
    }
  }
  return run.double_slip_end.size();
}

}  // namespace

CrawlerScore score_run(const CrawlerRun& run, WeldPositioning& positioning,
                       const CrawlerRunSettings& settings) {
  CrawlerScore score;
  const double reach = 5.0 * settings.joint_length;
  std::vector<bool> detected(run.double_slip_end.size(), false);
  std::vector<std::size_t> welds_since(run.double_slip_end.size(), 0);
  std::vector<bool> hidden(run.double_slip_end.size(), false);
  double path = 0.0;
  double locked_at = 0.0;
  for (const CrawlerRunEvent& event : run.events) {
    const WeldPositionEstimate& estimate = event.is_weld
                                               ? positioning.add_weld(event.weld)
                                               : positioning.add_increment(event.increment);
    path += event.is_weld ? 0.0 : settings.step;
    if (event.is_weld && !event.spurious) {
      for (std::size_t i = 0; i < welds_since.size(); ++i) {
        welds_since[i] += path > run.double_slip_end[i] + settings.detector_lag ? 1 : 0;
      }
    }
    if (estimate.double_slip_detected) {
      const std::size_t slip = slip_behind(run, path, reach);
      if (slip < detected.size()) {
        detected[slip] = true;
      } else {
        ++score.false_slips;
      }
    }
    score.right_at_end = false;
    if (!estimate.locked) {
      continue;
    }
    if (!score.ever_locked) {
      score.ever_locked = true;
      score.lock_joints = event.joints_passed;
      locked_at = path;
    }
    const int weld = run.weld_of_tally[estimate.joint];
    if (weld < 0) {
      ++score.wrong_joint;
      continue;
    }
    const double error = std::abs(run.welds[static_cast<std::size_t>(weld)] +
                                  estimate.distance_into_joint - event.place);
    const bool inside = error <= kBand * std::sqrt(estimate.covariance(0, 0));
    ++score.locked_events;
    score.inside_band += inside ? 1 : 0;
    score.errors.push_back(error);
    score.scale_errors.push_back(std::abs(estimate.scale - event.scale));
    score.right_at_end = error < kTolerance;
    const bool in_it = event.place >= run.welds[static_cast<std::size_t>(weld)] &&
                       event.place < run.welds[static_cast<std::size_t>(weld) + 1];
    score.wrong_joint += !in_it && error > kTolerance && !inside ? 1 : 0;
    for (std::size_t i = 0; i < hidden.size(); ++i) {
      // The next slip's own error is none of this one's.
      if (!inside && error > kTolerance && welds_since[i] >= 2 &&
          path < run.double_slip_end[i] + reach &&
          (i + 1 == hidden.size() || path < run.double_slip_end[i + 1] - 12.0)) {
        hidden[i] = true;
      }
    }
  }
  if (!score.ever_locked) {
    score.lock_joints = run.events.back().joints_passed;
  }
  for (std::size_t i = 0; i < detected.size(); ++i) {
    if (std::abs(run.double_slip_lost[i]) >= kTolerance &&
        run.double_slip_end[i] > locked_at + 2.0 * settings.joint_length &&
        run.double_slip_end[i] < path - reach) {
      ++score.slips;
      score.slips_detected += detected[i] ? 1 : 0;
      score.slips_hidden += hidden[i] ? 1 : 0;
    }
  }
  score.locks_lost = positioning.counts().locks_lost;
  return score;
}

double quantile(std::vector<double> values, double part) {
  const auto index = static_cast<std::ptrdiff_t>(
      std::min(part * static_cast<double>(values.size()), static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

}  // namespace pipescout::odometry::test
