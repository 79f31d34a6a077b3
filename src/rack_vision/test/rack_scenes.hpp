// SPDX-License-Identifier: Apache-2.0
// Racks, poses and a slow and simple judge of what hides what, for tests.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <pipescout/geometry/se3.hpp>
#include <random>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision::test {

using Engine = std::mt19937_64;

inline double uniform(Engine& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

/// Four parallel pipes, the first with a reducer; one across on top of them; six beams below.
inline RackModel small_rack() {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {4, 0.15}, {4.5, 0.2}, {10, 0.2}}},
                                 {"b", {{0, 0.15}, {10, 0.15}}},
                                 {"c", {{0, 0.2}, {10, 0.2}}},
                                 {"d", {{0, 0.18}, {10, 0.18}}}};
  RackModel model;
  model.pipes = row_of_pipes(row);
  model.pipes.push_back({.name = "across",
                         .start = {-1, 6, 0.4 + 0.16},
                         .direction = Eigen::Vector3d::UnitX(),
                         .radii = {{0, 0.16}, {4, 0.16}},
                         .movable = false});
  for (int i = 0; i < 6; ++i) {
    model.supports.push_back(
        {"beam " + std::to_string(i), {-0.2, 0.5 + 1.8 * i, -0.15}, {2.1, 0.65 + 1.8 * i, 0}});
  }
  return model;
}

/// Pose of a camera at `eye` whose optical axis meets `target`; `roll` about the optical axis, 0:
/// image x is as horizontal as can be, image down is as far down as can be.
inline geometry::SE3 looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                                double roll = 0) {
  const Eigen::Vector3d z = (target - eye).normalized();
  Eigen::Vector3d right = z.cross(Eigen::Vector3d::UnitZ());
  right = right.norm() > 1e-9 ? Eigen::Vector3d(right.normalized()) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d x = Eigen::AngleAxisd(roll, z) * right;
  Eigen::Matrix3d rotation;  // R_camera_rack
  rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
  const geometry::SO3 r = geometry::SO3::from_matrix(rotation);
  return geometry::SE3(r, r * Eigen::Vector3d(-eye));
}

/// Parallel pipes with steps and reducers, others across, slanting or upright, and beams; valid.
inline RackModel random_rack(Engine& engine) {
  RackModel model;
  const auto radii = [&](double length) {
    std::vector<RadiusAt> result{{0, uniform(engine, 0.05, 0.3)}};
    double along = 0;
    while (true) {
      const double kind = uniform(engine, 0, 1);
      if (kind < 0.3) {
        along += uniform(engine, 0.2, 2);  // a reducer
        result.push_back({along, uniform(engine, 0.05, 0.3)});
      } else if (kind < 0.5) {
        result.push_back({along, uniform(engine, 0.05, 0.3)});  // a step
      } else {
        along += uniform(engine, 0.5, 4);
        result.push_back({along, result.back().radius});
      }
      if (along >= length || result.size() > 8) {
        result.push_back({along + 1, result.back().radius});
        return result;
      }
    }
  };
  std::vector<RowPipe> row;
  const int parallel = 2 + static_cast<int>(uniform(engine, 0, 3));
  for (int i = 0; i < parallel; ++i) {
    row.push_back({"row " + std::to_string(i), radii(6), uniform(engine, 0, 0.3)});
  }
  model.pipes = row_of_pipes(row);
  const int others = static_cast<int>(uniform(engine, 0, 3));
  for (int i = 0; i < others; ++i) {
    Pipe pipe{.name = "other " + std::to_string(i),
              .start = {uniform(engine, -2, 2), uniform(engine, 0, 6), uniform(engine, -1, 2)},
              .direction = Eigen::Vector3d(uniform(engine, -1, 1), uniform(engine, -1, 1),
                                           uniform(engine, -1, 1))
                               .normalized(),
              .radii = radii(3),
              .movable = false};
    model.pipes.push_back(pipe);
    try {
      model.validate();
    } catch (const std::invalid_argument&) {
      model.pipes.pop_back();
    }
  }
  const int beams = static_cast<int>(uniform(engine, 0, 5));
  for (int i = 0; i < beams; ++i) {
    const double y = uniform(engine, 0, 6);
    const double top = uniform(engine, 0, 1) < 0.8 ? 0 : uniform(engine, 0.5, 1);
    model.supports.push_back({"beam " + std::to_string(i),
                              {-0.3, y, top - uniform(engine, 0.05, 0.3)},
                              {uniform(engine, 0.5, 2.5), y + uniform(engine, 0.05, 0.4), top}});
  }
  return model;
}

