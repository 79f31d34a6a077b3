// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipescout/statistics/draw.hpp"
#include "rack_image_scene.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr double kShortest = 0.25;  // m of contour that one piece of clutter hides
constexpr double kLongest = 0.9;
constexpr float kDark = 0.08F;

/// A cloth over the contour of a horizontal pipe, wide enough for oblique views.
Sheet draw_sheet(const Eigen::Vector3d& middle, const Eigen::Vector3d& direction, double radius,
                 double length, std::mt19937_64& engine) {
  const double turn = statistics::uniform(engine, -0.25, 0.25);
  const double angle = std::atan2(-direction.x(), direction.y()) + turn;
  Sheet sheet;
  sheet.centre = middle;
  sheet.centre.z() += radius * statistics::uniform(engine, 0.55, 1.05);
  sheet.cosine = std::cos(angle);
  sheet.sine = std::sin(angle);
  sheet.half_across = radius * statistics::uniform(engine, 0.5, 0.8);
  sheet.half_along = 0.5 * length;
  sheet.scallop = static_cast<float>(statistics::uniform(engine, 0.0, 0.03));
  sheet.albedo = statistics::uniform(engine) < 0.5
                     ? static_cast<float>(statistics::uniform(engine, 0.05, 0.15))
                     : static_cast<float>(statistics::uniform(engine, 0.35, 0.65));
  return sheet;
}

/// A cable or hose beside the pipe, nearly parallel to it: its edges imitate the contour.
Cone draw_cable(const Eigen::Vector3d& middle, const Eigen::Vector3d& direction,
                const Eigen::Vector3d& outward, double length, std::mt19937_64& engine) {
  Cone cable;
  const double skew = statistics::uniform(engine, -0.06, 0.06);
  cable.axis = (direction + skew * outward).normalized();
  cable.radius = statistics::uniform(engine, 0.015, 0.04);
  cable.length = length;
  // It lies on the flank: over the contour, and a little to either side of it.
  const Eigen::Vector3d place = middle + statistics::uniform(engine, -0.02, 0.03) * outward +
                                (cable.radius + 0.05) * Eigen::Vector3d::UnitZ();
  cable.start = place - 0.5 * length * cable.axis;
  cable.albedo = statistics::uniform(engine) < 0.6 ? kDark : 0.5F;
  cable.gloss = 0.2F;
  return cable;
}

}  // namespace

void add_clutter(const rack_vision::RackModel& model, double share, std::mt19937_64& engine,
                 Bodies& bodies) {
  if (share <= 0) {
    return;
  }
  const double mean_length = 0.5 * (kShortest + kLongest);
  const double mean_free = mean_length * (1 - share) / share;
  for (const rack_vision::Pipe& pipe : model.pipes) {
    const Eigen::Vector3d side = Eigen::Vector3d::UnitZ().cross(pipe.direction);
    if (side.norm() < 0.5) {
      continue;  // nothing lies on a riser
    }
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d outward = sign * side.normalized();
      double along = statistics::uniform(engine, 0, 1) * mean_free;
      while (along < pipe.length() && bodies.size() + 1 < kMostBodies) {
        const double length = statistics::uniform(engine, kShortest, kLongest);
        const double centre = along + 0.5 * length;
        double radius = pipe.radii.front().radius;
        for (std::size_t i = 1; i < pipe.radii.size(); ++i) {
          const rack_vision::RadiusAt& a = pipe.radii[i - 1];
          const rack_vision::RadiusAt& b = pipe.radii[i];
          if (centre >= a.along && b.along > a.along) {
            const double t = std::min(1.0, (centre - a.along) / (b.along - a.along));
            radius = a.radius + t * (b.radius - a.radius);
          }
        }
        const Eigen::Vector3d contour = pipe.start + centre * pipe.direction + radius * outward;
        if (statistics::uniform(engine) < 0.65) {
          bodies.sheets.push_back(draw_sheet(contour, pipe.direction, radius, length, engine));
        } else {
          bodies.cones.push_back(draw_cable(contour, pipe.direction, outward, length, engine));
        }
        along += length + mean_free * statistics::uniform(engine, 0.5, 1.5);
      }
    }
  }
}

}  // namespace pipescout::simulation::internal
