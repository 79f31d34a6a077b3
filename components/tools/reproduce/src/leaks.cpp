// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/command_line/installed_share_folder.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/leak_study/campaign.hpp"
#include "pipescout/leak_study/ibarguren2013_figure7.hpp"
#include "pipescout/leak_study/roc.hpp"
#include "pipescout/leak_study/sequence_run.hpp"
#include "pipescout/odometry_study/quantile.hpp"
#include "pipescout/thermal_files/flir_reference.hpp"
#include "reproduce.hpp"
#include "seed_values.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using command_line::installed_share_folder;

using leak_study::CampaignScore;
using leak_study::RocScores;
using odometry_study::quantile;

std::string number(double value) {
  return std::to_string(std::lround(value));
}

class Leaks {
 public:
  Leaks(const ReproduceOptions& options, const LeaksExtent& extent, std::ostream& out)
      : options_(options),
        extent_(extent),
        out_(out),
        seeds_(seeds_of(options, std::min(options.seeds, extent.largest_seeds))),
        rows_(result_, out),
        progress_(options) {}

  Reproduction run() {
    out_ << "Ibarguren and others: leaks along collectors. Seeds " << seeds_.front() << " to "
         << seeds_.back() << ", not used for tuning.\n\n";
    result_.seeds = seeds_;
    add_figure_seven();
    add_real_pictures();
    add_campaigns();
    add_world();
    add_automatic_gain();
    add_roc();
    return std::move(result_);
  }

 private:
  void add_figure_seven() {
    const auto folder = installed_share_folder("pipescout_leak_study");
    if (!folder) {
      throw std::runtime_error("the data of package pipescout_leak_study is not installed");
    }
    const std::string path = *folder + "/ibarguren2013_figure7.csv";
    const auto parts = leak_study::read_figure7(read_csv_text(path), path);
    const auto labels = leak_study::label_figure7(parts, thermal::ProfileParameters::torresol());
    constexpr double kSequences = 13;
    rows_.add_study(
        "Figure 7 of the paper: parts of pipes in 13 sequences that leak",
        {{"sequences with a flagged part",
          static_cast<double>(labels.flagged),
          {},
          {.least = kSequences, .most = kSequences},
          "fig7_flagged"},
         {"parts flagged, of " + std::to_string(parts.size()),
          static_cast<double>(std::ranges::count(labels.kinds, thermal::PartKind::kLeak)),
          {},
          kLargeIsGood},
         {"warmest part not flagged, degC", labels.warmest_sound, {}, kSmallIsGood},
         {"coldest flagged part, degC", labels.coldest_leak, {}, kLargeIsGood},
         {"cut-off, degC", labels.cut_off, {}, kLargeIsGood, "fig7_cut_off_degc"}});
  }

  void add_real_pictures() {
    const std::string study = "Real images: temperatures compared with other software";
    const std::filesystem::path folder =
        std::filesystem::path(options_.data.empty() ? default_data_folder() : options_.data) /
        "thermal_flir";
    if (options_.data.empty() && !exists(folder / kFlirReferenceFile)) {
      out_ << study << "\n\n  NOT MEASURED, its figures are left out: there is no thermal_flir/"
           << kFlirReferenceFile
           << "\n  in the folder of --data, $PIPESCOUT_SHARED_DATA or ../shared/data.\n\n";
      return;
    }
    const FlirReferenceErrors errors = score_flir_reference(folder);
    rows_.add_study(
        study, {{"iguana, ThermaCAM (prints tenths): mean, K",
                 errors.thermacam.mean_abs,
                 {},
                 kSmallIsGood},
                {"the same, largest, K", errors.thermacam.max_abs, {}, kSmallIsGood},
                {"iguana, FLIR R&D Software: mean, K", errors.research.mean_abs, {}, kSmallIsGood},
                {"the same, largest, K", errors.research.max_abs, {}, kSmallIsGood},
                {"iguana, larger of both: mean, K",
                 std::max(errors.thermacam.mean_abs, errors.research.mean_abs),
                 {},
                 {.most = 0.05},
                 "iguana_mean_abs_error_k"},
                {"the same, largest, K",
                 std::max(errors.thermacam.max_abs, errors.research.max_abs),
                 {},
                 {.most = 0.15},
                 "iguana_max_abs_error_k"},
                {"five images, their degC_x100 files: largest, K",
                 errors.decoded.max_abs,
                 {},
                 {.most = 0.02},
                 "degc_x100_max_error_k"}});
  }

