// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <pipescout/geometry/camera.hpp>
#include <pipescout/geometry/se3.hpp>
#include <pipescout/rack_vision/pose_solver.hpp>
#include <pipescout/rack_vision/rack_model.hpp>
#include <pipescout/rack_vision/surface_points.hpp>
#include <pipescout/rack_vision/visible_edges.hpp>
#include <random>
#include <vector>

/// The camera of Lippiello and Cacace's own simulation (section V): no image, but the detected
/// positions of the edges and texture points of a rack, with the errors of a detector. The data
/// association is always known and right.
namespace pipescout::simulation {

/// A recognisable point on the surface of a pipe.
struct TexturePoint {
  std::uint16_t pipe = 0;
  /// Rack frame, m, for the pipe's position in the model (offset 0).
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< outward, unit vector
};

/// `count` points in all, as many on each pipe as on any other (the first ones have one more when
/// it does not divide), uniform along each pipe and around it, at most `largest_angle` from its
/// uppermost line (pi: all around, pi / 2: the upper half). Ordered by pipe.
/// Throws std::invalid_argument when `largest_angle` is not in (0, pi] or the model has no pipes.
[[nodiscard]] std::vector<TexturePoint> random_texture_points(
    const rack_vision::RackModel& model, std::size_t count, std::uint64_t seed,
    double largest_angle = std::numbers::pi);

struct RackFeatureParameters {
  int samples_per_edge = 20;   ///< N, at j / (N + 1) of each visible piece of an edge, [0, 1000]
  double noise = 0.0;          ///< pixels, standard deviation of u and of v, [0, 100]
  bool quantised = false;      ///< to whole pixels, after the noise
  double outlier_share = 0.0;  ///< of edge samples and of points, [0, 1]
  /// Pixels; an outlier is uniform within this of the truth in u and in v. 0: uniform in the image.
  double outlier_reach = 0.0;     ///< [0, 1e4]
  double dropout_share = 0.0;     ///< share of features that are not detected, [0, 1]
  double least_deviation = 0.01;  ///< pixels, smallest stated sigma, [1e-6, 100]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Detections in one image, in the form of rack_vision::PoseProblem. Measured in pixels of the
/// (distorted) image, then undistorted. `sigma` includes noise and quantisation, not outliers.
struct RackFeatures {
  std::vector<rack_vision::EdgeSample> edges;  ///< in the order of EdgeRenderer, one candidate each
  std::vector<rack_vision::PointObservation> points;
  std::vector<std::size_t> point_ids;  ///< index of each of `points` in the given texture points
  // Ground truth.
  std::vector<bool> edge_is_outlier;   ///< per entry of `edges`
  std::vector<bool> point_is_outlier;  ///< per entry of `points`
};

class RackFeatureCamera {
 public:
  /// Throws as RackFeatureParameters::validate.
  RackFeatureCamera(const RackFeatureParameters& parameters, const geometry::Camera& camera,
                    std::uint64_t seed);

  /// `offsets`: true offsets of the pipes relative to the model. A sample of an edge is a point of
  /// its true contour. `features` is overwritten. Each image has independent noise. Throws
  /// std::invalid_argument as EdgeRenderer::render, and for a texture point on no pipe.
  void look(const rack_vision::RackModel& model, rack_vision::PipeOffsets offsets,
            const geometry::SE3& T_camera_rack, std::span<const TexturePoint> texture,
            RackFeatures& features);

 private:
  /// Detected ideal pixel for a true one; nothing when it is not detected.
  [[nodiscard]] bool measure(const Eigen::Vector2d& seen, Eigen::Vector2d& found, bool& outlier);

  RackFeatureParameters parameters_;
  geometry::Camera camera_;
  std::mt19937_64 engine_;
  double sigma_;
  rack_vision::EdgeRenderer renderer_;
  rack_vision::RackSurface surface_;
  std::vector<rack_vision::VisibleEdge> visible_;
};

}  // namespace pipescout::simulation
