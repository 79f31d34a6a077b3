// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "arm.hpp"
#include "arm_inspection.hpp"
#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/tracking_study/crossing_score.hpp"
#include "pipescout/tracking_study/recording.hpp"
#include "pipescout/tracking_study/tracking_score.hpp"
#include "pipescout/validation/number_text.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using tracking_study::EstimateErrors;
using tracking_study::Moments;
using tracking_study::Recording;
using tracking_study::TrackingScore;
using tracking_study::TrackingSettings;

constexpr std::size_t kOurParticles = 1000;

TrackingSettings with_particles(std::size_t particles) {
  TrackingSettings settings;
  settings.tracker.filter.particles = particles;
  return settings;
}

/// What is asked of the same pictures.
struct Scores {
  TrackingScore few;  ///< 500 particles
  TrackingScore many;
  TrackingScore without_odometry;
  TrackingScore paper_few;  ///< the paper's filter alone, 500 particles
  TrackingScore paper_many;

  Scores& operator+=(const Scores& other) {
    few += other.few;
    many += other.many;
    without_odometry += other.without_odometry;
    paper_few += other.paper_few;
    paper_many += other.paper_many;
    return *this;
  }
};

class Tracking {
 public:
  Tracking(const ReproduceOptions& options, const TrackingExtent& extent, std::ostream& out)
      : options_(options),
        extent_(extent),
        out_(out),
        seeds_(seeds_of(options, std::min(options.seeds, extent.largest_seeds))),
        rows_(result_, out),
        progress_(options) {}

  Reproduction run() {
    out_ << "Ibarguren and others: a pipe is tracked and kept in view. Seeds " << seeds_.front()
         << " to " << seeds_.back() << ", not used for tuning.\n\n";
    result_.seeds = seeds_;
    add_table_one();
    add_long_sequences();
    add_crossings();
    add_particles();
    reproduce_arm(extent_.arm, seeds_, rows_, progress_);
    reproduce_arm_inspection(extent_, seeds_, rows_, progress_);
    return std::move(result_);
  }

 private:
  void add_table_one() {
    const std::size_t sequences = extent_.sequences;
    std::vector<std::uint64_t> all(sequences * seeds_.size());
    std::iota(all.begin(), all.end(), 0);
    const std::string study = std::to_string(sequences) + " sequences of " +
                              std::to_string(extent_.recording.frames) + " pictures";
    const auto each = for_each_seed(progress_, study, all, [&](std::uint64_t i) {
      const Recording recording =
          sequence(seeds_[i / sequences], i % sequences, sequences, extent_.recording);
      TrackingSettings blind = with_particles(kOurParticles);
      blind.odometry = false;
      return Scores{score_tracking(recording, with_particles(500), i),
                    score_tracking(recording, with_particles(kOurParticles), i),
                    score_tracking(recording, blind, i),
                    score_paper_filter(recording, with_particles(500), i),
                    score_paper_filter(recording, with_particles(kOurParticles), i)};
    });
    std::vector<Scores> of_seeds(seeds_.size());
    Scores total;
    for (std::size_t i = 0; i < each.size(); ++i) {
      of_seeds[i / sequences] += each[i];
      total += each[i];
    }
    const TableScores table{each, of_seeds, total};
    add_rows("Table 1 (targets: the paper's), with ours behind the particles, " + study, table,
             {&Scores::few, &Scores::many}, "table1");
    add_rows("Table 1 (targets: the paper's), the paper's filter alone, " + study, table,
             {&Scores::paper_few, &Scores::paper_many}, "paper_filter");
    add_ours(study, of_seeds, total);
  }

  /// Of 500 and of 1000 particles.
  using Pair = std::pair<TrackingScore Scores::*, TrackingScore Scores::*>;

  struct TableScores {
    const std::vector<Scores>& sequences;
    const std::vector<Scores>& seeds;
    const Scores& total;
  };

