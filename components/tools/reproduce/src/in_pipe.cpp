// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "figure_rows.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/odometry_study/crawler_score.hpp"
#include "pipescout/odometry_study/detector_score.hpp"
#include "pipescout/odometry_study/elbow_score.hpp"
#include "pipescout/odometry_study/inspection_score.hpp"
#include "pipescout/odometry_study/paper_bench.hpp"
#include "pipescout/odometry_study/quantile.hpp"
#include "reproduce.hpp"
#include "seed_values.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using odometry_study::BenchSlips;
using odometry_study::CrawlerRunSettings;
using odometry_study::CrawlerScore;
using odometry_study::DetectorScore;
using odometry_study::ElbowScores;
using odometry_study::ElbowSettings;
using odometry_study::quantile;

class InPipe {
 public:
  InPipe(const ReproduceOptions& options, const InPipeExtent& extent, std::ostream& out)
      : options_(options),
        extent_(extent),
        out_(out),
        seeds_(seeds_of(options, options.seeds)),
        rows_(result_, out),
        progress_(options) {}

  Reproduction run() {
    const auto runs = read_runs();  // before the long work, so that what is
                                    // wrong is said at once
    out_ << "Seeds " << seeds_.front() << " to " << seeds_.back()
         << ", not used for tuning. Mean, 95 % and worst are over the seeds.\n\n";
    result_.seeds = seeds_;
    bench(BenchSlips::kOneAtATime, "The paper's set-up: one reading in ten wrong, 99 m",
          {"paper_p95_error_percent", "paper_worst_error_percent"});
    bench(BenchSlips::kIndependent, "The same, each reading wrong by itself with probability 0.1",
          {});
    elbows();
    position();
    position_with_bends();
    detect();
    align(runs);
    return std::move(result_);
  }

 private:
  struct BenchFigures {
    std::string p95;
    std::string worst;
  };

  void bench(BenchSlips slips, const std::string& study, const BenchFigures& figures) {
    std::vector<double> at_end;
    std::vector<double> at_ten;
    progress_.begin(study, seeds_.size());
    for (const auto seed : seeds_) {
      const auto error = odometry_study::run_paper_bench(slips, seed);
      at_end.push_back(error.percent);
      at_ten.push_back(error.percent_at_ten_joints);
      progress_.step();
    }
    progress_.end();
    rows_.add_study(
        study,
        {{"worst error, % of the distance", quantile(at_end, 1.0), at_end, at_most(1.0),
          figures.worst},
         {"95 % of the errors, %", quantile(at_end, 0.95), at_end, at_most(0.4), figures.p95},
         {"worst error after ten joints, %", quantile(at_ten, 1.0), at_ten, kSmallIsGood}});
  }

  struct Positioned {
    std::vector<CrawlerScore> runs;

    template <class Function>
    [[nodiscard]] std::vector<double> each(Function value) const {
      std::vector<double> values;
      for (const CrawlerScore& score : runs) {
        values.push_back(value(score));
      }
      return values;
    }
    [[nodiscard]] std::vector<double> each(std::size_t CrawlerScore::*field) const {
      return each([field](const CrawlerScore& score) { return static_cast<double>(score.*field); });
    }
    [[nodiscard]] std::vector<double> each_percent(std::size_t CrawlerScore::*part,
                                                   std::size_t CrawlerScore::*whole) const {
      return each(
          [part, whole](const CrawlerScore& score) { return percent(score.*part, score.*whole); });
    }
    [[nodiscard]] double all_percent(std::size_t CrawlerScore::*part,
                                     std::size_t CrawlerScore::*whole) const {
      return 100.0 * sum(each(part)) / sum(each(whole));
    }
    [[nodiscard]] std::vector<double> errors() const {
      std::vector<double> all;
      for (const CrawlerScore& score : runs) {
        all.insert(all.end(), score.errors.begin(), score.errors.end());
      }
      return all;
    }
  };

  Positioned drive(const std::string& study, CrawlerRunSettings settings) {
    settings.joints = extent_.joints;
    settings.run_length = extent_.run_length;
    Positioned result;
    progress_.begin(study, seeds_.size());
    for (const auto seed : seeds_) {
      settings.backward = seed % 2 == 1;
      const auto run = odometry_study::simulate_crawler_run(settings, seed);
      odometry::WeldPositioning positioning(
          {}, run.tally, {.orientation = odometry::Orientation::kUnknown}, run.tally_bends);
      result.runs.push_back(odometry_study::score_run(run, positioning, settings));
      progress_.step();
    }
    progress_.end();
    return result;
  }

