// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/misplaced_pipes.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::ImageFlightScore;
using rack_study::ImageFlightSettings;
using rack_study::World;

struct NoiseCell {
  World world = World::kRayCaster;
  bool textured = false;
  double sigma = 0;
};

ImageFlightSettings noisy_flight(const NoiseCell& cell, double duration, std::uint64_t seed) {
  ImageFlightSettings settings;
  settings.scene.model = rack_study::rack_on_beams();
  settings.flight.duration = duration;
  settings.way_points = rack_study::inspection_way_points(duration, seed);
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

}  // namespace

void reproduce_rack_noise(RackReproduction& run) {
  const double duration = run.extent.images.noise;
  std::vector<NoiseCell> cells;
  for (const World world : {World::kRayCaster, World::kMesh}) {
    for (const bool textured : {false, true}) {
      for (const double sigma : {0.0, 3.0, 10.0, 20.0, 25.0}) {
        cells.push_back({world, textured, sigma});
      }
    }
  }
  const auto seeds = seeds_of(run.options, cells.size());
  const std::string study = "Plain and textured pipes, noise of 0, 3, 10, 20 and 25 grey levels, " +
                            std::to_string(std::lround(duration)) + " s each";
  const auto scores = for_each_seed(run.progress, study, seeds, [&](std::uint64_t seed) {
    const auto index = static_cast<std::size_t>(std::ranges::find(seeds, seed) - seeds.begin());
    return rack_study::score_flight(
        rack_study::run_image_flight(noisy_flight(cells[index], duration, seed), seed).frames);
  });
  const auto median = [](const ImageFlightScore& score) {
    return error_quantile(score.position_errors, 0.5);
  };
  const auto tracked = each(scores, &ImageFlightScore::with_pose_percent);
  const auto medians = each(scores, median);
  run.rows.add_study(
      study, {{"images with a pose, %, worst flight", *std::ranges::min_element(tracked), tracked,
               at_least(100.0), "noise_grid_tracked_percent"},
              {"position error, median, m, worst flight", largest(medians), medians, kSmallIsGood,
               "noise_grid_position_m"}});
}

}  // namespace pipescout::reproduce
