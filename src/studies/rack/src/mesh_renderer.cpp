// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/mesh_renderer.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::rack_study {
namespace {

using Eigen::Vector3d;
using geometry::SE3;

constexpr int kFiner = 2;            // samples of a pixel, along u and along v
constexpr int kFacets = 128;         // around a pipe: 0.05 mm off at a radius of 0.15 m
constexpr double kNear = 0.05;       // m
constexpr double kShadowCell = 0.2;  // m
constexpr double kGround = -3.2;     // m, rack z
constexpr std::int16_t kNoBody = -1;

/// White noise of a lattice, 0..1.
float lattice(std::int64_t i, std::int64_t j, std::uint64_t salt) {
  auto h = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15U ^
           static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4FU ^ salt * 0x165667B19E3779F9U;
  h ^= h >> 31U;
  h *= 0xD6E8FEB86659FD93U;
  h ^= h >> 32U;
  return static_cast<float>(h >> 40U) * 0x1p-24F;
}

/// Smooth noise of wavelength 1, -1..1.
float smooth_noise(double x, double y, std::uint64_t salt) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto i = static_cast<std::int64_t>(fx);
  const auto j = static_cast<std::int64_t>(fy);
  const auto ease = [](double t) { return static_cast<float>(t * t * (3 - 2 * t)); };
  const float u = ease(x - fx);
  const float v = ease(y - fy);
  const float top = lattice(i, j, salt) + u * (lattice(i + 1, j, salt) - lattice(i, j, salt));
  const float bottom =
      lattice(i, j + 1, salt) + u * (lattice(i + 1, j + 1, salt) - lattice(i, j + 1, salt));
  return 2 * (top + v * (bottom - top)) - 1;
}

}  // namespace

void MeshScene::validate() const {
  model.validate();
  bodies.validate();
  validation::check_within("MeshScene.contrast", contrast, 0, 2);
  validation::check_within("MeshScene.noise", noise, 0, 100);
  validation::check_within("MeshScene.people", static_cast<double>(people), 0,
                           simulation::kMostPeople);
}

MeshRenderer::MeshRenderer(const MeshScene& scene, const geometry::Camera& camera)
    : scene_(scene), camera_(camera) {
  scene.validate();
  const geometry::CameraParameters& c = camera.parameters();
  if (camera.has_distortion() || c.skew != 0) {
    throw std::invalid_argument("MeshRenderer: the camera has distortion or skew");
  }
  width_ = kFiner * c.width;
  height_ = kFiner * c.height;
  const auto size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  nearness_.resize(size);
  body_.resize(size);
  radiance_.resize(size);
  blurred_.resize(size);
  std::mt19937_64 engine = statistics::make_engine(scene.seed, 0x3e5);
  to_sun_ =
      Vector3d(statistics::uniform(engine, -0.6, 0.1), statistics::uniform(engine, -0.3, 0.3), 1.0)
          .normalized();
  for (const rack_vision::Pipe& pipe : scene.model.pipes) {
    const auto paint = static_cast<float>(statistics::uniform(engine, 0.25, 0.75));
    add_pipe(pipe, paint, statistics::uniform(engine, 0, 1000));
  }
  for (const rack_vision::Support& support : scene.model.supports) {
    const auto paint = static_cast<float>(statistics::uniform(engine, 0.3, 0.45));
    add_box(support, paint, statistics::uniform(engine, 0, 1000));
  }
  add_bodies(engine);
  sort_by_shadow();
}

void MeshRenderer::add_bodies(std::mt19937_64& engine) {
  const auto add_cylinder = [this](const Vector3d& start, const Vector3d& direction, double length,
                                   double radius, float paint, double phase) {
    add_pipe({.name = {},
              .start = start,
              .direction = direction,
              .radii = {{0, radius}, {length, radius}}},
             paint, phase);
  };
  for (const simulation::SceneCylinder& cylinder : scene_.bodies.cylinders) {
    const auto paint = static_cast<float>(statistics::uniform(engine, 0.15, 0.75));
    add_cylinder(cylinder.start, cylinder.direction, cylinder.length, cylinder.radius, paint,
                 statistics::uniform(engine, 0, 1000));
  }
  for (const simulation::SceneBox& box : scene_.bodies.boxes) {
    const auto paint = static_cast<float>(statistics::uniform(engine, 0.15, 0.75));
    add_box({.name = {}, .lowest_corner = box.lowest_corner, .highest_corner = box.highest_corner},
            paint, statistics::uniform(engine, 0, 1000));
  }
  constexpr float kClothes = 0.2F;
  for (std::size_t i = 0; i < scene_.people; ++i) {
    add_cylinder(Vector3d::Zero(), Vector3d::UnitZ(), simulation::kPersonHeight,
                 simulation::kPersonRadius, kClothes, statistics::uniform(engine, 0, 1000));
  }
}