  /// With the names of figures when `main`.
  static std::vector<Measure> place_measures(const Positioned& scored, bool main) {
    const auto name = [main](const char* figure) { return main ? figure : ""; };
    const auto locks = scored.each(&CrawlerScore::lock_joints);
    const auto wrong = scored.each(&CrawlerScore::wrong_joint);
    const auto errors = scored.errors();
    const auto p95 =
        scored.each([](const CrawlerScore& score) { return quantile(score.errors, 0.95); });
    const auto worst =
        scored.each([](const CrawlerScore& score) { return quantile(score.errors, 1.0); });
    return {{"joints until locked, median", quantile(locks, 0.5), locks, at_most(10.0),
             name("lock_joints_median")},
            {"joints until locked, largest", quantile(locks, 1.0), locks, at_most(20.0),
             name("lock_joints_max")},
            {"times locked to a wrong joint", sum(wrong), wrong, within(0.0, 0.0),
             name("wrong_joint_after_lock")},
            {"error in the joint, 95 %, m", quantile(errors, 0.95), p95, at_most(0.05),
             name("in_joint_p95_m")},
            {"error in the joint, worst, m", quantile(errors, 1.0), worst, at_most(0.15),
             name("in_joint_worst_m")},
            {"truth inside the 95 % band, %",
             scored.all_percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events),
             scored.each_percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events),
             within(92.0, 98.0), name("coverage95_percent")},
            {"joint certain since the first lock, % of the way",
             scored.all_percent(&CrawlerScore::locked_events, &CrawlerScore::events_since_lock),
             scored.each_percent(&CrawlerScore::locked_events, &CrawlerScore::events_since_lock),
             kLargeIsGood}};
  }

  /// The paper's Figure 3 for bends: its consensus, the plain average and wheels around the
  /// circumference.
  void elbows() {
    using odometry::FusionRule;
    struct Variant {
      const char* name;
      ElbowSettings settings;
      bool main = false;
    };
    const std::vector<Variant> variants{
        {"consensus, equations (1) to (13)", {.rule = FusionRule::kConsensus}},
        {"average, equation (14)", {.rule = FusionRule::kAverage}},
        {"wheels around the circumference", {}, true},
        {"the same with a slip in the bend", {.slip_in_bend = 1}},
        {"average with a slip in the bend", {.rule = FusionRule::kAverage, .slip_in_bend = 1}},
        {"five wheels around the circumference, a slip in the bend",
         {.wheels = 5, .slip_in_bend = 1}}};
    std::vector<Measure> compared;
    for (const Variant& variant : variants) {
      const std::string study =
          std::string("Bends of 1.5 to 5 D, pipes of 0.3 and 1.0 m, three wheels: ") + variant.name;
      progress_.begin(study, seeds_.size());
      ElbowScores all;
      std::vector<double> seed_p95;
      std::vector<double> seed_found;
      for (const auto seed : seeds_) {
        ElbowScores scores;
        for (const double diameter : {0.3, 1.0}) {
          ElbowSettings settings = variant.settings;
          settings.pipe_diameter = diameter;
          scores += odometry_study::run_elbows(settings, seed, extent_.elbows);
        }
        seed_p95.push_back(quantile(scores.errors, 0.95));
        seed_found.push_back(percent(scores.found, scores.errors.size()));
        all += scores;
        progress_.step();
      }
      progress_.end();
      const auto figure = [&](const char* name) { return variant.main ? name : ""; };
      const bool finds = variant.settings.rule == FusionRule::kCircumference;
      std::vector<Measure> measures{
          {"error of a bend, 95 %, m", quantile(all.errors, 0.95), seed_p95,
           variant.main ? at_most(0.02) : kSmallIsGood, figure("elbow_error_p95_m")},
          {"error of a bend, worst, m",
           quantile(all.errors, 1.0),
           {},
           kSmallIsGood,
           figure("elbow_error_worst_m")},
          {"truth inside the 95 % band, %",
           percent(all.inside, all.errors.size()),
           {},
           variant.main ? within(92.0, 98.0) : kLargeIsGood,
           figure("elbow_coverage95_percent")}};
      if (finds) {
        measures.push_back({"bends found, %", percent(all.found, all.errors.size()), seed_found,
                            variant.main ? at_least(99.0) : kLargeIsGood,
                            figure("elbow_found_percent")});
        measures.push_back({"found where there is none, per km",
                            1000.0 * static_cast<double>(all.others) / all.driven,
                            {},
                            kSmallIsGood,
                            figure("elbow_false_per_km")});
      }
      rows_.add_study(study, measures);
      for (const auto& [what, quantile_of] :
           {std::pair{"median", 0.5}, std::pair{"95 %", 0.95}, std::pair{"worst", 1.0}}) {
        compared.push_back({std::string(variant.name) + ": error of a bend, " + what + ", m",
                            quantile(all.errors, quantile_of),
                            {},
                            kSmallIsGood});
      }
    }
    rows_.add_study("Bends, the rules compared", compared);
  }

  void position_with_bends() {
    CrawlerRunSettings settings;
    settings.bends = extent_.bends;
    settings.tees = extent_.bends / 3;
    settings.rule = odometry::FusionRule::kCircumference;
    // A bend is judged as a whole when it has ended: its windows must not be final before.
    settings.lookback_windows = 16;
    const std::string study = "The same with " + std::to_string(extent_.bends) +
                              " bends, T pieces and verticals, wheels around the circumference";
    const Positioned bent = drive(study, settings);
    auto measures = place_measures(bent, false);
    const auto rename = [&](const char* name, const char* figure) {
      for (Measure& measure : measures) {
        if (measure.name == name) {
          measure.figure = figure;
        }
      }
    };
    rename("error in the joint, 95 %, m", "bends_in_joint_p95_m");
    rename("error in the joint, worst, m", "bends_in_joint_worst_m");
    rename("truth inside the 95 % band, %", "bends_coverage95_percent");
    rename("times locked to a wrong joint", "bends_wrong_joint_after_lock");
    rows_.add_study(study, measures);

    // Three wheels leave no residual in a bend: a slip over most of one is told only by more.
    settings.wheels = 5;
    const std::string five = study + ", five wheels";
    auto of_five = place_measures(drive(five, settings), false);
    for (Measure& measure : of_five) {
      if (measure.name == "error in the joint, worst, m") {
        measure.figure = "five_wheels_bends_in_joint_worst_m";
      } else if (measure.name == "times locked to a wrong joint") {
        measure.figure = "five_wheels_bends_wrong_joint_after_lock";
      }
    }
    rows_.add_study(five, of_five);
    settings.wheels = 3;

    settings.rule = odometry::FusionRule::kConsensus;
    settings.lookback_windows = 0;
    const std::string consensus =
        "The same with " + std::to_string(extent_.bends) + " bends, T pieces, verticals, consensus";
    rows_.add_study(consensus, place_measures(drive(consensus, settings), false));
  }

  void position() {
    const std::string kilometres = std::to_string(std::lround(extent_.run_length / 1000.0));
    const std::string conditions =
        kilometres + " km of 12 m joints, simulated wheels through the stream, unknown start";
    rows_.add_study(conditions, place_measures(drive(conditions, {}), true));

    CrawlerRunSettings settings;
    settings.double_slips = extent_.double_slips;
    const std::string slips = "The same with two of three wheels slipping together at times";
    const Positioned slipped = drive(slips, settings);
    const auto hidden = slipped.each(&CrawlerScore::slips_hidden);
    auto measures = place_measures(slipped, false);
    measures.insert(
        measures.begin(),
        {{"detected by the spacing of the welds, %",
          slipped.all_percent(&CrawlerScore::slips_detected, &CrawlerScore::slips),
          slipped.each_percent(&CrawlerScore::slips_detected, &CrawlerScore::slips), at_least(99.0),
          "double_slip_detected_percent"},
         {"detected by that or by the fusion, %",
          slipped.all_percent(&CrawlerScore::slips_said, &CrawlerScore::slips),
          slipped.each_percent(&CrawlerScore::slips_said, &CrawlerScore::slips), kLargeIsGood},
         {"covariance overconfident after two welds", sum(hidden), hidden, kSmallIsGood},
         {"false detections", sum(slipped.each(&CrawlerScore::false_slips)),
          slipped.each(&CrawlerScore::false_slips), kSmallIsGood}});
    rows_.add_study(slips, measures);

    settings = {};
    settings.reverse_share = 0.2;
    const std::string reversing = "The same reversing after every fifth stop";
    rows_.add_study(reversing, place_measures(drive(reversing, settings), false));

    settings = {};
    settings.wheel_noise = 0.024;
    const std::string coarse = "The same with the wheels of the paper, 0.024 m per root of a metre";
    rows_.add_study(coarse, place_measures(drive(coarse, settings), false));
  }

  void detect() {
    constexpr double kMainSnr = 12.0;  // dB
    for (const double snr : {6.0, 9.0, kMainSnr, 15.0, 18.0, 21.0, 24.0}) {
      const bool main = snr == kMainSnr;
      const double length = main ? extent_.detector_length : extent_.curve_length;
      const auto kilometres = length * static_cast<double>(seeds_.size()) / 1000.0;
      const std::string study = "Weld detector at " + std::to_string(std::lround(snr)) +
                                " dB, all disturbances, " +
                                std::to_string(std::lround(kilometres)) + " km";
      std::vector<double> found;
      std::vector<double> wrong;
      std::vector<double> p95;
      DetectorScore all;
      progress_.begin(study, seeds_.size());
      for (const auto seed : seeds_) {
        const auto score = odometry_study::score_detector(snr, length, seed);
        found.push_back(score.found_percent());
        wrong.push_back(score.false_per_km());
        p95.push_back(quantile(score.errors, 0.95));
        all += score;
        progress_.step();
      }
      progress_.end();
      rows_.add_study(
          study, {{"welds found, %", all.found_percent(), found, at_least(99.5),
                   main ? "weld_found_percent" : ""},
                  {"false ones per km", all.false_per_km(), wrong, at_most(0.1),
                   main ? "weld_false_per_km" : ""},
                  {"error of the position, 95 %, m", quantile(all.errors, 0.95), p95, kSmallIsGood},
                  {"within 1.96 stated standard deviations, %",
                   100.0 * all.share_within(1.96),
                   {},
                   kLargeIsGood}});
    }
  }

  using Runs = std::pair<odometry_study::InspectionList, odometry_study::InspectionList>;

  /// Nothing when nobody has said where they are, and they are not in the usual
  /// place.
  [[nodiscard]] std::optional<Runs> read_runs() const {
    const std::string folder = options_.data.empty() ? default_data_folder() : options_.data;
    const auto then = std::filesystem::path(folder) / "ili_pipeline" / "2007.csv";
    const auto later = std::filesystem::path(folder) / "ili_pipeline" / "2015.csv";
    if (options_.data.empty() && (!exists(then) || !exists(later))) {
      return std::nullopt;
    }
    const auto list = [](const std::filesystem::path& file,
                         const odometry_study::ListColumns& columns) {
      return odometry_study::read_inspection_list(read_csv_text(file), columns, file.string());
    };
    return Runs{list(then, odometry_study::kColumns2007),
                list(later, odometry_study::kColumns2015)};
  }

  void align(const std::optional<Runs>& runs) {
    const std::string study = "Two real runs of one pipeline, 2007 and 2015";
    if (!runs) {
      out_ << study
           << "\n\n  NOT MEASURED, their figures are left out: there is no "
              "ili_pipeline/2007.csv and 2015.csv\n  in the folder of --data, "
              "$PIPESCOUT_SHARED_DATA or ../shared/data.\n\n";
      return;
    }
    progress_.begin(study, 1);
    const auto score = odometry_study::score_inspection(runs->first, runs->second);
    progress_.step();
    progress_.end();
    rows_.add_study(
        study,
        {{"welds matched, %",
          percent(score.right, score.common),
          {},
          at_least(99.5),
          "ili_welds_matched_percent"},
         {"welds matched wrongly",
          static_cast<double>(score.wrong),
          {},
          within(0.0, 0.0),
          "ili_welds_wrong"},
         {"distance of features, 95 %, m",
          quantile(score.feature_errors, 0.95),
          {},
          at_most(0.5),
          "ili_feature_p95_m"},
         {"distance of features, worst, m", quantile(score.feature_errors, 1.0), {}, kSmallIsGood},
         {"the same before alignment, 95 %, m", quantile(score.unaligned, 0.95), {}, kSmallIsGood},
         {"welds in common", static_cast<double>(score.common), {}, kLargeIsGood},
         {"features in common",
          static_cast<double>(score.feature_errors.size()),
          {},
          kLargeIsGood}});
  }

  const ReproduceOptions& options_;
  const InPipeExtent& extent_;
  std::ostream& out_;
  std::vector<std::uint64_t> seeds_;
  Reproduction result_;
  FigureRows rows_;
  StageProgress progress_;
};

}  // namespace

std::string default_data_folder() {
  const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
  const std::filesystem::path folder = shared != nullptr ? shared : "../shared/data";
  return is_directory(folder) ? folder.string() : "";
}

Reproduction reproduce_in_pipe(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_in_pipe(options, {}, out);
}

Reproduction reproduce_in_pipe(const ReproduceOptions& options, const InPipeExtent& extent,
                               std::ostream& out) {
  return InPipe(options, extent, out).run();
}

}  // namespace pipescout::reproduce
