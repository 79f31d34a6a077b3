// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/crawler_score.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/normal.hpp"

namespace pipescout::odometry_study {
namespace {

constexpr double kTolerance = 0.15;  // m

/// The slip that a flag at this path can be about, or the number of slips.
std::size_t slip_behind(const CrawlerRun& run, double path, double joint, double reach) {
  for (std::size_t i = 0; i < run.double_slips.size(); ++i) {
    // Its first weld may lie within the slip.
    if (path > run.double_slips[i].end - joint && path < run.double_slips[i].end + reach) {
      return i;
    }
  }
  return run.double_slips.size();
}

}  // namespace

CrawlerScore score_run(const CrawlerRun& run, odometry::WeldPositioning& positioning,
                       const CrawlerRunSettings& settings) {
  CrawlerScore score;
  const double reach = 5.0 * settings.joint_length;
  const auto& slips = run.double_slips;
  std::vector<bool> detected(slips.size(), false);
  std::vector<std::size_t> welds_since(slips.size(), 0);
  std::vector<bool> hidden(slips.size(), false);
  double locked_at = 0.0;
  for (const CrawlerRunEvent& event : run.events) {
    const auto& estimate = event.is_weld   ? positioning.add_weld(event.weld)
                           : event.is_bend ? positioning.add_bend(event.bend)
                                           : positioning.add_increment(event.increment);
    if (event.is_weld && !event.spurious) {
      for (std::size_t i = 0; i < slips.size(); ++i) {
        welds_since[i] += event.path > slips[i].end + settings.detector_lag ? 1 : 0;
      }
    }
    if (estimate.double_slip_detected) {
      const std::size_t slip = slip_behind(run, event.path, settings.joint_length, reach);
      if (slip < slips.size()) {
        detected[slip] = true;
      } else {
        ++score.false_slips;
      }
    }
    if (event.is_bend) {
      continue;  // where the increment before it was
    }
    score.right_at_end = false;
    score.events_since_lock += score.ever_locked || estimate.locked ? 1 : 0;
    if (!estimate.locked) {
      continue;
    }
    if (!score.ever_locked) {
      score.ever_locked = true;
      score.lock_joints = event.joints_passed;
      locked_at = event.path;
    }
    const int weld = run.weld_of_tally[estimate.joint];
    if (weld < 0) {
      ++score.wrong_joint;
      continue;
    }
    const double error = std::abs(run.welds[static_cast<std::size_t>(weld)] +
                                  estimate.distance_into_joint - event.place);
    const bool inside = error <= statistics::kNormal95 * std::sqrt(estimate.covariance(0, 0));
    ++score.locked_events;
    score.inside_band += inside ? 1 : 0;
    score.errors.push_back(error);
    score.scale_errors.push_back(std::abs(estimate.scale - event.scale));
    score.right_at_end = error < kTolerance;
    const bool in_it = event.place >= run.welds[static_cast<std::size_t>(weld)] &&
                       event.place < run.welds[static_cast<std::size_t>(weld) + 1];
    score.wrong_joint += !in_it && error > kTolerance && !inside ? 1 : 0;
    for (std::size_t i = 0; i < slips.size(); ++i) {
      // The next slip's own error is none of this one's.
      if (!inside && error > kTolerance && welds_since[i] >= 2 &&
          event.path < slips[i].end + reach &&
          (i + 1 == slips.size() || event.path < slips[i + 1].end - settings.joint_length)) {
        hidden[i] = true;
      }
    }
  }
  if (!score.ever_locked) {
    score.lock_joints = run.events.back().joints_passed;
  }
  for (std::size_t i = 0; i < slips.size(); ++i) {
    if (slips[i].lost >= kTolerance && slips[i].end > locked_at + 2.0 * settings.joint_length &&
        slips[i].end < run.events.back().path - reach) {
      ++score.slips;
      score.slips_detected += detected[i] ? 1 : 0;
      score.slips_said += detected[i] || slips[i].doubted ? 1 : 0;
      score.slips_doubted += slips[i].doubted ? 1 : 0;
      score.slips_hidden += hidden[i] ? 1 : 0;
    }
  }
  score.locks_lost = positioning.counts().locks_lost;
  return score;
}

odometry::WeldPositioningStart known_start(const CrawlerRun& run,
                                           const CrawlerRunSettings& settings) {
  const auto weld = std::upper_bound(run.welds.begin(), run.welds.end(), run.start) - 1;
  return {.joint_known = true,
          .joint = static_cast<std::size_t>(weld - run.welds.begin()),
          .distance = run.start - *weld,
          .orientation = settings.backward ? odometry::Orientation::kBackward
                                           : odometry::Orientation::kForward};
}

}  // namespace pipescout::odometry_study