void MeshRenderer::place_people(std::span<const Vector3d> people) {
  if (people.size() != scene_.people) {
    throw std::invalid_argument("MeshRenderer: " + std::to_string(people.size()) +
                                " places of people; the scene has " +
                                std::to_string(scene_.people));
  }
  Body* person = bodies_.data() + (bodies_.size() - people.size());
  for (const Vector3d& place : people) {
    person->start = person->moved = place;
    ++person;
  }
}

void MeshRenderer::add_pipe(const rack_vision::Pipe& pipe, float paint, double phase) {
  const auto body = static_cast<std::int16_t>(bodies_.size());
  bodies_.push_back({.is_pipe = true,
                     .start = pipe.start,
                     .direction = pipe.direction,
                     .length = pipe.radii.back().along,
                     .radius = pipe.largest_radius(),
                     .paint = paint,
                     .phase = phase});
  const Vector3d side = pipe.direction.unitOrthogonal();
  const Vector3d other = pipe.direction.cross(side);
  const auto at = [&](const rack_vision::RadiusAt& ring, int facet) -> Vector3d {
    const double angle = 2 * std::numbers::pi * facet / kFacets;
    return pipe.start + ring.along * pipe.direction +
           ring.radius * (std::cos(angle) * side + std::sin(angle) * other);
  };
  const auto add = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c,
                       const Vector3d& outward) {
    const Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() > 0) {
      triangles_.push_back({{a, b, c}, normal.dot(outward) > 0 ? normal : Vector3d(-normal), body});
    }
  };
  for (int facet = 0; facet < kFacets; ++facet) {
    const rack_vision::RadiusAt axis_first{pipe.radii.front().along, 0};
    const rack_vision::RadiusAt axis_last{pipe.radii.back().along, 0};
    add(at(axis_first, 0), at(pipe.radii.front(), facet), at(pipe.radii.front(), facet + 1),
        -pipe.direction);
    add(at(axis_last, 0), at(pipe.radii.back(), facet), at(pipe.radii.back(), facet + 1),
        pipe.direction);
    for (std::size_t k = 0; k + 1 < pipe.radii.size(); ++k) {
      const rack_vision::RadiusAt& first = pipe.radii[k];
      const rack_vision::RadiusAt& last = pipe.radii[k + 1];
      const double angle = 2 * std::numbers::pi * (facet + 0.5) / kFacets;
      Vector3d outward = std::cos(angle) * side + std::sin(angle) * other;
      if (first.along == last.along) {
        outward = first.radius < last.radius ? Vector3d(-pipe.direction) : pipe.direction;
      }
      add(at(first, facet), at(first, facet + 1), at(last, facet), outward);
      add(at(first, facet + 1), at(last, facet + 1), at(last, facet), outward);
    }
  }
}

void MeshRenderer::add_box(const rack_vision::Support& support, float paint, double phase) {
  const auto body = static_cast<std::int16_t>(bodies_.size());
  bodies_.push_back({.lowest_corner = support.lowest_corner,
                     .highest_corner = support.highest_corner,
                     .paint = paint,
                     .phase = phase});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d& at = sign < 0 ? support.lowest_corner : support.highest_corner;
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      const auto corner = [&](bool high_u, bool high_v) {
        Vector3d result = at;
        result(u) = high_u ? support.highest_corner(u) : support.lowest_corner(u);
        result(v) = high_v ? support.highest_corner(v) : support.lowest_corner(v);
        return result;
      };
      const Vector3d normal = sign * Vector3d::Unit(axis);
      triangles_.push_back(
          {{corner(false, false), corner(true, false), corner(true, true)}, normal, body});
      triangles_.push_back(
          {{corner(false, false), corner(true, true), corner(false, true)}, normal, body});
    }
  }
}

