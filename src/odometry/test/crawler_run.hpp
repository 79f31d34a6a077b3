// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry::test {

/// A crawler with three wheels, its fusion and its weld detector, as events with ground truth.
struct CrawlerRunSettings {
  std::size_t joints = 1000;          ///< of the pipe
  double run_length = 10'000.0;       ///< m, true
  double joint_length = 12.0;         ///< m
  double joint_spread = 0.01;         ///< standard deviation, of the length
  double tally_sigma = 0.01;          ///< m, per length
  bool backward = false;              ///< faces towards weld 0
  double step = 0.5;                  ///< m, one fusion window
  double wheel_noise = 0.004;         ///< m per square root of a metre, each wheel
  double stated_noise_part = 1.0;     ///< of its standard deviation, what the fusion is told
  double radius_error = 0.002;        ///< standard deviation, each wheel
  double common_scale_error = 0.005;  ///< standard deviation, all wheels
  double wear = 0.02;                 ///< all wheels read more by this at the end of the run
  double wear_difference = 0.1;       ///< of the wear, between wheels
  double resolution = 0.001;          ///< m, encoder
  double slip_every = 50.0;           ///< m, on average, one wheel
  double slip_length = 5.0;           ///< m, at most
  double slip_most = 0.30;            ///< part that is lost, at most
  double missed = 0.02;
  double spurious = 0.01;              ///< per joint
  double weld_sigma = 0.01;            ///< m, of a detection
  double detector_lag = 0.3;           ///< m, true, after the weld
  std::size_t double_slips = 0;        ///< two wheels together, evenly spread over the run
  double double_slip_least = 0.15;     ///< part that is lost
  std::size_t reversals = 0;           ///< evenly spread; 5 to 40 m back
  bool detects_on_old_ground = false;  ///< a weld is reported each time it is passed
  std::size_t wrong_lengths = 0;       ///< joints of the tally that are wrong by 0.3 to 1 m
  std::size_t missing_joints = 0;      ///< joints of the pipe that the tally lacks
  std::size_t extra_joints = 0;        ///< joints of the tally that the pipe lacks
};

struct CrawlerRunEvent {
  bool is_weld = false;
  bool spurious = false;
  OdometerIncrement increment;
  WeldSighting weld;
  double place = 0.0;             ///< m, true, from weld 0
  double scale = 1.0;             ///< true metres per metre of the wheels' mean reading
  std::size_t joints_passed = 0;  ///< true, since the start
};

struct CrawlerRun {
  std::vector<TallyJoint> tally;
  std::vector<double> welds;  ///< m, true places; welds[i] is weld i of the PIPE
  /// Index in `welds` of weld i of the tally, or -1 where the pipe has none.
  std::vector<int> weld_of_tally;
  std::vector<CrawlerRunEvent> events;
  std::vector<double> double_slip_lost;  ///< m, by each double slip
  std::vector<double> double_slip_end;   ///< m, true place where it ends
  double start = 0.0;                    ///< m, true place
};

[[nodiscard]] CrawlerRun simulate_crawler_run(const CrawlerRunSettings& settings,
                                              std::uint64_t seed);

}  // namespace pipescout::odometry::test
