// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/odometry_study/quantile.hpp"
#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/image_trials.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using odometry_study::quantile;
using rack_study::ImageFlightRun;
using rack_study::ImageFlightScore;
using rack_study::ImageFlightSettings;
using rack_study::WrongStartScore;

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// %, in the ellipsoid that should hold 95.
double place_covered(const ImageFlightScore& score) {
  return percent(score.position_covered, score.with_pose);
}

ImageFlightScore pooled(const std::vector<ImageFlightScore>& scores) {
  ImageFlightScore all;
  for (const ImageFlightScore& score : scores) {
    all += score;
  }
  return all;
}

class RackImages {
 public:
  explicit RackImages(RackReproduction& run)
      : options_(run.options),
        extent_(run.extent.images),
        seeds_(seeds_of(options_, std::min(run.seeds.size(), extent_.largest_seeds))),
        rows_(run.rows),
        out_(run.out),
        progress_(run.progress) {}

  void run() {
    out_ << "On images: 720x480 pixels, seeds " << seeds_.front() << " to " << seeds_.back()
         << ", gusts, changing light, blur and noise.\n\n";
    inspect();
    drift();
    fly_into_clutter();
    start_in_clutter();
    fly_plain();
    recover(true);
    recover(false);
    start_wrong();
    fly_sparse();
  }

 private:
  template <class Settings>
  std::vector<ImageFlightRun> fly(const std::string& study, Settings settings_of_seed) {
    return for_each_seed(progress_, study, seeds_, [&](std::uint64_t seed) {
      return rack_study::run_image_flight(settings_of_seed(seed), seed);
    });
  }

  static std::vector<ImageFlightScore> scores(const std::vector<ImageFlightRun>& runs) {
    std::vector<ImageFlightScore> result;
    result.reserve(runs.size());
    for (const ImageFlightRun& run : runs) {
      result.push_back(rack_study::score_flight(run.frames));
    }
    return result;
  }

  static ImageFlightSettings inspection(double duration, std::uint64_t seed) {
    ImageFlightSettings settings;
    settings.scene.model = rack_study::rack_on_beams();
    settings.flight.duration = duration;
    settings.way_points = rack_study::inspection_way_points(duration, seed);
    return settings;
  }

  /// Names of figures; an empty one: a row only.
  struct Names {
    std::string tracked{};
    std::string position_median{};
    std::string rotation_median{};
    std::string position_95{};
    std::string rotation_95{};
    Target tracked_target{.least = 100.0};
  };

  void add_flights(const std::string& study, const std::vector<ImageFlightRun>& runs,
                   const Names& names, const std::vector<Measure>& more = {}) {
    const auto per_seed = scores(runs);
    const ImageFlightScore all = pooled(per_seed);
    const auto errors = [&](auto field, double part, double factor) {
      return std::pair{factor * error_quantile(all.*field, part),
                       each(per_seed, [&](const auto& score) {
                         return factor * error_quantile(score.*field, part);
                       })};
    };
    const auto position_median = errors(&ImageFlightScore::position_errors, 0.5, 1.0);
    const auto rotation_median = errors(&ImageFlightScore::rotation_errors, 0.5, kDegrees);
    const auto position_95 = errors(&ImageFlightScore::position_errors, 0.95, 1.0);
    const auto rotation_95 = errors(&ImageFlightScore::rotation_errors, 0.95, kDegrees);
    const auto losses = each(runs, [](const auto& run) { return run.tracker.losses; });
    std::vector<Measure> measures{
        {"images with a pose, %", all.with_pose_percent(),
         each(per_seed, &ImageFlightScore::with_pose_percent), names.tracked_target, names.tracked},
        {"position error, median, m", position_median.first, position_median.second, at_most(0.005),
         names.position_median},
        {"position error, 95 %, m", position_95.first, position_95.second, at_most(0.015),
         names.position_95},
        {"orientation error, median, degrees", rotation_median.first, rotation_median.second,
         at_most(0.08), names.rotation_median},
        {"orientation error, 95 %, degrees", rotation_95.first, rotation_95.second, at_most(0.2),
         names.rotation_95},
        {"poses with an error above 3 cm or 1 degree", static_cast<double>(all.wrong),
         each(per_seed, &ImageFlightScore::wrong), kNone},
        {"truth inside the 95 % ellipsoid of the position, %", place_covered(all),
         each(per_seed, place_covered), kLargeIsGood},
        {"truth inside that of the pose, %", percent(all.pose_covered, all.with_pose),
         each(per_seed,
              [](const auto& score) { return percent(score.pose_covered, score.with_pose); }),
         kLargeIsGood},
        {"times lost", sum(losses), losses, kSmallIsGood}};
    measures.insert(measures.end(), more.begin(), more.end());
    rows_.add_study(study, measures);
  }