void MeshRenderer::draw(const Triangle& triangle, const Intrinsics& intrinsics,
                        const SE3& T_camera_rack) {
  const Vector3d& moved = bodies_[static_cast<std::size_t>(triangle.body)].moved;
  std::array<Vector3d, 3> corners;
  std::array<Vector3d, 4> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    corners[i] = T_camera_rack * Vector3d(triangle.corners[i] + moved);
  }
  // What is nearer than the lens is cut off, which leaves three or four corners.
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& a = corners[i];
    const Vector3d& b = corners[(i + 1) % 3];
    if (a.z() >= kNear) {
      kept[count++] = a;
    }
    if ((a.z() >= kNear) != (b.z() >= kNear)) {
      kept[count++] = a + (kNear - a.z()) / (b.z() - a.z()) * (b - a);
    }
  }
  for (std::size_t i = 1; i + 1 < count; ++i) {
    draw_clipped({kept[0], kept[i], kept[i + 1]}, intrinsics, triangle.body);
  }
}

void MeshRenderer::draw_clipped(const std::array<Vector3d, 3>& corners,
                                const Intrinsics& intrinsics, std::int16_t body) {
  std::array<Eigen::Vector2d, 3> pixel;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d seen = intrinsics.matrix * corners[i];
    pixel[i] = seen.head<2>() / seen.z();
  }
  // 1 / depth is linear in the image: g . (u, v, 1).
  const Vector3d plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double distance = plane.dot(corners[0]);
  if (std::abs(distance) < 1e-12) {
    return;  // seen edge-on
  }
  const Vector3d g = intrinsics.inverse.transpose() * plane / distance;
  const auto [low, high] = std::minmax({pixel[0].y(), pixel[1].y(), pixel[2].y()});
  const int first = std::max(0, static_cast<int>(std::ceil(std::max(low, -1.0))));
  const int last =
      std::min(height_ - 1, static_cast<int>(std::floor(std::min(high, height_ + 1.0))));
  for (int v = first; v <= last; ++v) {
    double left = 1e9;
    double right = -1e9;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d& a = pixel[i];
      const Eigen::Vector2d& b = pixel[(i + 1) % 3];
      if ((a.y() <= v) == (b.y() <= v)) {
        continue;
      }
      const double u = a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, u);
      right = std::max(right, u);
    }
    const int begin = std::max(0, static_cast<int>(std::ceil(std::max(left, -1.0))));
    const int end =
        std::min(width_ - 1, static_cast<int>(std::floor(std::min(right, width_ + 1.0))));
    const auto row = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
    for (int u = begin; u <= end; ++u) {
      const auto nearness = static_cast<float>(g.x() * u + g.y() * v + g.z());
      const std::size_t at = row + static_cast<std::size_t>(u);
      if (nearness > nearness_[at]) {
        nearness_[at] = nearness;
        body_[at] = body;
      }
    }
  }
}

Eigen::Vector2d MeshRenderer::seen_by_sun(const Vector3d& place) const {
  return sun_axes_ * place;
}

std::size_t MeshRenderer::shadow_cell(const Eigen::Vector2d& seen) const {
  const Eigen::Array2d cell = ((seen - shadow_corner_).array() / kShadowCell)
                                  .floor()
                                  .max(0)
                                  .min(shadow_cells_.cast<double>().array() - 1);
  return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(shadow_cells_.x()) +
         static_cast<std::size_t>(cell.x());
}

