// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/odometry_study/quantile.hpp"
#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/misplaced_pipes.hpp"
#include "pipescout/rack_study/paper_flight.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::ImageFlightScore;
using rack_study::ImageFlightSettings;
using rack_study::MisplacedPipesScore;
using rack_study::MisplacedPipesSettings;
using rack_study::World;

constexpr std::array kWorlds{World::kRayCaster, World::kMesh};

/// Images of two renderers that have nothing in common, with noise and with pipes that lie
/// elsewhere than the rack file has them.
class RackWorlds {
 public:
  explicit RackWorlds(RackReproduction& run)
      : options_(run.options),
        extent_(run.extent.images),
        rows_(run.rows),
        progress_(run.progress) {}

  void run() {
    fly_in_noise();
    misplace("6 cm", 0.06, 0, options_.trials.value_or(extent_.misplaced),
             {"offsets_wrong_silent", "offsets_wrong_converged_percent"}, at_least(95.0));
    misplace("25 cm", 0.25, 0.15, options_.trials.value_or(extent_.misplaced_far),
             {"offsets_far_silent", "offsets_far_converged_percent"}, at_least(80.0));
    figure_8();
    rows_.add_study("Poses over pipes that are not where the rack file has them, both renderers",
                    {{"truth in the ellipsoid that should hold it in 99 of 100 images, %",
                      percent(all_.images_covered, all_.images_with_pose),
                      {},
                      within(97.0, 99.9),
                      "coverage99_percent"}});
  }

 private:
  struct NoiseCell {
    World world = World::kRayCaster;
    bool textured = false;
    double sigma = 0;
  };

  void fly_in_noise() {
    std::vector<NoiseCell> cells;
    for (const World world : kWorlds) {
      for (const bool textured : {false, true}) {
        for (const double sigma : {0.0, 3.0, 10.0, 20.0, 25.0}) {
          cells.push_back({world, textured, sigma});
        }
      }
    }
    const auto seeds = seeds_of(options_, cells.size());
    const std::string study =
        "Plain and textured pipes, noise of 0, 3, 10, 20 and 25 grey levels, " +
        std::to_string(std::lround(extent_.noise)) + " s each";
    const auto scores = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      const auto index = static_cast<std::size_t>(std::ranges::find(seeds, seed) - seeds.begin());
      return rack_study::score_flight(
          rack_study::run_image_flight(noisy_flight(cells[index], seed), seed).frames);
    });
    const auto median = [](const ImageFlightScore& score) {
      return score.position_errors.empty() ? 1.0
                                           : odometry_study::quantile(score.position_errors, 0.5);
    };
    const auto tracked = each(scores, &ImageFlightScore::with_pose_percent);
    const auto medians = each(scores, median);
    rows_.add_study(
        study, {{"images with a pose, %, worst flight", *std::ranges::min_element(tracked), tracked,
                 at_least(100.0), "noise_grid_tracked_percent"},
                {"position error, median, m, worst flight", largest(medians), medians, kSmallIsGood,
                 "noise_grid_position_m"}});
  }

  [[nodiscard]] ImageFlightSettings noisy_flight(const NoiseCell& cell, std::uint64_t seed) const {
    ImageFlightSettings settings;
    settings.scene.model = rack_study::rack_on_beams();
    settings.flight.duration = extent_.noise;
    settings.way_points = rack_study::inspection_way_points(extent_.noise, seed);
    settings.sensor.read_noise = cell.sigma;
    settings.sensor.electrons_per_level = 0;
    if (!cell.textured) {
      constexpr double kFar = 100;  // m: all of it
      settings.scene.plain = {{.from = -kFar, .to = kFar}};
    }
    if (cell.world == World::kMesh) {
      settings.mesh.emplace();
      settings.mesh->contrast = cell.textured ? 1 : 0;
      settings.mesh->noise = cell.sigma;
    }
    return settings;
  }

  struct Names {
    std::string silent, converged;
  };

  /// `stated`: what the localisation is told, m; 0: nothing.
  void misplace(const std::string& how_far, double largest_offset, double stated,
                std::size_t trials, const Names& names, const Target& converged) {
    const auto seeds = seeds_of(options_, std::min(trials, extent_.misplaced_places));
    const std::size_t each_place = trials / seeds.size();
    const std::string study = std::to_string(each_place * seeds.size()) +
                              " rack files with each pipe up to " + how_far +
                              " from its place, 3 s each";
    const auto scores = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      MisplacedPipesSettings settings;
      settings.rack = seed % 4 < 2 ? rack_study::rack_on_beams() : rack_study::parallel_rack(4);
      settings.world = kWorlds[seed % kWorlds.size()];
      settings.largest_offset = largest_offset;
      settings.stated_deviation = stated;
      return rack_study::score_misplaced_pipes(
          rack_study::try_misplaced_pipes(settings, each_place, seed));
    });
    MisplacedPipesScore all;
    for (const MisplacedPipesScore& score : scores) {
      all += score;
    }
    all_ += all;
    rows_.add_study(
        study,
        {{"with a pose off by 3 cm or 1 degree that its covariance denies",
          static_cast<double>(all.silent_wrong), each(scores, &MisplacedPipesScore::silent_wrong),
          kNone, names.silent},
         {"converged after 3 s, %", percent(all.converged, all.trials),
          each(scores, [](const auto& score) { return percent(score.converged, score.trials); }),
          converged, names.converged},
         {"without a pose after 3 s, %", percent(all.lost, all.trials),
          each(scores, [](const auto& score) { return percent(score.lost, score.trials); }),
          kSmallIsGood}});
  }

  /// Figure 8 of the paper: summed distances 15, 35 and 50 cm in the model, 10, 20 and 30 in truth.
  void figure_8() {
    constexpr std::array kFileOffsets{0.0, 0.05, 0.15, 0.20};  // m
    constexpr double kImages = 50;
    const auto seeds = seeds_of(options_, extent_.figure_8);
    const std::string study = "Figure 8 on images, 50 of them";
    const auto errors = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      MisplacedPipesSettings settings;
      settings.rack = rack_study::parallel_rack(4);
      settings.world = kWorlds[seed % kWorlds.size()];
      settings.stated_deviation = 0.2;
      settings.duration = kImages * rack_study::kFramePeriod;
      settings.start_position = 0.02;
      settings.start_rotation = 0.01;
      const auto trial = rack_study::try_misplaced_pipes(settings, kFileOffsets, seed);
      constexpr double kNone = 1;  // m, said of a flight without a pose at its end
      return trial.frames.back().has_pose ? trial.largest_offset_error : kNone;
    });
    rows_.add_study(study, {{"largest error of an offset, m, median of the flights",
                             odometry_study::quantile(errors, 0.5), errors, at_most(0.005),
                             "fig8_images_offsets_error_m"},
                            {"the same, worst flight", largest(errors), errors, kSmallIsGood,
                             "fig8_images_offsets_worst_m"}});
  }

  const ReproduceOptions& options_;
  const RackImageExtent& extent_;
  FigureRows& rows_;
  StageProgress& progress_;
  MisplacedPipesScore all_;
};

}  // namespace

void reproduce_rack_worlds(RackReproduction& run) {
  RackWorlds(run).run();
}

}  // namespace pipescout::reproduce
