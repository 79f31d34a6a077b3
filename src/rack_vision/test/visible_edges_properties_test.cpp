// SPDX-License-Identifier: Apache-2.0
// What holds for every rack and every pose: against the definition of a contour, and against a
// judge that walks along each ray.
#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <cstdlib>
#include <optional>

#include "pipescout/rack_vision/visible_edges.hpp"
#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// rapidcheck draws the seed; everything else follows from it.
test::Engine draw_engine() {
  return test::Engine(*rc::gen::resize(rc::kNominalSize, rc::gen::inRange<unsigned>(0, 1u << 30)));
}

geometry::Camera distorted_camera() {
  geometry::CameraParameters parameters;
  parameters.skew = 1.5;
  parameters.k1 = -0.25;
  parameters.k2 = 0.08;
  parameters.p1 = 0.001;
  parameters.p2 = -0.0015;
  return geometry::Camera(parameters);
}

PipeSection section_of(const RackModel& model, const EdgeId& id) {
  return test::sections_of(model, id.body)[id.part];
}

RC_GTEST_PROP(VisibleEdgesProperties, ContoursTouchTheSurfaceWhereItTurnsAway, ()) {
  test::Engine engine = draw_engine();
  const RackModel model = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  const Vector3d eye = test::eye_of(pose);
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, {}, geometry::Camera(), pose, edges);
  for (const VisibleEdge& edge : edges) {
    if (edge.id.kind != EdgeKind::kPipe) {
      continue;
    }
    const PipeSection section = section_of(model, edge.id);
    const double slope = (section.radius_end - section.radius_start) / section.length;
    for (const Vector3d& point : {edge.start, edge.end}) {
      const Vector3d from_start = point - section.start;
      const double z = section.direction.dot(from_start);
      const Vector3d radial = from_start - z * section.direction;
      const double radius = section.radius_start + slope * z;
      RC_ASSERT(z > -1e-9 && z < section.length + 1e-9);
      RC_ASSERT(std::abs(radial.norm() - radius) < 1e-9);
      const Vector3d normal = (radial.normalized() - slope * section.direction).normalized();
      RC_ASSERT(std::abs(normal.dot((point - eye).normalized())) < 1e-9);
      // The ray has one point in common with the cone: no discriminant.
      const Vector3d ray = (point - eye).normalized();
      const Vector3d across = ray - section.direction.dot(ray) * section.direction;
      const double growth = slope * section.direction.dot(ray);
      const double a = across.squaredNorm() - growth * growth;
      const double b = radial.dot(across) - radius * growth;
      const double c = radial.squaredNorm() - radius * radius;
      RC_ASSERT(std::abs(b * b - a * c) < 1e-9);
      // Equations (13) and (14) turn the direction to the axis to opposite sides.
      const Vector3d u =
          -(eye - section.start - section.direction.dot(eye - section.start) * section.direction);
      const double turn = section.direction.dot(u.cross(section.start + radial - eye));
      RC_ASSERT((edge.id.side == 0 ? turn : -turn) > 0);
    }
    RC_ASSERT(section.direction.dot(edge.end - edge.start) > 0);
  }
}

/// An edge without clipping and hiding.
struct WholeEdge {
  EdgeId id;
  Vector3d start, end;
};

std::vector<WholeEdge> all_edges(const RackModel& model, const Vector3d& eye) {
  std::vector<WholeEdge> edges;
  for (std::size_t pipe = 0; pipe < model.pipes.size(); ++pipe) {
    const std::vector<PipeSection> sections = test::sections_of(model, pipe);
    for (std::size_t i = 0; i < sections.size(); ++i) {
      ContourLine lines[2];
      if (contour_lines(sections[i], eye, lines)) {
        for (const int side : {0, 1}) {
          edges.push_back({{EdgeKind::kPipe, static_cast<std::uint16_t>(pipe),
                            static_cast<std::uint16_t>(i), static_cast<std::uint8_t>(side)},
                           lines[side].start,
                           lines[side].end});
        }
      }
    }
  }
  for (std::size_t i = 0; i < model.supports.size(); ++i) {
    for (std::uint16_t part = 0; part < 12; ++part) {
      const SupportEdge edge = support_edge(model.supports[i], part);
      edges.push_back(
          {{EdgeKind::kSupport, static_cast<std::uint16_t>(i), part, 0}, edge.start, edge.end});
    }
  }
  return edges;
}

bool within_a_body(const RackModel& model, const Vector3d& eye) {
  return test::smallest_clearance(model, eye, eye + Vector3d(1e-9, 0, 0), -1, -1, -1) < 1e-6;
}

/// How the samples of all edges of one scene were judged.
struct Score {
  int visible = 0;
  int hidden = 0;
};