void MeshRenderer::sort_by_shadow() {
  // Across the way to the sun; the second axis is where rack y lies, along most pipes.
  const Vector3d x = Vector3d::UnitY().cross(to_sun_).normalized();
  sun_axes_.row(0) = x;
  sun_axes_.row(1) = to_sun_.cross(x);
  const auto corners = [this](const Body& body) {
    const Eigen::Vector2d a = seen_by_sun(body.start);
    const Eigen::Vector2d b = seen_by_sun(body.start + body.length * body.direction);
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(body.radius);
    return std::pair<Eigen::Vector2d, Eigen::Vector2d>(a.cwiseMin(b) - reach,
                                                       a.cwiseMax(b) + reach);
  };
  Eigen::Vector2d last = Eigen::Vector2d::Constant(-1e9);
  shadow_corner_ = -last;
  for (const Body& body : bodies_) {
    if (body.is_pipe) {
      const auto [low, high] = corners(body);
      shadow_corner_ = shadow_corner_.cwiseMin(low);
      last = last.cwiseMax(high);
    }
  }
  shadow_cells_ = ((last - shadow_corner_) / kShadowCell).cast<int>() + Eigen::Vector2i::Ones();
  casters_.resize(static_cast<std::size_t>(shadow_cells_.prod()));
  for (std::size_t i = 0; i + scene_.people < bodies_.size(); ++i) {
    if (!bodies_[i].is_pipe) {
      continue;
    }
    const auto [low, high] = corners(bodies_[i]);
    for (double v = low.y(); v < high.y() + kShadowCell; v += kShadowCell) {
      for (double u = low.x(); u < high.x() + kShadowCell; u += kShadowCell) {
        std::vector<std::int16_t>& cell = casters_[shadow_cell({u, v})];
        if (cell.empty() || cell.back() != static_cast<std::int16_t>(i)) {
          cell.push_back(static_cast<std::int16_t>(i));
        }
      }
    }
  }
}

bool MeshRenderer::in_shadow(const Vector3d& place, std::int16_t body) const {
  const auto hides_sun = [&](std::int16_t i) {
    const Body& other = bodies_[static_cast<std::size_t>(i)];
    if (i == body) {
      return false;
    }
    // Where the way to the sun is nearest to the axis.
    const Vector3d from = place - other.start;
    const Vector3d across_from = from - other.direction.dot(from) * other.direction;
    const Vector3d across_sun = to_sun_ - other.direction.dot(to_sun_) * other.direction;
    const double t = -across_from.dot(across_sun) / std::max(1e-9, across_sun.squaredNorm());
    if (t <= 0 || (across_from + t * across_sun).norm() > other.radius) {
      return false;
    }
    const double along = other.direction.dot(from + t * to_sun_);
    return along > 0 && along < other.length;
  };
  const auto first_person = static_cast<std::int16_t>(bodies_.size() - scene_.people);
  for (auto i = first_person; i < static_cast<std::int16_t>(bodies_.size()); ++i) {
    if (hides_sun(i)) {
      return true;
    }
  }
  return std::ranges::any_of(casters_[shadow_cell(seen_by_sun(place))], hides_sun);
}

float MeshRenderer::radiance(const Vector3d& place, const Vector3d& eye, std::int16_t body) const {
  constexpr float kSky = 0.35F;
  constexpr float kSun = 0.65F;
  Vector3d normal = Vector3d::UnitZ();
  float paint = 0.3F;
  float gloss = 0;
  if (body == kNoBody) {
    paint *= 1 + 0.35F * smooth_noise(1.3 * place.x(), 1.3 * place.y(), 11) +
             0.15F * smooth_noise(17 * place.x(), 17 * place.y(), 12);
  } else if (const Body& seen = bodies_[static_cast<std::size_t>(body)]; seen.is_pipe) {
    const Vector3d from = place - seen.start;
    const double along = seen.direction.dot(from);
    normal = (from - along * seen.direction).normalized();
    constexpr double kEnd = 1e-4;  // m
    const bool at_end = along > seen.length - kEnd;
    if (at_end || along < kEnd) {
      normal = at_end ? seen.direction : Vector3d(-seen.direction);
    }
    const double around = seen.radius * std::atan2(normal.x(), normal.z());
    const float texture = 0.5F * smooth_noise(9 * along + seen.phase, 9 * around, scene_.seed) +
                          0.35F * smooth_noise(31 * along, 31 * around + seen.phase, scene_.seed) +
                          0.2F * smooth_noise(2 * along + seen.phase, 70 * around, scene_.seed);
    paint = seen.paint * std::max(0.2F, 1 + 0.6F * static_cast<float>(scene_.contrast) * texture);
    gloss = 0.12F;
  } else {
    const Vector3d middle = 0.5 * (seen.lowest_corner + seen.highest_corner);
    const Vector3d part =
        (place - middle).cwiseQuotient(0.5 * (seen.highest_corner - seen.lowest_corner));
    Eigen::Index axis = 0;
    part.cwiseAbs().maxCoeff(&axis);
    normal = std::copysign(1.0, part(axis)) * Vector3d::Unit(axis);
    paint = seen.paint * (1 + 0.2F * smooth_noise(12 * place.x() + seen.phase, 12 * place.y(), 13));
  }
  float light = kSky * static_cast<float>(0.5 + 0.5 * normal.z());
  const double facing = normal.dot(to_sun_);
  if (facing > 0 && !in_shadow(place, body)) {
    light += kSun * static_cast<float>(facing);
    const Vector3d between = ((eye - place).normalized() + to_sun_).normalized();
    gloss *= static_cast<float>(std::pow(std::max(0.0, normal.dot(between)), 40));
  } else {
    gloss = 0;
  }
  return paint * light + gloss;
}

