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
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::ImageFlightScore;
using rack_study::ImageFlightSettings;

constexpr double kTurningSpeed = 0.5;  // m/s
constexpr double kTurningRate = 0.2;   // rad/s
constexpr double kMostOfOther = 1.3;   // times the error of the camera that is compared with

/// To and fro along the rack on beams, turning all the way.
ImageFlightSettings turning_flight(double duration) {
  constexpr double kMiddle = 0.88;  // m, rack x, of the four pipes
  constexpr double kHeight = 2.8;   // m
  constexpr double kFirst = 2.5;    // m, rack y
  constexpr double kLast = 7.5;     // m
  constexpr double kHalfTurn = 0.5 * kTurningRate * (kLast - kFirst) / kTurningSpeed;
  ImageFlightSettings settings;
  settings.scene.model = rack_study::rack_on_beams();
  settings.flight.duration = duration;
  settings.flight.largest_speed = kTurningSpeed;
  settings.flight.largest_yaw_rate = kTurningRate;
  const int legs = static_cast<int>(duration * kTurningSpeed / (kLast - kFirst)) + 1;
  for (int i = 0; i <= legs; ++i) {
    const bool there = i % 2 != 0;
    settings.way_points.push_back({.position = {kMiddle, there ? kLast : kFirst, kHeight},
                                   .yaw = there ? kHalfTurn : -kHalfTurn,
                                   .hold = 0});
  }
  return settings;
}

ImageFlightSettings with_row_skew(ImageFlightSettings settings) {
  constexpr double kSkew = 0.008;  // s, from the first row to the last
  settings.sensor.row_time = kSkew / settings.camera.parameters().height;
  settings.localization.tracker.row_time = settings.sensor.row_time;
  return settings;
}

ImageFlightSettings with_lens(ImageFlightSettings settings, geometry::LensModel lens) {
  geometry::CameraParameters camera;
  camera.focal_length = 400;  // pixels: an equidistant image then reaches 62 degrees off the axis
  camera.lens = lens;
  settings.camera = geometry::Camera(camera);
  return settings;
}

/// The larger one of position and orientation.
double error_ratio(const ImageFlightScore& score, const ImageFlightScore& other) {
  return std::max(
      error_quantile(score.position_errors, 0.5) / error_quantile(other.position_errors, 0.5),
      error_quantile(score.rotation_errors, 0.5) / error_quantile(other.rotation_errors, 0.5));
}

struct Comparison {
  std::string study;
  std::string of, with;  ///< the cameras
  std::string figure;
};

void compare(RackReproduction& run, const Comparison& names, const ImageFlightSettings& settings,
             const ImageFlightSettings& other) {
  const RackImageExtent& extent = run.extent.images;
  const auto seeds = seeds_of(run.options, std::min(run.seeds.size(), extent.largest_seeds));
  const auto fly = [&](const std::string& camera, const ImageFlightSettings& flight) {
    return for_each_seed(run.progress, names.study + ": " + camera, seeds, [&](std::uint64_t seed) {
      return rack_study::score_flight(rack_study::run_image_flight(flight, seed).frames);
    });
  };
  const auto scores = fly(names.of, settings);
  const auto others = fly(names.with, other);
  ImageFlightScore all;
  ImageFlightScore all_others;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    all += scores[i];
    all_others += others[i];
    ratios.push_back(error_ratio(scores[i], others[i]));
  }
  const auto tracked = [](const auto& of_seeds) {
    return each(of_seeds, &ImageFlightScore::with_pose_percent);
  };
  const auto median_position = [](const ImageFlightScore& score) {
    return error_quantile(score.position_errors, 0.5);
  };
  run.rows.add_study(
      names.study,
      {{"median error of " + names.of + " over that of " + names.with + ", the larger of both",
        error_ratio(all, all_others), ratios, at_most(kMostOfOther), names.figure},
       {"images with a pose, %, " + names.of, all.with_pose_percent(), tracked(scores),
        at_least(100.0)},
       {"the same, " + names.with, all_others.with_pose_percent(), tracked(others),
        at_least(100.0)},
       {"position error, median, m, " + names.of, median_position(all),
        each(scores, median_position), kSmallIsGood},
       {"the same, " + names.with, median_position(all_others), each(others, median_position),
        kSmallIsGood}});
}

}  // namespace

void reproduce_rack_cameras(RackReproduction& run) {
  const ImageFlightSettings flight = turning_flight(run.extent.images.cameras);
  compare(run,
          {"Rolling shutter, 8 ms, at 0.5 m/s and 0.2 rad/s", "a rolling shutter",
           "a global shutter", "row_skew_error_ratio"},
          with_row_skew(flight), flight);
  compare(run,
          {"Fisheye, the same flights", "an equidistant lens", "a pinhole", "fisheye_error_ratio"},
          with_lens(flight, geometry::LensModel::kEquidistant),
          with_lens(flight, geometry::LensModel::kBrown));
}

}  // namespace pipescout::reproduce
