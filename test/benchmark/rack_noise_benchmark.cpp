// SPDX-License-Identifier: Apache-2.0
// Which noise of the image our tracker and ViSP's stand, on the same images from the same first
// pose, off by 1 cm and 5 mrad.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <random>
#include <string>

#include "figures.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "rack_inputs.hpp"
#include "samples.hpp"
#include "visp_rack.hpp"
#include "visp_tracker.hpp"

namespace pipescout::benchmarks {
namespace {

using geometry::SE3;

constexpr double kStartPosition = 0.01;   // m, one sigma
constexpr double kStartRotation = 0.005;  // rad

struct Options {
  std::string json;
  std::uint64_t seed_base = 1001;
  std::size_t seeds = 2;
  std::size_t images = 150;
};

/// What a tracker made of the flights of one cell.
struct Outcome {
  std::size_t images = 0;
  std::size_t tracked = 0;  ///< with a pose within 30 cm and 5 degrees of the truth
  Samples position;         ///< m, of those tracked

  void add(const std::optional<SE3>& T_rack_camera, const SE3& truth) {
    constexpr double kLostPosition = 0.3;                           // m
    constexpr double kLostRotation = 5.0 * std::numbers::pi / 180;  // rad
    ++images;
    if (!T_rack_camera) {
      return;
    }
    const double error = (T_rack_camera->translation() - truth.translation()).norm();
    const double turn = (T_rack_camera->rotation().inverse() * truth.rotation()).log().norm();
    if (error < kLostPosition && turn < kLostRotation) {
      ++tracked;
      position.add(error);
    }
  }
  [[nodiscard]] double percent() const {
    return 100.0 * static_cast<double>(tracked) / static_cast<double>(images);
  }
};

SE3 first_pose(const RackFlight& flight, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  geometry::Vector6d error;
  for (int i = 0; i < 6; ++i) {
    error(i) = (i < 3 ? kStartPosition : kStartRotation) * normal(engine);
  }
  const SE3& truth = flight.T_rack_camera.front();
  return {geometry::SO3::exp(error.tail<3>()) * truth.rotation(),
          truth.translation() + error.head<3>()};
}

void track_by_ours(const RackFlight& flight, const SE3& first, Outcome& outcome) {
  geometry::Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kStartPosition), Eigen::Vector3d::Constant(kStartRotation);
  rack_vision::RackTracker tracker(benchmark_rack(), flight.camera);
  tracker.set_pose(first, geometry::Matrix6d(sigma.cwiseAbs2().asDiagonal()));
  for (std::size_t i = 0; i < flight.size(); ++i) {
    const auto result = tracker.track(flight.image(i), kImagePeriod * static_cast<double>(i));
    const bool tracking = result.status == rack_vision::TrackStatus::kTracking;
    outcome.add(tracking ? std::optional(result.T_rack_camera) : std::nullopt,
                flight.T_rack_camera[i]);
  }
}

void track_by_visp(const RackFlight& flight, const SE3& first, Outcome& outcome) {
  VispTracker tracker(rack_cao(benchmark_rack()), visp_camera(flight.camera));
  tracker.start(flight.image(0).pixels, first.inverse().matrix());
  bool lost = false;
  for (std::size_t i = 0; i < flight.size(); ++i) {
    const auto pose = lost ? std::nullopt : tracker.track(flight.image(i).pixels);
    lost = !pose;  // it does not find back
    outcome.add(pose ? std::optional(SE3::from_matrix(*pose).inverse()) : std::nullopt,
                flight.T_rack_camera[i]);
  }
}

Figures measure(const Options& options) {
  Figures figures;
  double ours_percent = 100;  // of the worst cell that the peer tracks
  double error_ratio = 0;
  for (std::size_t i = 0; i < options.seeds; ++i) {
    figures.add_seed(options.seed_base + i);
  }
  for (const bool textured : {false, true}) {
    for (const double noise : {0.0, 3.0, 10.0, 20.0, 25.0}) {
      Outcome ours;
      Outcome visp;
      for (std::size_t i = 0; i < options.seeds; ++i) {
        const std::uint64_t seed = options.seed_base + i;
        const RackFlight flight = rack_flight(seed, textured, options.images, noise);
        const SE3 first = first_pose(flight, seed);
        track_by_ours(flight, first, ours);
        track_by_visp(flight, first, visp);
      }
      constexpr double kAll = 100;
      if (visp.percent() == kAll) {
        ours_percent = std::min(ours_percent, ours.percent());
        error_ratio = std::max(error_ratio, ours.position.median() / visp.position.median());
      }
      figures.add_row({{"case", std::string(textured ? "worn" : "plain") + " paint, noise " +
                                    std::to_string(std::lround(noise))},
                       {"tracked_percent", ours.percent()},
                       {"visp_tracked_percent", visp.percent()},
                       {"position_median_m", ours.position.median()},
                       {"visp_position_median_m", visp.position.median()}});
    }
  }
  figures.add("noise_tracked_percent_where_visp_does", ours_percent, Figures::Bound::kAtLeast, 100);
  figures.add("noise_error_ratio_vs_visp", error_ratio, Figures::Bound::kAtMost, 1);
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  cv::setNumThreads(1);
  pb::Options options;
  CLI::App app("Tracking over a rack in noisy images, beside ViSP");
  app.add_option("--json", options.json, "Write figures, rows and seeds to this file");
  app.add_option("--seed-base", options.seed_base, "First seed")->capture_default_str();
  app.add_option("--seeds", options.seeds, "Flights of each cell")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--images", options.images, "Of each flight, 25 a second")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const pb::Figures figures = pb::measure(options);
    figures.print(std::cout);
    if (!options.json.empty()) {
      figures.write_json(options.json);
    }
  } catch (const std::exception& error) {
    std::cerr << argv[0] << ": " << error.what() << '\n';
    return 1;
  }
  return 0;
}