void judge(const RackModel& model, const geometry::Camera& camera, const geometry::SE3& pose,
           Score& score) {
  constexpr double kSlack = 1e-5;  // m
  const Vector3d eye = test::eye_of(pose);
  EdgeRenderer renderer;
  std::vector<VisibleEdge> pieces;
  renderer.render(model, {}, camera, pose, pieces);
  for (const WholeEdge& edge : all_edges(model, eye)) {
    const Vector3d along = edge.end - edge.start;
    const bool is_pipe = edge.id.kind == EdgeKind::kPipe;
    const auto clear_at = [&](double part) {
      return test::smallest_clearance(model, eye, edge.start + part * along,
                                      is_pipe ? edge.id.body : -1, is_pipe ? edge.id.part : -1, -1);
    };
    const auto pixel_at = [&](double part) {
      return camera.project(pose * Vector3d(edge.start + part * along));
    };
    const auto drawn_at = [&](double part) {
      return std::any_of(pieces.begin(), pieces.end(), [&](const VisibleEdge& piece) {
        const auto place = [&](const Vector3d& point) {
          return along.dot(point - edge.start) / along.squaredNorm();
        };
        return piece.id == edge.id && part >= place(piece.start) && part <= place(piece.end);
      });
    };
    for (int i = 1; i < 24; ++i) {
      const double part = i / 24.0 + 1e-4;
      const std::optional<Vector2d> pixel = pixel_at(part);
      if (drawn_at(part)) {
        ++score.visible;
        RC_ASSERT(pixel.has_value());
        RC_ASSERT(camera.contains(*pixel, -0.01));
        RC_ASSERT(clear_at(part) >= -kSlack);
        continue;
      }
      if (!pixel || !camera.contains(*pixel, 0.2)) {
        continue;
      }
      ++score.hidden;
      // A visible piece that is too short to be drawn may be here, but not beside here.
      const std::optional<Vector2d> next = pixel_at(part + 1e-6);
      if (!next || (*next - *pixel).norm() < 1e-9) {
        continue;
      }
      const double shift = 1e-6 * 0.1 / (*next - *pixel).norm();
      const auto is_hidden = [&](double at) { return drawn_at(at) || clear_at(at) <= kSlack; };
      RC_ASSERT(is_hidden(part) || is_hidden(part - shift) || is_hidden(part + shift));
    }
  }
}

RC_GTEST_PROP(VisibleEdgesProperties, WhatIsHiddenAgreesWithWalkingAlongTheRays, ()) {
  test::Engine engine = draw_engine();
  const RackModel model = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  RC_PRE(!within_a_body(model, test::eye_of(pose)));
  Score score;
  judge(model, geometry::Camera(), pose, score);
  RC_CLASSIFY(score.visible > 20 && score.hidden > 20, "much visible and much hidden");
}

RC_GTEST_PROP(VisibleEdgesProperties, TheSameInAnImageWithDistortion, ()) {
  test::Engine engine = draw_engine();
  const RackModel model = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  RC_PRE(!within_a_body(model, test::eye_of(pose)));
  Score score;
  judge(model, distorted_camera(), pose, score);
  RC_CLASSIFY(score.visible > 20 && score.hidden > 20, "much visible and much hidden");
}

RC_GTEST_PROP(VisibleEdgesProperties, PixelsAreThoseOfTheEnds, ()) {
  test::Engine engine = draw_engine();
  const RackModel model = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  const geometry::Camera camera = distorted_camera();
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, {}, camera, pose, edges);
  for (const VisibleEdge& edge : edges) {
    const auto ideal = [&](const Vector3d& point) {
      return Vector2d((camera.matrix() * (pose * point)).hnormalized());
    };
    RC_ASSERT((ideal(edge.start) - edge.image_start).norm() < 1e-6);
    RC_ASSERT((ideal(edge.end) - edge.image_end).norm() < 1e-6);
    RC_ASSERT((edge.image_end - edge.image_start).norm() > 0.05);
    for (const Vector3d& point : {edge.start, edge.end}) {
      const std::optional<Vector2d> seen = camera.project(pose * point);
      RC_ASSERT(seen.has_value());
      RC_ASSERT(camera.contains(*seen, -1e-6));
    }
  }
}

RC_GTEST_PROP(VisibleEdgesProperties, ARendererRemembersNothing, ()) {
  test::Engine engine = draw_engine();
  const RackModel model = test::random_rack(engine);
  const RackModel other = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  const geometry::Camera camera;
  EdgeRenderer used;
  std::vector<VisibleEdge> edges;
  used.render(other, {}, distorted_camera(), test::random_pose(engine), edges);
  used.render(model, {}, camera, pose, edges);
  std::vector<VisibleEdge> again;
  EdgeRenderer().render(model, {}, camera, pose, again);
  RC_ASSERT(edges.size() == again.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    RC_ASSERT(edges[i].id == again[i].id);
    RC_ASSERT(edges[i].start == again[i].start);
    RC_ASSERT(edges[i].end == again[i].end);
    RC_ASSERT(edges[i].image_start == again[i].image_start);
    RC_ASSERT(edges[i].image_end == again[i].image_end);
  }
}

RC_GTEST_PROP(VisibleEdgesProperties, AnOffsetMovesThePipe, ()) {
  test::Engine engine = draw_engine();
  RackModel model = test::random_rack(engine);
  const geometry::SE3 pose = test::random_pose(engine);
  const geometry::Camera camera;
  std::vector<double> offsets(model.pipes.size(), 0.0);
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    offsets[i] = test::uniform(engine, -0.02, 0.02);
  }
  EdgeRenderer renderer;
  std::vector<VisibleEdge> with_offsets;
  renderer.render(model, offsets, camera, pose, with_offsets);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    model.pipes[i].start.x() += offsets[i];
  }
  std::vector<VisibleEdge> moved;
  renderer.render(model, {}, camera, pose, moved);
  RC_ASSERT(with_offsets.size() == moved.size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    RC_ASSERT(with_offsets[i].id == moved[i].id);
    RC_ASSERT((with_offsets[i].image_start - moved[i].image_start).norm() < 1e-6);
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
