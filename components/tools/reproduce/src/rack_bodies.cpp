// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/rack_bodies.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::ImageFlightScore;
using rack_study::ImageFlightSettings;

struct Case {
  std::string renderer;
  bool mesh = false;
};

/// Over the rack on beams and what the seed draws to lie on it.
ImageFlightSettings flight_over_bodies(const Case& of, double duration, bool in_the_file,
                                       std::uint64_t seed) {
  constexpr std::size_t kPeople = 2;
  ImageFlightSettings settings;
  settings.scene.model = rack_study::rack_on_beams();
  const rack_study::FittedRack fitted = rack_study::fit_out(settings.scene.model, seed);
  settings.scene.bodies = fitted.bodies;
  settings.scene.people = kPeople;
  settings.rack_file = in_the_file ? fitted.with_bodies : settings.scene.model;
  settings.way_points = rack_study::inspection_way_points(duration, seed);
  settings.flight.duration = duration;
  if (of.mesh) {
    settings.mesh.emplace();
  }
  return settings;
}

ImageFlightScore all_of(const std::vector<ImageFlightScore>& scores) {
  ImageFlightScore all;
  for (const ImageFlightScore& score : scores) {
    all += score;
  }
  return all;
}

}  // namespace

void reproduce_rack_bodies(RackReproduction& run) {
  const RackImageExtent& extent = run.extent.images;
  const auto seeds = seeds_of(run.options, std::min(run.seeds.size(), extent.largest_seeds));
  ImageFlightScore everything;
  const auto fly = [&](const std::string& study, const Case& of, bool in_the_file) {
    const auto scores = for_each_seed(run.progress, study, seeds, [&](std::uint64_t seed) {
      return rack_study::score_flight(
          rack_study::run_image_flight(flight_over_bodies(of, extent.bodies, in_the_file, seed),
                                       seed)
              .frames);
    });
    everything += all_of(scores);
    return scores;
  };
  const auto p95 = [](const ImageFlightScore& score) {
    return error_quantile(score.position_errors, 0.95);
  };
  std::size_t silent = 0;
  for (const Case& of : {Case{"rays", false}, Case{"a mesh", true}}) {
    const std::string study =
        "Flanges, lagging, valves, a tray, people; rendered by " + of.renderer;
    const auto without = fly(study + ", not in the file", of, false);
    const auto with = fly(study + ", in the file", of, true);
    silent += all_of(without).silent_wrong + all_of(with).silent_wrong;
    const auto tracked = [](const auto& scores) {
      return each(scores, &ImageFlightScore::with_pose_percent);
    };
    const std::string name = of.mesh ? "bodies_mesh_" : "bodies_rays_";
    run.rows.add_study(
        study, {{"images with a pose, %, not in the file", all_of(without).with_pose_percent(),
                 tracked(without), at_least(100.0), name + "tracked_percent"},
                {"the same, in the file", all_of(with).with_pose_percent(), tracked(with),
                 at_least(100.0), name + "given_tracked_percent"},
                {"position error, 95 %, m, not in the file", p95(all_of(without)),
                 each(without, p95), kSmallIsGood, name + "position_p95_m"},
                {"the same, in the file", p95(all_of(with)), each(with, p95), kSmallIsGood,
                 name + "given_position_p95_m"}});
  }
  run.rows.add_study("All flights over flanges, lagging, valves, a tray and people",
                     {{"images with a pose off by 3 cm or 1 degree that its covariance denies",
                       static_cast<double>(silent),
                       {},
                       kNone,
                       "bodies_silent_wrong"},
                      {"truth in the ellipsoid that should hold it in 99 of 100 images, %",
                       percent(everything.pose_covered_99, everything.with_pose),
                       {},
                       within(97.0, 99.9),
                       "bodies_coverage99_percent"}});
}

}  // namespace pipescout::reproduce