  /// `figures`: what the names of the figures begin with.
  void add_rows(const std::string& title, const TableScores& table, const Pair& which,
                const std::string& figures) {
    std::vector<Measure> measures;
    double covered = 0;
    double deviations_covered = 0;
    double deviations_not_above = 0;
    for (const tracking_study::TableRow& row : tracking_study::kTableOne) {
      const auto errors = [&](const Scores& scores) -> const EstimateErrors& {
        return (scores.*(row.particles == kOurParticles ? which.second : which.first))
            .errors[row.estimate];
      };
      covered += row.covers(errors(table.total)) ? 1 : 0;
      deviations_covered += row.covers_deviations(errors(table.total)) ? 1 : 0;
      bool above = false;
      const auto add = [&](const char* what, Moments EstimateErrors::*moments, double mean,
                           double deviation) {
        std::vector<double> means;
        for (const Scores& scores : table.seeds) {
          means.push_back((errors(scores).*moments).mean());
        }
        std::vector<Moments> sequences;
        for (const Scores& scores : table.sequences) {
          sequences.push_back(errors(scores).*moments);
        }
        const auto interval = tracking_study::deviation_interval(sequences, seeds_.front());
        above = above || interval.low > deviation;
        const Moments& all = errors(table.total).*moments;
        const std::string name = std::string(row.name) + ": " + what;
        measures.push_back({name + ", mean", all.mean(), means, {.most = mean}});
        measures.push_back({name + ", deviation", all.deviation(), {}, {.most = deviation}});
        measures.push_back({name + ", deviation, 95 % from", interval.low, {}, kSmallIsGood});
        measures.push_back({name + ", deviation, 95 % to", interval.high, {}, kSmallIsGood});
      };
      add("position, px", &EstimateErrors::position, row.position_mean, row.position_deviation);
      add("angle, deg", &EstimateErrors::angle, row.angle_mean, row.angle_deviation);
      add("length, px", &EstimateErrors::length, row.length_mean, row.length_deviation);
      deviations_not_above += above ? 0 : 1;
    }
    constexpr double kRows = tracking_study::kTableOne.size();
    measures.push_back({"rows with all means at or below the paper's",
                        covered,
                        {},
                        {.least = kRows},
                        figures + "_rows_at_or_below_paper"});
    measures.push_back({"rows with all deviations at or below the paper's",
                        deviations_covered,
                        {},
                        {.least = kRows},
                        figures + "_deviations_at_or_below_paper"});
    measures.push_back({"rows with no deviation above the paper's beyond its sampling",
                        deviations_not_above,
                        {},
                        kLargeIsGood,
                        figures + "_deviations_not_above_paper"});
    measures.push_back({"lost tracks, 1000 particles",
                        static_cast<double>((table.total.*which.second).lost_tracks),
                        {},
                        kSmallIsGood});
    rows_.add_study(title, measures);
  }

  void add_ours(const std::string& study, const std::vector<Scores>& of_seeds,
                const Scores& total) {
    std::vector<Measure> measures;
    const auto add = [&](const std::string& prefix, TrackingScore Scores::*which,
                         const std::string& figure, Target position, Target angle, Target length) {
      const auto add_one = [&](const char* name, Moments EstimateErrors::*moments,
                               const std::string& key, Target target) {
        std::vector<double> means;
        for (const Scores& scores : of_seeds) {
          means.push_back(((scores.*which).errors[tracking_study::kOurs].*moments).mean());
        }
        const Moments& all = (total.*which).errors[tracking_study::kOurs].*moments;
        measures.push_back({prefix + name + ", mean", all.mean(), means, target, key});
        measures.push_back({prefix + name + ", deviation", all.deviation(), {}, kSmallIsGood});
      };
      const bool named = !figure.empty();
      add_one("position, px", &EstimateErrors::position, named ? figure + "_position_px" : "",
              position);
      add_one("angle, deg", &EstimateErrors::angle, named ? figure + "_angle_deg" : "", angle);
      add_one("length, px", &EstimateErrors::length, named ? figure + "_length_px" : "", length);
    };
    add("", &Scores::many, "best", {.most = 0.7}, {.most = 0.2}, {.most = 1.5});
    add("without odometry: ", &Scores::without_odometry, "", {}, {}, {});
    const EstimateErrors& gaps = total.many.in_gaps;
    measures.push_back({"pictures in gaps, of " + std::to_string(total.many.pictures),
                        static_cast<double>(gaps.position.count()),
                        {},
                        kSmallIsGood});
    measures.push_back({"in gaps: position, px, mean", gaps.position.mean(), {}, kSmallIsGood});
    measures.push_back({"in gaps: angle, deg, mean", gaps.angle.mean(), {}, kSmallIsGood});
    measures.push_back({"in gaps: length, px, mean", gaps.length.mean(), {}, kSmallIsGood});
    measures.push_back({"lost tracks",
                        static_cast<double>(total.many.lost_tracks),
                        {},
                        kNone,
                        "lost_tracks_short"});
    measures.push_back({"lost tracks without odometry",
                        static_cast<double>(total.without_odometry.lost_tracks),
                        {},
                        kSmallIsGood});
    rows_.add_study("Our estimate, 1000 particles, " + study, measures);
    lost_ += total.many.lost_tracks;
  }