  void inspect() {
    const std::string study = "Rack on beams, way-points, " + seconds(extent_.inspection);
    add_flights(
        study, fly(study, [&](std::uint64_t seed) { return inspection(extent_.inspection, seed); }),
        {.tracked = "image_tracked_percent",
         .position_median = "image_position_median_m",
         .rotation_median = "image_orientation_median_deg",
         .position_95 = "image_position_p95_m",
         .rotation_95 = "image_orientation_p95_deg",
         .tracked_target = kLargeIsGood});
  }

  static ImageFlightSettings cluttered(double duration, std::uint64_t seed) {
    ImageFlightSettings settings = inspection(duration, seed);
    settings.scene.clutter_share = 0.4;
    return settings;
  }

  /// What share of the contours it is, as measured: the scene draws it piece by piece.
  static Measure clutter_of(const std::vector<ImageFlightRun>& runs) {
    const auto shares = each(runs, [](const auto& run) { return 100 * run.cluttered_share; });
    return {"contours hidden or imitated, measured, %",
            sum(shares) / static_cast<double>(shares.size()), shares, kLargeIsGood};
  }

  void fly_into_clutter() {
    constexpr double kClear = 2;  // s
    const std::string study = "The same, 40 % of the contours hidden or imitated after " +
                              seconds(kClear) + ", for " + seconds(extent_.clutter);
    auto runs = fly(study, [&](std::uint64_t seed) {
      ImageFlightSettings settings = cluttered(kClear + extent_.clutter, seed);
      settings.clutter_begin = kClear;
      return settings;
    });
    for (ImageFlightRun& run : runs) {
      std::erase_if(run.frames, [](const auto& frame) { return frame.time < kClear; });
    }
    add_flights(study, runs, {.tracked = "image_clutter40_tracked_percent"}, {clutter_of(runs)});
  }

