// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/arm_study/arm_drive.hpp"
#include "pipescout/leak_study/campaign.hpp"
#include "pipescout/leak_study/rack_inspection.hpp"
#include "pipescout/leak_study/roc.hpp"
#include "pipescout/tracking_study/recording.hpp"

/// Tables of the papers and figures of our own, computed anew. tables.cpp lists
/// them.
namespace pipescout::reproduce {

struct Reproduction {
  nlohmann::json figures = nlohmann::json::object();  ///< name to number
  nlohmann::json rows = nlohmann::json::array();
  nlohmann::json seeds = nlohmann::json::array();  ///< of the random numbers used, if any
};

struct ReproduceOptions {
  static constexpr std::size_t kAllSeeds = 20;
  std::size_t seeds = kAllSeeds;  ///< how many are simulated, at least 1
  /// The first of them. Development uses those up to 999; the command takes those of its revision.
  std::uint64_t seed_base = 1001;
  /// Only this one of the table's parts; empty: all.
  std::string part{};
  /// How many trials there are of each figure that counts trials; not set: as many as the table
  /// says.
  std::optional<std::size_t> trials{};
  /// Folder of the real data, which must be there. Empty: see
  /// `default_data_folder`.
  std::string data{};
  /// Where long work says how far it is; null: nowhere.
  std::ostream* progress = nullptr;
  bool progress_on_terminal = false;  ///< that line can be rewritten
};

struct ReproducibleTable {
  std::string_view name;
  std::string_view description;  ///< one line
  bool simulates;                ///< seeds and data mean something to it
  /// Computes the table and prints it beside the paper's. Throws std::exception
  /// when its data is missing.
  Reproduction (*reproduce)(const ReproduceOptions& options, std::ostream& out);
  /// It can be computed part by part, and with fewer trials; empty: only as a whole.
  std::span<const std::string_view> parts{};
};

inline constexpr std::array<std::string_view, 8> kRackParts{
    "features", "images", "noise", "offsets", "shapes", "bodies", "cameras", "leaks"};

[[nodiscard]] std::span<const ReproducibleTable> reproducible_tables();

/// The folder that $PIPESCOUT_SHARED_DATA names, else ../shared/data; empty
/// when it is not there.
[[nodiscard]] std::string default_data_folder();

/// `count` seeds from `options.seed_base` on.
[[nodiscard]] std::vector<std::uint64_t> seeds_of(const ReproduceOptions& options,
                                                  std::size_t count);

/// The first seed of a revision of the sources, its hash in hexadecimal digits: another one for
/// each, at least 1000, so that nobody can have tuned to what follows from it. Nothing for a text
/// that does not begin with 8 such digits.
[[nodiscard]] std::optional<std::uint64_t> seed_base_of(std::string_view revision);

/// How much is simulated for the figures of work in a pipe, for each seed.
struct InPipeExtent {
  double run_length = 10'000.0;     ///< m, of a crawler that positions itself
  std::size_t joints = 1000;        ///< of its pipe
  std::size_t double_slips = 20;    ///< of one run, when they are scored
  double detector_length = 2000.0;  ///< m, at 12 dB
  double curve_length = 1000.0;     ///< m, at each other signal-to-noise ratio
  std::size_t elbows = 50;          ///< bends in each pipe, by each rule
  std::size_t bends = 30;           ///< of one run
};

/// How much is flown over rendered racks, for each seed.
struct RackImageExtent {
  std::size_t largest_seeds = 10;     ///< however many are asked for: rendering takes long
  double inspection = 60;             ///< s
  double clutter = 15;                ///< s in clutter that comes in flight
  std::size_t clutter_starts = 4;     ///< flights that begin in clutter
  double clutter_start = 5;           ///< s of each of them
  double sparse = 30;                 ///< s, at 6 Hz
  double along = 8;                   ///< m, one way along the pipes
  double plain = 10;                  ///< s over plain paint
  double before_loss = 3;             ///< s
  double after_loss = 2;              ///< s
  std::size_t places = 2;             ///< where wrong starts are tried
  std::size_t trials = 25;            ///< at each place, of wrong first poses and of predictions
  double noise = 12;                  ///< s of each flight in noise, of which there are 20
  std::size_t misplaced = 1000;       ///< rack files with pipes up to 6 cm from their places
  std::size_t misplaced_far = 500;    ///< the same up to 25 cm
  std::size_t misplaced_places = 20;  ///< where they are tried
  std::size_t figure_8 = 8;           ///< flights of Figure 8
  std::size_t shaped = 20;            ///< rack files with pipes of other shapes, of each renderer
  double shaped_duration = 10;        ///< s over each of them
  double bodies = 20;                 ///< s over a rack on which more lies than its model has
  double cameras = 20;                ///< s with each of the cameras that are compared
};

/// How much is simulated for the figures over a pipe rack.
struct RackExtent {
  std::size_t every_frame = 1;           ///< of Table I: only each n-th
  std::size_t first_pose_trials = 1000;  ///< in all
  RackImageExtent images{};
  std::size_t largest_leak_seeds = 20;  ///< flights with hot spots, however many are asked for
  leak_study::RackInspectionSettings leaks{};
};

/// How much is driven, flown and crawled for the figures of the state estimator, for each seed.
struct EstimatorExtent {
  double duration = 180;       ///< s, of a run
  double outage = 60;          ///< s, without GPS
  double loss_duration = 120;  ///< s, of a run with losses
  /// Of the runs with losses, however many are asked for: 66 of each seed.
  std::size_t largest_loss_seeds = 10;
};

/// How many patrols along collectors there are, for each seed.
struct LeaksExtent {
  std::size_t largest_seeds = 5;  ///< however many are asked for: five sets of sequences
  leak_study::CampaignSettings campaign{};
  /// Where the camera is told wrong radiometry; the same with automatic gain is run too. Shorter
  /// than the campaign, with more in it.
  leak_study::CampaignSettings world{.sequences = 24,
                                     .faint_leaks = 12,
                                     .near_leaks = 12,
                                     .other_leaks = 18,
                                     .decoys = 30,
                                     .drawn_radiometry = true};
  leak_study::RocSettings roc{};
};

/// How many pictures a pipe is tracked through, and how far it is kept in view.
struct TrackingExtent {
  std::size_t largest_seeds = 5;  ///< of Table 1, however many are asked for
  std::size_t sequences = 10;     ///< of Table 1, for each seed
  tracking_study::RecordingSettings recording{};
  std::size_t long_sequences = 100;  ///< in all
  std::size_t long_frames = 2000;
  std::size_t crossings = 200;  ///< of two tubes, in all
  std::vector<std::size_t> particles{100, 300, 1000, 3000, 10'000, 30'000, 100'000};
  arm_study::DriveSettings arm{};
  /// Of each of two seeds: inspected with and without tracker and arm, over the hills of `arm`.
  leak_study::CampaignSettings inspection{
      .sequences = 6, .faint_leaks = 6, .other_leaks = 30, .decoys = 24, .length = 300};
};

/// How much is planned for the figures of navigation.
struct NavigationExtent {
  std::uint32_t road_side = 316;  ///< crossings along each side of the road graph
  std::size_t routes = 200;       ///< in all
  std::size_t tours = 50;         ///< of drawn plants, in all
  std::size_t paths = 5;          ///< on each map, for each seed
  double deadline = 0.150;        ///< s, of a path
  std::size_t missions = 100;     ///< in all
  std::size_t inspections = 20;   ///< tours that are driven, in all
};

// The tables.
Reproduction reproduce_odometry(const ReproduceOptions& options, std::ostream& out);
Reproduction reproduce_in_pipe(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_in_pipe(const ReproduceOptions& options, const InPipeExtent& extent,
                               std::ostream& out);

Reproduction reproduce_rack(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_rack(const ReproduceOptions& options, const RackExtent& extent,
                            std::ostream& out);

Reproduction reproduce_estimator(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_estimator(const ReproduceOptions& options, const EstimatorExtent& extent,
                                 std::ostream& out);

Reproduction reproduce_leaks(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_leaks(const ReproduceOptions& options, const LeaksExtent& extent,
                             std::ostream& out);

Reproduction reproduce_tracking(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_tracking(const ReproduceOptions& options, const TrackingExtent& extent,
                                std::ostream& out);

Reproduction reproduce_navigation(const ReproduceOptions& options, std::ostream& out);
/// The same with less, for tests.
Reproduction reproduce_navigation(const ReproduceOptions& options, const NavigationExtent& extent,
                                  std::ostream& out);

}  // namespace pipescout::reproduce