  /// One score for each seed.
  std::vector<CampaignScore> run_campaigns(const std::string& study,
                                           const leak_study::CampaignSettings& campaign,
                                           const leak_study::InspectionSettings& inspection) {
    const std::size_t sequences = campaign.sequences;
    std::vector<std::vector<leak_study::SequencePlan>> plans;
    for (const std::uint64_t seed : seeds_) {
      plans.push_back(leak_study::plan_campaign(campaign, seed));
    }
    std::vector<std::uint64_t> all(sequences * seeds_.size());
    std::iota(all.begin(), all.end(), 0);
    const auto scores = for_each_seed(progress_, study, all, [&](std::uint64_t i) {
      const std::uint64_t seed = seeds_[i / sequences] * sequences + i % sequences;
      return leak_study::run_sequence(plans[i / sequences][i % sequences], inspection, seed);
    });
    std::vector<CampaignScore> result(seeds_.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      result[i / sequences].add(plans[i / sequences][i % sequences], scores[i]);
    }
    return result;
  }

  void add_campaigns() {
    const leak_study::CampaignSettings& campaign = extent_.campaign;
    const std::size_t leaks = campaign.faint_leaks + campaign.other_leaks;
    const std::string study = std::to_string(campaign.sequences) + " sequences of " +
                              number(campaign.length) + " m with " + std::to_string(leaks) +
                              " leaks, " + std::to_string(campaign.faint_leaks) +
                              " of them faint, and " + std::to_string(campaign.decoys) + " decoys";
    const auto scores = run_campaigns(study, campaign, {});
    const CampaignScore all = sum_of(scores);
    const auto p95 = [](const CampaignScore& score) {
      return quantile(score.position_errors, 0.95);
    };
    const auto slowest = [](const CampaignScore& score) {
      return score.frames_to_raise.empty() ? 0 : std::ranges::max(score.frames_to_raise);
    };
    rows_.add_study(
        study, {{"leaks found, %",
                 all.found_percent(),
                 each(scores, &CampaignScore::found_percent),
                 {.least = 100},
                 "leaks_found_percent"},
                {"faint ones found, of " + std::to_string(all.faint_leaks),
                 static_cast<double>(all.faint_found),
                 each(scores, [](const CampaignScore& score) { return score.faint_found; }),
                 {.least = static_cast<double>(all.faint_leaks)}},
                {"findings without a leak, and duplicates", static_cast<double>(all.false_findings),
                 each(scores, [](const CampaignScore& score) { return score.false_findings; }),
                 kNone, "false_findings"},
                {"position error of a leak, 95 %, m", p95(all), each(scores, p95), kSmallIsGood,
                 "finding_position_p95_m"},
                {"truth inside the 95 % ellipse in the plane, %",
                 all.level_coverage_percent(),
                 each(scores, &CampaignScore::level_coverage_percent),
                 {.least = 90, .most = 99},
                 "finding_coverage95_percent"},
                {"truth inside the 95 % ellipsoid, %", all.coverage_percent(),
                 each(scores, &CampaignScore::coverage_percent), kLargeIsGood},
                {"detections until a leak is raised, largest",
                 static_cast<double>(slowest(all)),
                 each(scores, slowest),
                 {.most = 3}}});
  }

  static CampaignScore sum_of(const std::vector<CampaignScore>& scores) {
    CampaignScore all;
    for (const CampaignScore& score : scores) {
      all += score;
    }
    return all;
  }

  static std::string text_of(const leak_study::CampaignSettings& world) {
    return std::to_string(world.sequences) + " sequences of " + number(world.length) + " m with " +
           std::to_string(world.faint_leaks + world.near_leaks + world.other_leaks) +
           " leaks and " + std::to_string(world.decoys) + " decoys";
  }

  /// What is found, in words and figures that begin with `name`.
  static std::vector<Measure> found_measures(const std::vector<CampaignScore>& scores,
                                             const std::string& name, double least_found,
                                             double most_false) {
    const CampaignScore all = sum_of(scores);
    return {
        {"leaks found, %", all.found_percent(), each(scores, &CampaignScore::found_percent),
         at_least(least_found), name + "_leaks_found_percent"},
        {"faint ones beside joints and posts found, %", all.near_percent(),
         each(scores, &CampaignScore::near_percent), at_least(80), name + "_near_found_percent"},
        {"findings without a leak, and duplicates, per km", all.false_per_km(),
         each(scores, &CampaignScore::false_per_km), at_most(most_false), name + "_false_per_km"}};
  }

