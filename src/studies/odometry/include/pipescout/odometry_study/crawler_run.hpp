// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry_study {

/// A simulated crawler with some wheels in a pipe of joints, its wheels fused by `OdometerStream`,
/// and a weld detector that is simulated by its detections only. It stops about every 100 m.
struct CrawlerRunSettings {
  // The pipe and its tally.
  std::size_t joints = 1000;
  double joint_length = 12.0;  ///< m
  double joint_spread = 0.01;  ///< standard deviation, of the length
  double tally_sigma = 0.01;   ///< m, per length
  double wrong_lengths = 0.0;  ///< share of the tally's lengths that are wrong by 0.5 to 1 m
  double missing_joints = 0.0;
  double extra_joints = 0.0;
  // The drive.
  double run_length = 10'000.0;    ///< m, true, below joints * joint_length
  bool backward = false;           ///< faces towards weld 0
  double reverse_share = 0.0;      ///< share of the stops after which it reverses, ...
  double reverse_distance = 15.0;  ///< m, on average
  // The wheels.
  std::size_t wheels = 3;             ///< [3, kMaxOdometers], evenly around the circumference
  double sample_period = 0.1;         ///< s, of each wheel
  double wheel_noise = 0.004;         ///< m per square root of a metre, each wheel
  double stated_noise_part = 1.0;     ///< share of its standard deviation used by the fusion
  double radius_error = 0.002;        ///< standard deviation, each wheel
  double common_scale_error = 0.005;  ///< standard deviation, all wheels
  double wear = 0.02;                 ///< all wheels read more by this at the end of the run
  double wear_difference = 0.1;       ///< of the wear, standard deviation between wheels
  double slip_every = 50.0;           ///< m, on average, one wheel at a time; above 0
  double slip_longest = 5.0;          ///< m, above 0.5
  double slip_most = 0.30;            ///< largest share that is lost
  std::size_t double_slips = 0;       ///< two wheels alike, evenly spread over the run
  double double_slip_least = 0.15;    ///< part that is lost
  // What the pipe has besides straight joints, evenly spread over the run. Half of the bends are
  // those into and out of a vertical piece.
  std::size_t bends = 0;
  std::size_t tees = 0;
  double pipe_diameter = 1.0;     ///< m, inner
  double gravity_slip = 0.002;    ///< share that all wheels lose on a vertical climb
  double clock_error = 0.0175;    ///< rad, standard deviation, each wheel
  double roll_per_metre = 0.005;  ///< rad
  /// m and rad, of the places and angles of the bends as the tally lists them.
  double tally_bend_sigma = 0.1;
  double tally_angle_sigma = 0.03;
  // Their fusion: as `OdometerStreamParameters`. With wheels this precise every relevant slip is
  // detected within half a metre; looking back would exclude a wheel for some metres after its
  // slip, and the remaining two cannot outvote the next.
  odometry::FusionRule rule = odometry::FusionRule::kConsensus;
  double window_distance = 0.5;
  std::size_t lookback_windows = 0;
  // The weld detector.
  double missed = 0.02;
  double spurious = 0.01;              ///< per joint
  double weld_sigma = 0.01;            ///< m, of a detection
  double detector_lag = 0.3;           ///< m, after the weld
  bool detects_on_old_ground = false;  ///< a weld is reported at each passage
};

struct CrawlerRunEvent {
  bool is_weld = false;
  bool is_bend = false;
  bool spurious = false;
  odometry::OdometerIncrement increment{};  ///< of an event that is neither weld nor bend
  odometry::WeldSighting weld{};
  odometry::BendSighting bend{};
  // The truth.
  double place = 0.0;             ///< m, from weld 0
  double path = 0.0;              ///< m
  double scale = 1.0;             ///< true metres per metre of the wheels' mean reading
  std::size_t joints_passed = 0;  ///< since the start
};

struct DoubleSlip {
  double begin = 0.0;  ///< m, path
  double end = 0.0;
  double lost = 0.0;  ///< m
  /// The fusion found no consensus during the slip: it detected the error.
  bool doubted = false;
};

struct BendPassage {
  double begin = 0.0;  ///< m, distance since the start of the run
  double end = 0.0;
  double angle = 0.0;  ///< rad
  bool found = false;  ///< with its angle within 10 degrees
};

struct CrawlerRun {
  std::vector<odometry::TallyJoint> tally;
  std::vector<odometry::TallyBend> tally_bends;
  std::vector<double> welds;  ///< m, true places; welds[i] is weld i of the PIPE
  /// Index in `welds` of weld i of the tally, or -1 where the pipe has none.
  std::vector<int> weld_of_tally;
  std::vector<CrawlerRunEvent> events;  ///< an increment each 0.1 m, and the welds
  std::vector<DoubleSlip> double_slips;
  std::vector<BendPassage> bends;
  std::size_t false_bends = 0;  ///< found where there is none
  double start = 0.0;           ///< m, true place
};

/// The same seed gives the same bits. Throws std::invalid_argument as the simulators do.
[[nodiscard]] CrawlerRun simulate_crawler_run(const CrawlerRunSettings& settings,
                                              std::uint64_t seed);

}  // namespace pipescout::odometry_study
