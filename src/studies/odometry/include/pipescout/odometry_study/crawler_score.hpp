// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/odometry_study/crawler_run.hpp"

namespace pipescout::odometry_study {

/// Score of `WeldPositioning` on one run. Errors are those of the position by joint and distance
/// into it, at every event while locked.
struct CrawlerScore {
  std::size_t lock_joints = 0;  ///< welds passed, detected or not, until the first lock; or all
  bool ever_locked = false;
  std::size_t events_since_lock = 0;  ///< since the first lock, locked or not
  std::size_t locked_events = 0;
  std::size_t inside_band = 0;  ///< error within 1.96 stated standard deviations
  std::size_t wrong_joint = 0;  ///< not the joint it is in, nor within 0.15 m of the right one
  std::vector<double> errors;   ///< m, absolute
  std::vector<double> scale_errors;
  std::size_t slips = 0;           ///< double slips that lost 0.15 m or more, away from the ends
  std::size_t slips_detected = 0;  ///< by the spacing of the welds, within 5 joints
  std::size_t slips_doubted = 0;   ///< by the fusion itself
  std::size_t slips_said = 0;      ///< one or the other
  std::size_t slips_hidden = 0;    ///< error of 0.15 m or more and outside the band, after the
                                   ///< second weld seen since the slip
  std::size_t false_slips = 0;     ///< false detections
  std::size_t locks_lost = 0;
  bool right_at_end = false;  ///< locked, and the error below 0.15 m
};

/// Runs a new positioning on the events of the run.
[[nodiscard]] CrawlerScore score_run(const CrawlerRun& run, odometry::WeldPositioning& positioning,
                                     const CrawlerRunSettings& settings);

/// Initial position of a run with known joint and orientation.
[[nodiscard]] odometry::WeldPositioningStart known_start(const CrawlerRun& run,
                                                         const CrawlerRunSettings& settings);

}  // namespace pipescout::odometry_study