void MeshRenderer::render(const SE3& T_camera_rack, std::uint64_t frame,
                          std::span<std::uint8_t> grey, std::span<const Vector3d> people) {
  const geometry::CameraParameters& c = camera_.parameters();
  if (grey.size() != static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height)) {
    throw std::invalid_argument("MeshRenderer: the image has " + std::to_string(grey.size()) +
                                " pixels, the camera " + std::to_string(c.width * c.height));
  }
  place_people(people);
  std::ranges::fill(nearness_, 0.0F);
  std::ranges::fill(body_, kNoBody);
  // Samples lie at (k + 0.5) / kFiner - 0.5 of a pixel.
  Eigen::Matrix3d K = camera_.matrix();
  K.topRows<2>() *= kFiner;
  K.topRightCorner<2, 1>().array() += 0.5 * kFiner - 0.5;
  const Intrinsics intrinsics{K, K.inverse()};
  const Vector3d eye = T_camera_rack.inverse().translation();
  for (const Triangle& triangle : triangles_) {
    const Vector3d& moved = bodies_[static_cast<std::size_t>(triangle.body)].moved;
    if (triangle.normal.dot(eye - triangle.corners[0] - moved) > 0) {
      draw(triangle, intrinsics, T_camera_rack);
    }
  }
  const Eigen::Matrix3d to_rack = T_camera_rack.rotation().inverse().matrix() * intrinsics.inverse;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                             static_cast<std::size_t>(u);
      const Vector3d ray = to_rack * Vector3d(u, v, 1);
      const double depth = body_[at] != kNoBody
                               ? 1 / static_cast<double>(nearness_[at])
                               : (ray.z() < -1e-6 ? (kGround - eye.z()) / ray.z() : 1e3);
      radiance_[at] = radiance(eye + depth * ray, eye, body_[at]);
    }
  }
  // A lens of half a pixel: 1, 2, 1 of samples, down and across.
  const auto blur = [&](const std::vector<float>& from, std::vector<float>& to, int step_u,
                        int step_v) {
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const auto value = [&](int side) {
          const int x = std::clamp(u + side * step_u, 0, width_ - 1);
          const int y = std::clamp(v + side * step_v, 0, height_ - 1);
          return from[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x)];
        };
        to[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u)] = 0.25F * (value(-1) + 2 * value(0) + value(1));
      }
    }
  };
  blur(radiance_, blurred_, 0, 1);
  blur(blurred_, radiance_, 1, 0);
  statistics::Engine engine = statistics::make_engine(scene_.seed, 0x4000 + frame);
  constexpr float kGain = 255;
  for (int v = 0; v < c.height; ++v) {
    for (int u = 0; u < c.width; ++u) {
      float sum = 0;
      for (int j = 0; j < kFiner; ++j) {
        for (int i = 0; i < kFiner; ++i) {
          sum += radiance_[static_cast<std::size_t>(kFiner * v + j) *
                               static_cast<std::size_t>(width_) +
                           static_cast<std::size_t>(kFiner * u + i)];
        }
      }
      const double level = static_cast<double>(kGain * sum / (kFiner * kFiner)) +
                           scene_.noise * statistics::normal(engine);
      grey[static_cast<std::size_t>(v * c.width + u)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
    }
  }
}

}  // namespace pipescout::rack_study
