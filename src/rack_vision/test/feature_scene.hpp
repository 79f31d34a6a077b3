// SPDX-License-Identifier: Apache-2.0
// Features of a rack as a camera of a known pose measures them, for tests of the solver.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/surface_points.hpp"
#include "rack_scenes.hpp"

namespace pipescout::rack_vision::test {

struct FeatureNoise {
  double sigma = 0;           ///< px, of u and of v
  double outlier_share = 0;   ///< of samples and of points
  double outlier_range = 30;  ///< px: outliers are off by up to this, in u and in v
};

struct Features {
  std::vector<EdgeSample> edges;
  std::vector<PointObservation> points;

  [[nodiscard]] PoseProblem problem(const geometry::SE3& T_camera_rack) const {
    PoseProblem result;
    result.T_camera_rack = T_camera_rack;
    result.edges = edges;
    result.points = points;
    return result;
  }
};

/// A rack of `count` parallel pipes of 10 m, with a reducer in the first; nothing else.
inline RackModel row_rack(int count) {
  std::vector<RowPipe> row{{"a", {{0, 0.15}, {4.8, 0.15}, {5.2, 0.2}, {10, 0.2}}}};
  for (int i = 1; i < count; ++i) {
    const double radius = 0.15 + 0.01 * i;
    row.push_back({std::string(1, static_cast<char>('a' + i)), {{0, radius}, {10, radius}}});
  }
  RackModel model;
  model.pipes = row_of_pipes(row);
  return model;
}

/// Above the middle of the rack, looking down, a little tilted.
inline geometry::SE3 above(double x = 0.6, double y = 5, double z = 2.7, double yaw = 0.1) {
  const geometry::SO3 R_rack_camera = geometry::SO3::about_z(yaw) *
                                      geometry::SO3::exp({0.06, -0.04, 0}) *
                                      geometry::SO3::about_x(3.14159265358979323846);
  return geometry::SE3(R_rack_camera, {x, y, z}).inverse();
}

/// Texture points on the upper side of parallel pipes, spread over [4, 6] along them.
inline std::vector<PointObservation> texture(const RackModel& model, int per_pipe, Engine& engine) {
  std::vector<PointObservation> points;
  for (std::uint16_t pipe = 0; pipe < model.pipes.size(); ++pipe) {
    for (int i = 0; i < per_pipe; ++i) {
      const double angle = uniform(engine, -1.2, 1.2);
      const Eigen::Vector3d out(std::sin(angle), 0, std::cos(angle));
      const Pipe& p = model.pipes[pipe];
      points.push_back(
          {.pipe = pipe,
           .place = p.start + uniform(engine, 4, 6) * p.direction + p.radii.back().radius * out});
    }
  }
  return points;
}

/// What is seen of the edges, at `per_edge` places each, and of the points.
inline Features measure(const RackModel& model, std::vector<double> offsets,
                        std::vector<PointObservation> points, const geometry::SE3& T_camera_rack,
                        const FeatureNoise& noise, Engine& engine, int per_edge = 20) {
  const geometry::Camera camera;
  Features result;
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, offsets, camera, T_camera_rack, edges);
  std::normal_distribution<double> normal;
  const auto disturb = [&](Eigen::Vector2d pixel) {
    if (uniform(engine, 0, 1) < noise.outlier_share) {
      const double r = noise.outlier_range;
      return Eigen::Vector2d(pixel.x() + uniform(engine, -r, r),
                             pixel.y() + uniform(engine, -r, r));
    }
    return Eigen::Vector2d(pixel.x() + noise.sigma * normal(engine),
                           pixel.y() + noise.sigma * normal(engine));
  };
  const double sigma = noise.sigma > 0 ? noise.sigma : 1;
  for (const VisibleEdge& edge : edges) {
    for (int j = 1; j <= per_edge; ++j) {
      const double part = j / (per_edge + 1.0);
      EdgeSample sample{.edge = edge.id, .sigma = sigma};
      sample.candidates[0] = disturb(edge.image_start + part * (edge.image_end - edge.image_start));
      result.edges.push_back(sample);
    }
  }
  for (PointObservation& point : points) {
    Eigen::Vector3d place = point.place;
    place.x() += offsets.empty() ? 0 : offsets[point.pipe];
    const auto pixel = camera.project(T_camera_rack * place);
    if (pixel && camera.contains(*pixel)) {
      point.pixel = disturb(*pixel);
      point.sigma = sigma;
      result.points.push_back(point);
    }
  }
  return result;
}

/// Difference of two poses in the form of the solver's covariance: place, rotation; rack axes.
inline geometry::Vector6d pose_error(const geometry::SE3& T_camera_rack,
                                     const geometry::SE3& truth) {
  const geometry::SE3 estimate = T_camera_rack.inverse();
  const geometry::SE3 reference = truth.inverse();
  geometry::Vector6d error;
  error << estimate.translation() - reference.translation(),
      (estimate.rotation() * reference.rotation().inverse()).log();
  return error;
}

}  // namespace pipescout::rack_vision::test