  /// In a world that disagrees with what the camera is told.
  void add_world() {
    leak_study::InspectionSettings inspection;
    inspection.by_contrast = true;
    const std::string study = "Radiometry unlike what is told: " + text_of(extent_.world);
    const auto scores = run_campaigns(study, extent_.world, inspection);
    const CampaignScore all = sum_of(scores);
    std::vector<Measure> measures = found_measures(scores, "world", 97, 0.05);
    measures.push_back({"temperature inside its 95 % interval, %",
                        all.temperature_coverage_percent(),
                        each(scores, &CampaignScore::temperature_coverage_percent), within(90, 99),
                        "world_temperature_coverage95_percent"});
    measures.push_back({"half of the interval of a leak's Delta-T, over it: median",
                        all.relative_widths.empty() ? 0 : quantile(all.relative_widths, 0.5),
                        {},
                        kSmallIsGood});
    rows_.add_study(study, measures);
  }

  void add_automatic_gain() {
    leak_study::CampaignSettings world = extent_.world;
    world.automatic_gain = true;
    leak_study::InspectionSettings inspection;
    inspection.by_contrast = true;
    const std::string study = "The same in 8-bit video with automatic gain, by contrast alone";
    rows_.add_study(study, found_measures(run_campaigns(study, world, inspection), "agc", 95, 0.1));
  }

  void add_roc() {
    const std::string stage = "Leaks of 0.3 m over Delta-T and noise";
    const auto of_seeds = for_each_seed(progress_, stage, seeds_, [&](std::uint64_t seed) {
      return leak_study::run_roc(extent_.roc, {}, seed);
    });
    for (std::size_t noise = 0; noise < extent_.roc.netds.size(); ++noise) {
      std::vector<double> others;
      double metres = 0;
      for (const std::vector<RocScores>& scores : of_seeds) {
        others.insert(others.end(), scores[noise].of_others.begin(), scores[noise].of_others.end());
        metres += scores[noise].metres;
      }
      std::vector<Measure> measures;
      for (const auto& point : leak_study::roc_curve({}, others, metres, thresholds())) {
        measures.push_back({"false findings per km from " + number(point.threshold) + " K",
                            point.false_per_km,
                            {},
                            kSmallIsGood});
      }
      for (std::size_t rise = 0; rise < extent_.roc.rises.size(); ++rise) {
        add_curve(measures, of_seeds, noise, rise, others);
      }
      rows_.add_study(
          "ROC, NETD " + number(1000 * extent_.roc.netds[noise]) + " mK, leaks of 0.3 m", measures);
    }
  }

  void add_curve(std::vector<Measure>& measures,
                 const std::vector<std::vector<RocScores>>& of_seeds, std::size_t noise,
                 std::size_t rise, const std::vector<double>& others) const {
    std::vector<double> leaks;
    for (const std::vector<RocScores>& scores : of_seeds) {
      const std::vector<double>& more = scores[noise].of_leaks[rise];
      leaks.insert(leaks.end(), more.begin(), more.end());
    }
    const std::string name = "Delta-T " + number(extent_.roc.rises[rise]) + " K: ";
    measures.push_back(
        {name + "area under the curve", leak_study::roc_area(leaks, others), {}, kLargeIsGood});
    for (const auto& point : leak_study::roc_curve(leaks, {}, 0, thresholds())) {
      measures.push_back({name + "found from " + number(point.threshold) + " K, %",
                          point.found_percent,
                          {},
                          kLargeIsGood});
    }
  }

  /// K, of a finding's Delta-T.
  static std::vector<double> thresholds() { return {20, 35, 50, 70}; }

  const ReproduceOptions& options_;
  const LeaksExtent& extent_;
  std::ostream& out_;
  std::vector<std::uint64_t> seeds_;
  Reproduction result_;
  FigureRows rows_;
  StageProgress progress_;
};

}  // namespace

Reproduction reproduce_leaks(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_leaks(options, LeaksExtent{}, out);
}

Reproduction reproduce_leaks(const ReproduceOptions& options, const LeaksExtent& extent,
                             std::ostream& out) {
  return Leaks(options, extent, out).run();
}

}  // namespace pipescout::reproduce
