// SPDX-License-Identifier: Apache-2.0
// Racks, poses and segments for the tests of the first pose. Segments come from the edge renderer:
// broken, noisy, partly missing, among others that belong to nothing.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <pipescout/geometry/camera.hpp>
#include <pipescout/geometry/se3.hpp>
#include <random>
#include <vector>

#include "pipescout/rack_vision/first_pose.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "rack_scenes.hpp"

namespace pipescout::rack_vision::test {

/// Four parallel pipes, gaps of 0.1 m, one of which widens; one across below; beams every 2.5 m.
inline RackModel paper_rack() {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {4, 0.15}, {4.5, 0.2}, {10, 0.2}}},
                                 {"b", {{0, 0.15}, {10, 0.15}}},
                                 {"c", {{0, 0.2}, {10, 0.2}}},
                                 {"d", {{0, 0.17}, {10, 0.17}}}};
  RackModel model;
  model.pipes = row_of_pipes(row);
  model.pipes.push_back({.name = "across",
                         .start = {-1, 6.5, -0.2},
                         .direction = Eigen::Vector3d::UnitX(),
                         .radii = {{0, 0.15}, {4, 0.15}},
                         .movable = false});
  for (const double y : {0.5, 3.0, 5.2, 8.0}) {
    model.supports.push_back({"beam at " + std::to_string(y), {-0.3, y, -0.2}, {2.2, y + 0.15, 0}});
  }
  model.validate();
  return model;
}

/// Width of a row that begins at x = 0.
inline double row_width(const RackModel& model) {
  double right = 0;
  for (const Pipe& pipe : model.pipes) {
    if (std::abs(pipe.direction.y()) > 0.9) {
      right = std::max(right, pipe.start.x() + pipe.largest_radius());
    }
  }
  return right;
}

struct FlightPose {
  geometry::SE3 T_camera_rack;
  Eigen::Vector3d centre;
  double heading = 0;
};

/// R_camera_rack of a camera that looks down, turned by `heading`, then by roll and pitch about its
/// own axes.
inline geometry::SE3 looking_down(const Eigen::Vector3d& centre, double heading, double roll,
                                  double pitch) {
  using geometry::SO3;
  const SO3 R_rack_camera = SO3::about_z(heading) * SO3::about_x(std::numbers::pi) *
                            SO3::about_y(roll) * SO3::about_x(pitch);
  const SO3 R = R_rack_camera.inverse();
  return geometry::SE3(R, -(R * centre));
}

/// Height 1.5 to 5 m, roll and pitch up to 15 degrees, any heading, anywhere over the rack.
inline FlightPose random_flight_pose(Engine& engine, const RackModel& model) {
  const double tilt = 15 * std::numbers::pi / 180;
  FlightPose pose;
  pose.centre = {uniform(engine, 0, row_width(model)), uniform(engine, 0.5, 9.5),
                 uniform(engine, 1.5, 5)};
  pose.heading = uniform(engine, -std::numbers::pi, std::numbers::pi);
  pose.T_camera_rack = looking_down(pose.centre, pose.heading, uniform(engine, -tilt, tilt),
                                    uniform(engine, -tilt, tilt));
  return pose;
}

struct SegmentNoise {
  double sigma = 0.3;        ///< across, of each end, pixels
  double missing = 0.15;     ///< share of the pieces
  int parallel_lines = 4;    ///< on the ground, along the flow
  int random_segments = 25;  ///< anywhere in the image
};

inline std::vector<ImageSegment> segments_of(Engine& engine, const RackModel& model,
                                             const geometry::Camera& camera,
                                             const geometry::SE3& T_camera_rack,
                                             const SegmentNoise& noise) {
  std::normal_distribution<double> normal(0, noise.sigma);
  std::vector<ImageSegment> segments;
  const auto add_pieces = [&](Eigen::Vector2d a, Eigen::Vector2d b) {
    if (uniform(engine, 0, 1) < 0.5) {
      std::swap(a, b);
    }
    const double length = (b - a).norm();
    const Eigen::Vector2d along = (b - a) / length;
    const Eigen::Vector2d across(-along.y(), along.x());
    for (double at = uniform(engine, 0, 8); at < length;) {
      const double to = std::min(length, at + uniform(engine, 30, 200));
      if (to - at > 10 && uniform(engine, 0, 1) >= noise.missing) {
        segments.push_back({a + at * along + normal(engine) * across,
                            a + to * along + normal(engine) * across, 30});
      }
      at = to + uniform(engine, 2, 10);
    }
  };
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, {}, camera, T_camera_rack, edges);
  for (const VisibleEdge& edge : edges) {
    if ((edge.image_end - edge.image_start).norm() > 12) {
      add_pieces(edge.image_start, edge.image_end);
    }
  }
  for (int i = 0; i < noise.parallel_lines; ++i) {
    const double x = uniform(engine, -3, 5);
    const double y = uniform(engine, 0, 8);
    const auto start = camera.project(T_camera_rack * Eigen::Vector3d(x, y, -4));
    const auto end = camera.project(T_camera_rack * Eigen::Vector3d(x, y + 2, -4));
    if (start && end && camera.contains(*start) && camera.contains(*end)) {
      add_pieces(*start, *end);
    }
  }
  const double width = camera.parameters().width;
  const double height = camera.parameters().height;
  for (int i = 0; i < noise.random_segments; ++i) {
    const Eigen::Vector2d start(uniform(engine, 0, width), uniform(engine, 0, height));
    const double angle = uniform(engine, 0, 2 * std::numbers::pi);
    segments.push_back(
        {start, start + uniform(engine, 20, 90) * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
         20});
  }
  return segments;
}

struct PoseError {
  double across = 0;    ///< worst of x and height, m
  double along = 0;     ///< m
  double rotation = 0;  ///< rad
};

inline PoseError pose_error(const geometry::SE3& estimate, const geometry::SE3& truth) {
  const Eigen::Vector3d apart = estimate.inverse().translation() - truth.inverse().translation();
  return {std::max(std::abs(apart.x()), std::abs(apart.z())), std::abs(apart.y()),
          (estimate.rotation() * truth.rotation().inverse()).log().norm()};
}

}  // namespace pipescout::rack_vision::test