/// From above, beside, below or between the pipes, near or far, any roll.
inline geometry::SE3 random_pose(Engine& engine) {
  const Eigen::Vector3d target(uniform(engine, -0.5, 2.5), uniform(engine, 0, 6),
                               uniform(engine, -0.2, 0.8));
  const double far = uniform(engine, 0, 1) < 0.3 ? 1.0 : 4.0;
  Eigen::Vector3d away(uniform(engine, -1, 1), uniform(engine, -1, 1), uniform(engine, -0.5, 1));
  away *= far / away.norm() * uniform(engine, 0.3, 1.2);
  return looking_at(target + away, target, uniform(engine, -3, 3));
}

inline Eigen::Vector3d eye_of(const geometry::SE3& T_camera_rack) {
  return T_camera_rack.inverse().translation();
}

inline std::vector<PipeSection> sections_of(const RackModel& model, std::size_t pipe,
                                            double offset = 0) {
  std::vector<PipeSection> sections;
  append_sections(model.pipes[pipe], offset, sections);
  return sections;
}

/// How far (m, about) a point is outside a body: below 0 within it, and a convex function.
inline double outside_of(const PipeSection& section, const Eigen::Vector3d& point) {
  const Eigen::Vector3d from_start = point - section.start;
  const double z = section.direction.dot(from_start);
  const double radius =
      section.radius_start + (section.radius_end - section.radius_start) * z / section.length;
  return std::max({(from_start - z * section.direction).norm() - radius, -z, z - section.length});
}

inline double outside_of(const Support& support, const Eigen::Vector3d& point) {
  return (support.lowest_corner - point).cwiseMax(point - support.highest_corner).maxCoeff();
}

/// How near to the inside of the body (m, about; below 0: within it) the way from `eye` to `point`
/// gets.
template <typename Body>
double clearance(const Body& body, const Eigen::Vector3d& eye, const Eigen::Vector3d& point) {
  const auto at = [&](double s) { return outside_of(body, eye + s * (point - eye)); };
  double low = 0;
  double high = 1;
  for (int i = 0; i < 80; ++i) {
    const double left = low + (high - low) / 3;
    const double right = high - (high - low) / 3;
    (at(left) < at(right) ? high : low) = at(left) < at(right) ? right : left;
  }
  return at((low + high) / 2);
}

/// The smallest clearance from all bodies of the rack but one: the section or support given.
inline double smallest_clearance(const RackModel& model, const Eigen::Vector3d& eye,
                                 const Eigen::Vector3d& point, int but_pipe, int but_section,
                                 int but_support) {
  double smallest = 1e9;
  for (std::size_t pipe = 0; pipe < model.pipes.size(); ++pipe) {
    const std::vector<PipeSection> sections = sections_of(model, pipe);
    for (std::size_t i = 0; i < sections.size(); ++i) {
      if (static_cast<int>(pipe) != but_pipe || static_cast<int>(i) != but_section) {
        smallest = std::min(smallest, clearance(sections[i], eye, point));
      }
    }
  }
  for (std::size_t i = 0; i < model.supports.size(); ++i) {
    if (static_cast<int>(i) != but_support) {
      smallest = std::min(smallest, clearance(model.supports[i], eye, point));
    }
  }
  return smallest;
}

}  // namespace pipescout::rack_vision::test
