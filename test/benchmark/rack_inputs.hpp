// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// What the cases of the rack benchmark work on: simulated, the same in each run. Frames and
/// perturbations are those of rack_model.hpp and se3.hpp.
namespace pipescout::benchmarks {

/// Four parallel pipes of 10 m, radii 0.15 to 0.20 m, gaps of 0.10 m, on five beams: the paper's
/// rack without the reducer, since the peer knows no cones.
[[nodiscard]] rack_vision::RackModel benchmark_rack();

/// The paper's camera: 720 x 480, f = 630 pixels, no distortion, 25 images a second.
[[nodiscard]] geometry::Camera benchmark_camera();
inline constexpr double kImagePeriod = 0.04;  ///< s

/// Images of one flight, and where the camera truly was.
struct RackFlight {
  geometry::Camera camera;
  std::vector<geometry::SE3> T_rack_camera;  ///< one per image
  std::vector<std::uint8_t> pixels;          ///< all images, one after the other

  [[nodiscard]] std::size_t size() const { return T_rack_camera.size(); }
  [[nodiscard]] rack_vision::ImageView image(std::size_t index) const;
};

/// About 3 m above the rack, to and fro over it at up to 0.5 m/s and 0.2 rad/s, with the sway of
/// gusts. `textured`: rust and dirt on the pipes; else plain paint. `seed` draws the motion and the
/// scene. `noise`: standard deviation in grey levels, instead of the sensor's usual one.
[[nodiscard]] RackFlight rack_flight(std::uint64_t seed, bool textured, std::size_t images,
                                     std::optional<double> noise = {});

/// One frame of features, with the truth that they are noisy measurements of.
struct FeatureFrame {
  geometry::SE3 T_camera_rack;  ///< truth
  geometry::SE3 first_guess;    ///< 2 cm and 0.6 degrees beside it
  std::vector<rack_vision::EdgeSample> edges;
  std::vector<rack_vision::PointObservation> points;
};
/// 500 samples spread over all edges in view, 50 points on the pipes, noise 0.3 pixels.
[[nodiscard]] FeatureFrame feature_frame(const rack_vision::RackModel& model,
                                         const geometry::Camera& camera, std::uint64_t seed);

}  // namespace pipescout::benchmarks