  void add_long_sequences() {
    tracking_study::RecordingSettings settings = extent_.recording;
    settings.frames = extent_.long_frames;
    const auto seeds = seeds_of(options_, extent_.long_sequences);
    const std::string study = std::to_string(extent_.long_sequences) + " sequences of " +
                              std::to_string(extent_.long_frames) + " pictures";
    const auto each = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      // One of five, so that all sorts of ground and cameras have their turn.
      constexpr std::size_t kSorts = 5;
      return score_tracking(sequence(seed, seed % kSorts, kSorts, settings),
                            with_particles(kOurParticles), seed);
    });
    TrackingScore total;
    for (const TrackingScore& score : each) {
      total += score;
    }
    lost_ += total.lost_tracks;
    const EstimateErrors& ours = total.errors[tracking_study::kOurs];
    rows_.add_study(
        study,
        {{"lost tracks", static_cast<double>(total.lost_tracks), {}, kNone, "lost_tracks_long"},
         {"lost tracks, short sequences too", static_cast<double>(lost_), {}, kNone, "lost_tracks"},
         {"position, px, mean", ours.position.mean(), {}, kSmallIsGood},
         {"angle, deg, mean", ours.angle.mean(), {}, kSmallIsGood},
         {"length, px, mean", ours.length.mean(), {}, kSmallIsGood}});
  }

  /// What is asked: 200 in all.
  void add_crossings() {
    const auto seeds = seeds_of(options_, extent_.crossings);
    const std::string study =
        std::to_string(seeds.size()) + " crossings or passings of two tubes, one hidden for 1 s";
    tracking_study::CrossingScore total;
    tracking_study::CrossingScore blind;
    progress_.begin(study, seeds.size());
    for (const std::uint64_t seed : seeds) {
      total += tracking_study::score_crossing({}, {}, seed);
      blind += tracking_study::score_crossing({}, {.odometry = false}, seed);
      progress_.step();
    }
    progress_.end();
    rows_.add_study(study, {{"on the other tube at the end",
                             static_cast<double>(total.swaps),
                             {},
                             kNone,
                             "crossing_swaps"},
                            {"on none of the two at the end",
                             static_cast<double>(total.lost),
                             {},
                             kSmallIsGood,
                             "crossing_lost"},
                            {"without odometry: on the other tube",
                             static_cast<double>(blind.swaps),
                             {},
                             kSmallIsGood},
                            {"without odometry: on none of the two",
                             static_cast<double>(blind.lost),
                             {},
                             kSmallIsGood}});
  }

  void add_particles() {
    const Recording recording = sequence(seeds_.front(), 0, extent_.sequences, extent_.recording);
    std::vector<Measure> measures;
    progress_.begin("numbers of particles", extent_.particles.size());
    for (const std::size_t particles : extent_.particles) {
      const TrackingSettings settings = with_particles(particles);
      const auto begin = std::chrono::steady_clock::now();
      const TrackingScore score = score_tracking(recording, settings, seeds_.front());
      const std::chrono::duration<double, std::micro> took =
          std::chrono::steady_clock::now() - begin;
      const std::string prefix = std::to_string(particles) + " particles: ";
      for (const auto& [name, estimate] :
           {std::pair{"best particle", tracking_study::kBestParticle},
            std::pair{"robust mean", tracking_study::kRobustMean},
            std::pair{"weighted mean", tracking_study::kWeightedMean},
            std::pair{"ours", tracking_study::kOurs}}) {
        measures.push_back({prefix + name + ", position, px",
                            score.errors[estimate].position.mean(),
                            {},
                            kSmallIsGood});
      }
      measures.push_back({prefix + "a picture, us",
                          took.count() / static_cast<double>(recording.pictures.size()),
                          {},
                          kSmallIsGood});
      progress_.step();
    }
    progress_.end();
    rows_.add_study("Error and time over the number of particles, one sequence", measures);
  }

  /// One of the patrols that are planned with a seed.
  static Recording sequence(std::uint64_t seed, std::size_t number, std::size_t sequences,
                            const tracking_study::RecordingSettings& settings) {
    const auto patrols = tracking_study::plan_patrols(sequences, settings, seed);
    return tracking_study::record(patrols[number], settings, seed * sequences + number);
  }

  static std::string text(double value) { return validation::fixed_text(value, 2); }

  const ReproduceOptions& options_;
  const TrackingExtent& extent_;
  std::ostream& out_;
  std::vector<std::uint64_t> seeds_;
  Reproduction result_;
  FigureRows rows_;
  StageProgress progress_;
  std::size_t lost_ = 0;
};

}  // namespace

Reproduction reproduce_tracking(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_tracking(options, TrackingExtent{}, out);
}

Reproduction reproduce_tracking(const ReproduceOptions& options, const TrackingExtent& extent,
                                std::ostream& out) {
  return Tracking(options, extent, out).run();
}

}  // namespace pipescout::reproduce