  void start_in_clutter() {
    const auto seeds = seeds_of(options_, extent_.clutter_starts * seeds_.size());
    const std::string study = std::to_string(seeds.size()) +
                              " flights that begin in such clutter, " +
                              seconds(extent_.clutter_start);
    const auto runs = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      return rack_study::run_image_flight(cluttered(extent_.clutter_start, seed), seed);
    });
    const auto per_seed = scores(runs);
    const auto flights = each(per_seed, &ImageFlightScore::with_pose_percent);
    const auto wrong = each(per_seed, &ImageFlightScore::wrong);
    std::vector<WrongStartScore> ends;
    for (const ImageFlightRun& run : runs) {
      const rack_study::WrongStartTrial flown{.last = run.frames.back()};
      ends.push_back(rack_study::score_wrong_starts({&flown, 1}));
    }
    add_starts(
        study, ends,
        {.converged = "image_clutter40_started_percent", .silent = "image_clutter40_silent_wrong"},
        {{"images with a pose, %", sum(flights) / static_cast<double>(flights.size()), flights,
          kLargeIsGood},
         {"poses with an error above 3 cm or 1 degree", sum(wrong), wrong, kNone},
         clutter_of(runs)});
  }

  void fly_sparse() {
    const std::string study = "Rack on beams, camera at 6 Hz, " + seconds(extent_.sparse);
    const auto runs = fly(study, [&](std::uint64_t seed) {
      ImageFlightSettings settings = inspection(extent_.sparse, seed);
      settings.flight.frame_rate = 6;
      return settings;
    });
    add_flights(study, runs, {.tracked = "image_6hz_tracked_percent"});
  }

  void drift() {
    constexpr double kFromEnd = 2;      // m: ends of pipes stay out of view
    constexpr double kSpeed = 0.4;      // m/s
    constexpr double kLostTrack = 100;  // %, said of a track that did not last
    constexpr double kAtRest = 4;       // s, at both ends, with the time to speed up and slow down
    const std::string study = "Rack without beams, " + std::to_string(std::lround(extent_.along)) +
                              " m along the pipes, one way";
    const auto runs = fly(study, [&](std::uint64_t) {
      ImageFlightSettings settings;
      settings.scene.model = rack_study::rack_without_beams(extent_.along + 2 * kFromEnd);
      settings.way_points = rack_study::way_points_along(kFromEnd, kFromEnd + extent_.along);
      settings.flight.largest_speed = kSpeed;
      settings.flight.duration = extent_.along / kSpeed + kAtRest;
      return settings;
    });
    const auto drifts = each(runs, [kLostTrack](const auto& run) {
      return std::min(kLostTrack, rack_study::along_drift_percent(run.frames));
    });
    const auto per_seed = scores(runs);
    const ImageFlightScore all = pooled(per_seed);
    rows_.add_study(study, {{"drift along the pipes, worst seed, % of the distance",
                             largest(drifts), drifts, at_most(0.3), "image_along_drift_percent"},
                            {"images with a pose, %", all.with_pose_percent(),
                             each(per_seed, &ImageFlightScore::with_pose_percent), at_least(100.0)},
                            {"truth inside the 95 % ellipsoid of the position, %",
                             place_covered(all), each(per_seed, place_covered), kLargeIsGood}});
  }

  void fly_plain() {
    constexpr double kSpeed = 0.3;     // m/s
    constexpr double kTextured = 2.0;  // m flown before the view is plain
    constexpr double kFromEnd = 2.0;   // m: ends of pipes stay out of view
    constexpr double kHalfView = 1.4;  // m along the pipes, tilted by a gust
    constexpr double kToSpeed = 2.5;   // s until the flight is as fast as that, and to slow down
    const std::string study =
        "Rack without beams, plain paint in view for " + seconds(extent_.plain);
    const double from = kFromEnd + kTextured;
    const double to = from + kSpeed * extent_.plain;
    const auto runs = fly(study, [&](std::uint64_t) {
      ImageFlightSettings settings;
      settings.scene.model = rack_study::rack_without_beams(to + kHalfView + kFromEnd);
      settings.scene.plain = {{.from = from - kHalfView, .to = to + kHalfView}};
      settings.way_points = rack_study::way_points_along(kFromEnd, to);
      settings.flight.largest_speed = kSpeed;
      settings.flight.duration = (to - kFromEnd) / kSpeed + kToSpeed;
      return settings;
    });
    using rack_study::StretchScore;
    std::vector<StretchScore> stretches;
    for (const ImageFlightRun& run : runs) {
      stretches.push_back(rack_study::score_stretch(run.frames, from, to));
    }
    const auto total = [&](auto count) {
      return static_cast<std::size_t>(sum(each(stretches, count)));
    };
    const std::size_t images = total(&StretchScore::images);
    const auto errors = each(stretches, &StretchScore::largest_error);
    const auto first = each(stretches, &StretchScore::first_deviation);
    const auto last = each(stretches, &StretchScore::last_deviation);
    rows_.add_study(
        study,
        {{"truth inside the 95 % ellipsoid of the position, %",
          percent(total(&StretchScore::covered), images),
          each(stretches,
               [](const auto& stretch) { return percent(stretch.covered, stretch.images); }),
          at_least(95.0), "image_plain_10s_covered_percent"},
         {"images with a pose, %", percent(total(&StretchScore::with_pose), images),
          each(stretches,
               [](const auto& stretch) { return percent(stretch.with_pose, stretch.images); }),
          kLargeIsGood},
         {"largest error along the pipes, m", largest(errors), errors, kSmallIsGood},
         {"standard deviation along the pipes, first image, m", quantile(first, 0.5), first,
          kSmallIsGood},
         {"the same, last image, m", quantile(last, 0.5), last, kSmallIsGood}});
  }

  void recover(bool with_odometry) {
    constexpr double kInTime = 1;  // s
    const double duration = extent_.before_loss + 1 + extent_.after_loss;
    const std::string study = std::string("Camera covered, frozen or away for 1 s in flight, ") +
                              (with_odometry ? "with odometry" : "images only");
    const auto runs = fly(study, [&](std::uint64_t seed) {
      ImageFlightSettings settings = inspection(duration, seed);
      constexpr std::uint64_t kKinds = 3;
      settings.loss = {.kind = static_cast<rack_study::Outage>(seed % kKinds),
                       .begin = extent_.before_loss,
                       .duration = 1};
      settings.with_odometry = with_odometry;
      return settings;
    });
    std::vector<rack_study::Recovery> recoveries;
    for (const ImageFlightRun& run : runs) {
      recoveries.push_back(rack_study::score_recovery(run.frames));
    }
    const auto times = each(recoveries, [&](const auto& recovery) {
      return recovery.time.value_or(extent_.after_loss);
    });
    const auto in_time = each(recoveries, [](const auto& recovery) {
      return recovery.time.value_or(2 * kInTime) <= kInTime;
    });
    const auto wrong = each(recoveries, &rack_study::Recovery::wrong);
    const auto declared = each(recoveries, &rack_study::Recovery::declared);
    rows_.add_study(
        study, {{"recovered within 1 s, of " + std::to_string(runs.size()), sum(in_time), in_time,
                 at_least(static_cast<double>(runs.size())),
                 with_odometry ? "image_recoveries" : "image_recoveries_without_odometry"},
                {"time to recover, worst, s", largest(times), times, kSmallIsGood},
                {"declared lost or without a pose", sum(declared), declared, kLargeIsGood},
                {"with a wrong pose at any time", sum(wrong), wrong, kNone}});
  }

  void start_wrong() {
    const auto seeds = seeds_of(options_, extent_.places * seeds_.size());
    const std::size_t all_trials = 2 * extent_.trials * seeds.size();
    const std::string study =
        std::to_string(all_trials) + " initial poses and predictions wrong by 5 cm and 5 degrees";
    const auto scores_of_seeds = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      rack_study::WrongStartSettings settings;
      settings.scene.model = rack_study::rack_on_beams();
      return rack_study::score_wrong_starts(
          rack_study::try_wrong_starts(settings, extent_.trials, seed));
    });
    add_starts(study, scores_of_seeds,
               {.silent = "silent_wrong_pose", .admitted = "admitted_wrong_pose"});
  }

  /// Names of figures of starts; an empty one: a row only.
  struct StartNames {
    std::string converged{};
    std::string silent{};
    std::string admitted{};
  };

  void add_starts(const std::string& study, const std::vector<WrongStartScore>& per_seed,
                  const StartNames& names, const std::vector<Measure>& more = {}) {
    WrongStartScore all;
    for (const WrongStartScore& score : per_seed) {
      all += score;
    }
    std::vector<Measure> measures{
        {"error above 3 cm or 1 degree, neither declared nor in the covariance",
         static_cast<double>(all.silent_wrong), each(per_seed, &WrongStartScore::silent_wrong),
         kNone, names.silent},
        {"the same within the covariance (99 %)", static_cast<double>(all.admitted_wrong),
         each(per_seed, &WrongStartScore::admitted_wrong), kSmallIsGood, names.admitted},
        {"converged, %", percent(all.converged, all.trials),
         each(per_seed, [](const auto& score) { return percent(score.converged, score.trials); }),
         kLargeIsGood, names.converged},
        {"declared lost, %", percent(all.lost, all.trials),
         each(per_seed, [](const auto& score) { return percent(score.lost, score.trials); }),
         kSmallIsGood}};
    measures.insert(measures.end(), more.begin(), more.end());
    rows_.add_study(study, measures);
  }

  static std::string seconds(double duration) {
    return std::to_string(std::lround(duration)) + " s";
  }
  const ReproduceOptions& options_;
  const RackImageExtent& extent_;
  std::vector<std::uint64_t> seeds_;
  FigureRows& rows_;
  std::ostream& out_;
  StageProgress& progress_;
};

}  // namespace

void reproduce_rack_images(RackReproduction& run) {
  RackImages(run).run();
}

}  // namespace pipescout::reproduce
