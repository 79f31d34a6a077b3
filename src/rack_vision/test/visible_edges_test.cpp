// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/visible_edges.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Camera;
using geometry::SE3;
using geometry::SO3;

constexpr double kFocalLength = 630;  // pixels, of the default camera
constexpr double kCentreU = 360;
constexpr double kCentreV = 240;

Pipe along_y(const std::string& name, const Vector3d& start, std::vector<RadiusAt> radii) {
  return {.name = name, .start = start, .radii = std::move(radii), .movable = false};
}

/// A pipe on the y axis and one that is nowhere near.
RackModel one_pipe(std::vector<RadiusAt> radii) {
  RackModel model;
  model.pipes.push_back(along_y("pipe", Vector3d::Zero(), std::move(radii)));
  model.pipes.push_back(along_y("far away", {1000, 0, 0}, {{0, 0.1}, {1, 0.1}}));
  model.validate();
  return model;
}

/// Looks straight down; image up is the direction of the flow.
SE3 looking_down(const Vector3d& eye) {
  const SO3 r = SO3::about_x(std::numbers::pi);
  return SE3(r, r * Vector3d(-eye));
}

std::vector<VisibleEdge> edges_of(const RackModel& model, const SE3& pose,
                                  const Camera& camera = Camera()) {
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, {}, camera, pose, edges);
  return edges;
}

std::vector<VisibleEdge> pieces_of(const std::vector<VisibleEdge>& edges, const EdgeId& id) {
  std::vector<VisibleEdge> pieces;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(pieces),
               [&](const VisibleEdge& edge) { return edge.id == id; });
  return pieces;
}

TEST(VisibleEdges, OfAPipeParallelToTheImageAreWhereEquations13And14PutThem) {
  const double radius = 0.2;
  const double height = 3;
  const auto edges = edges_of(one_pipe({{0, radius}, {10, radius}}), looking_down({0, 5, height}));
  ASSERT_EQ(edges.size(), 2U);
  const double aside = kFocalLength * radius / std::sqrt(height * height - radius * radius);
  const double depth = height - radius * radius / height;
  for (const std::size_t side : {0U, 1U}) {
    EXPECT_EQ(edges[side].id, (EdgeId{EdgeKind::kPipe, 0, 0, static_cast<std::uint8_t>(side)}));
    const double u = kCentreU + (side == 0 ? -aside : aside);
    // The image cuts both ends off: the flow goes from its lower border to the upper one.
    EXPECT_NEAR((edges[side].image_start - Vector2d(u, 479)).norm(), 0, 1e-9);
    EXPECT_NEAR((edges[side].image_end - Vector2d(u, 0)).norm(), 0, 1e-9);
    EXPECT_NEAR(edges[side].start.y(), 5 - depth * (479 - kCentreV) / kFocalLength, 1e-9);
    EXPECT_NEAR(edges[side].start.z(), radius * radius / height, 1e-12);
    EXPECT_EQ(edges[side].start.x() < 0, side == 0);
  }
}

TEST(VisibleEdges, EndWithThePipe) {
  const auto edges = edges_of(one_pipe({{0, 0.2}, {0.5, 0.2}}), looking_down({0, 0.2, 3}));
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_NEAR(edges[0].start.y(), 0, 1e-12);
  EXPECT_NEAR(edges[0].end.y(), 0.5, 1e-12);
}

TEST(VisibleEdges, FromBelowChangeSidesAsTheEquationsDo) {
  const SE3 looking_up(SO3(), Vector3d(0, -5, 3));
  const auto edges = edges_of(one_pipe({{0, 0.2}, {10, 0.2}}), looking_up);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_GT(edges[0].start.x(), 0);
  EXPECT_LT(edges[1].start.x(), 0);
}

TEST(VisibleEdges, MeetInTheVanishingPointWhenTheCameraLooksAlongThePipe) {
  const RackModel model = one_pipe({{0, 0.2}, {1000, 0.2}});
  const Vector3d eye(0, 1, 0.5);
  const auto edges = edges_of(model, test::looking_at(eye, eye + Vector3d::UnitY()));
  ASSERT_EQ(edges.size(), 2U);
  for (const VisibleEdge& edge : edges) {
    EXPECT_NEAR((edge.image_end - Vector2d(kCentreU, kCentreV)).norm(), 0, 1);
    const Vector2d along = edge.image_end - edge.image_start;
    const Vector2d to_vanishing_point = Vector2d(kCentreU, kCentreV) - edge.image_start;
    EXPECT_NEAR(
        (along.x() * to_vanishing_point.y() - along.y() * to_vanishing_point.x()) / along.norm(), 0,
        1e-9);
  }
}

TEST(VisibleEdges, OfAReducerAreWhereItsTangentPlanesAre) {
  const auto edges = edges_of(one_pipe({{0, 0.1}, {1, 0.3}}), looking_down({0, 0.5, 3}));
  ASSERT_EQ(edges.size(), 2U);
  const double slope = 0.2;
  for (const VisibleEdge& edge : edges) {
    // The tangent plane through the eye: e . (eye - axis) is the radius beside the eye, 0.2.
    const Vector3d e = Vector3d(edge.start.x(), 0, edge.start.z()) / 0.1;
    EXPECT_NEAR(e.norm(), 1, 1e-12);
    EXPECT_NEAR(e.z(), 0.2 / 3, 1e-12);
    const Vector3d normal = e - slope * Vector3d::UnitY();
    EXPECT_NEAR(normal.dot(edge.start - Vector3d(0, 0.5, 3)), 0, 1e-12);
    EXPECT_NEAR(normal.dot(edge.end - Vector3d(0, 0.5, 3)), 0, 1e-12);
  }
}

TEST(VisibleEdges, OfANarrowPieceEndWhereTheRimOfAStepCoversThem) {
  const auto edges = edges_of(one_pipe({{0, 0.1}, {2, 0.1}, {2, 0.3}, {4, 0.3}}),
                              test::looking_at({0.1, 3.5, 1.5}, {0, 1.5, 0}));
  for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}}) {
    const auto pieces = pieces_of(edges, {EdgeKind::kPipe, 0, 0, side});
    ASSERT_EQ(pieces.size(), 1U);
    const Vector3d eye(0.1, 3.5, 1.5);
    const Vector3d end = pieces[0].end;
    EXPECT_LT(end.y(), 2 - 0.1);
    const Vector3d at_rim = eye + (2 - eye.y()) / (end.y() - eye.y()) * (end - eye);
    EXPECT_NEAR(Vector3d(at_rim.x(), 0, at_rim.z()).norm(), 0.3, 2e-6);
  }
}

TEST(VisibleEdges, GoOnFromSectionToSectionOfOneRadius) {
  const auto edges =
      edges_of(one_pipe({{0, 0.2}, {1, 0.2}, {2, 0.2}}), test::looking_at({1, -1, 2}, {0, 1, 0}));
  ASSERT_EQ(edges.size(), 4U);
  for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}}) {
    const auto first = pieces_of(edges, {EdgeKind::kPipe, 0, 0, side});
    const auto second = pieces_of(edges, {EdgeKind::kPipe, 0, 1, side});
    ASSERT_EQ(first.size(), 1U);
    ASSERT_EQ(second.size(), 1U);
    EXPECT_NEAR((first[0].end - second[0].start).norm(), 0, 1e-9);
  }
}

TEST(VisibleEdges, AreCutWhereAnotherPipeCrossesAbove) {
  const RackModel model = test::small_rack();
  const SE3 pose = test::looking_at({0.8, 5, 3}, {0.8, 6, 0});
  const auto edges = edges_of(model, pose);
  const auto pieces = pieces_of(edges, {EdgeKind::kPipe, 2, 0, 1});
  ASSERT_EQ(pieces.size(), 2U);
  const auto near_line = pieces_of(edges, {EdgeKind::kPipe, 4, 0, 1});
  const auto far_line = pieces_of(edges, {EdgeKind::kPipe, 4, 0, 0});
  ASSERT_EQ(near_line.size(), 1U);
  ASSERT_EQ(far_line.size(), 1U);
  const auto distance = [](const VisibleEdge& line, const Vector2d& point) {
    const Vector3d through = line.image_start.homogeneous().cross(line.image_end.homogeneous());
    return std::abs(through.dot(point.homogeneous())) / through.head<2>().norm();
  };
  EXPECT_NEAR(distance(near_line[0], pieces[0].image_end), 0, 0.001);
  EXPECT_NEAR(distance(far_line[0], pieces[1].image_start), 0, 0.001);
  EXPECT_GT((pieces[1].image_start - pieces[0].image_end).norm(), 50);
}

TEST(VisibleEdges, OfAPipeThatCrossesBelowAreCutInstead) {
  RackModel model = test::small_rack();
  model.supports.clear();
  model.pipes[4].start.z() = -0.2;
  model.validate();
  const auto edges = edges_of(model, test::looking_at({0.8, 5, 3}, {0.8, 6, 0}));
  EXPECT_EQ(pieces_of(edges, {EdgeKind::kPipe, 2, 0, 1}).size(), 1U);
  EXPECT_GE(pieces_of(edges, {EdgeKind::kPipe, 4, 0, 1}).size(), 4U);
}

TEST(VisibleEdges, AreNoneFromWithinAPipeOrASupport) {
  const RackModel model = test::small_rack();
  EXPECT_TRUE(edges_of(model, looking_down({0.15, 2, 0.15})).empty());
  EXPECT_TRUE(edges_of(model, looking_down({1, 0.55, -0.05})).empty());
}

TEST(VisibleEdges, OfAPipeAreNoneFromItsEndAndItsAxis) {
  const RackModel model = one_pipe({{0, 0.2}, {10, 0.2}});
  for (const Vector3d& eye :
       {Vector3d(0, 0, 0), Vector3d(0, -1, 0), Vector3d(0.1, -1e-9, 0.05), Vector3d(0.2, -2, 0)}) {
    EXPECT_TRUE(edges_of(model, test::looking_at(eye, eye + Vector3d(0, 1, 0.1))).empty());
    EXPECT_TRUE(edges_of(model, looking_down(eye)).empty());
  }
}

TEST(VisibleEdges, OfAPipeAreFiniteFromItsSurface) {
  for (const double height : {0.2, 0.2 + 1e-15, 0.2 + 1e-9, 0.2001}) {
    const Vector3d eye(0, 5, height);
    for (const VisibleEdge& edge : edges_of(one_pipe({{0, 0.2}, {10, 0.2}}),
                                            test::looking_at(eye, eye + Vector3d(0, 1, 0)))) {
      EXPECT_TRUE(edge.image_start.allFinite() && edge.image_end.allFinite());
    }
  }
}

TEST(VisibleEdges, AreNoneWhenTheCameraLooksAway) {
  EXPECT_TRUE(edges_of(test::small_rack(), SE3(SO3(), Vector3d(-1, -5, -3))).empty());
}

TEST(VisibleEdges, OfASupportAreThoseOfTheFacesThatLookAtTheCamera) {
  RackModel model = one_pipe({{0, 0.1}, {1, 0.1}});
  model.pipes[0].start.x() = -1000;
  model.supports.push_back({"cube", {0, 0, 0}, {1, 1, 1}});
  model.validate();
  const Vector3d centre(0.5, 0.5, 0.5);
  const auto seen_from = [&](const Vector3d& eye) {
    return edges_of(model, test::looking_at(eye, centre)).size();
  };
  EXPECT_EQ(seen_from({0.5, 0.5, 5}), 4U);
  EXPECT_EQ(seen_from({3, 0.5, 5}), 7U);
  EXPECT_EQ(seen_from({3, 4, 5}), 9U);
  EXPECT_EQ(seen_from({-3, -4, -5}), 9U);
}

TEST(VisibleEdges, OfASupportAreHiddenInThePipeWhoseEndTheyEnter) {
  RackModel model = one_pipe({{0, 0.3}, {2, 0.3}});
  model.supports.push_back({"beam", {-0.1, -1, -0.1}, {0.1, 1, 0.1}});
  model.validate();
  const auto edges = edges_of(model, test::looking_at({0.3, -3, 2}, {0, 0, 0}));
  // Along y (axis 1), at the highest z (the axis after y) and x (the one after that).
  const auto pieces = pieces_of(edges, {EdgeKind::kSupport, 0, 4 + 1 + 2, 0});
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_NEAR(pieces[0].start.y(), -1, 1e-9);
  EXPECT_NEAR(pieces[0].end.y(), 0, 1e-5);
}

TEST(VisibleEdges, OfADistortedImageReachItsBorder) {
  geometry::CameraParameters parameters;
  parameters.k1 = -0.2;
  const Camera camera(parameters);
  const auto edges = edges_of(one_pipe({{0, 0.2}, {10, 0.2}}), looking_down({0, 5, 3}), camera);
  ASSERT_EQ(edges.size(), 2U);
  for (const VisibleEdge& edge : edges) {
    EXPECT_NEAR(camera.distort(edge.image_start)->y(), 479, 0.002);
    EXPECT_NEAR(camera.distort(edge.image_end)->y(), 0, 0.002);
  }
}

TEST(VisibleEdges, RefuseOffsetsThatDoNotFitThePipes) {
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  const RackModel model = test::small_rack();
  const std::vector<double> too_few(4);
  EXPECT_THROW(renderer.render(model, too_few, Camera(), SE3(), edges), std::invalid_argument);
  std::vector<double> not_finite(5);
  not_finite[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(renderer.render(model, not_finite, Camera(), SE3(), edges), std::invalid_argument);
}

TEST(VisibleEdges, RefuseAPoseThatIsNotFinite) {
  // SE3 takes no such value, but a product may overflow.
  const SE3 huge(SO3(), Vector3d(1.5e308, 0, 0));
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  EXPECT_THROW(renderer.render(test::small_rack(), {}, Camera(), huge * huge, edges),
               std::invalid_argument);
}

TEST(VisibleEdges, OfARackThatIsTooFarAwayAreNone) {
  for (const double distance : {1e7, 1e30, 1e154, 1e200, 1e308}) {
    EXPECT_TRUE(edges_of(test::small_rack(), SE3(SO3(), Vector3d(0, 0, distance))).empty());
    EXPECT_TRUE(edges_of(test::small_rack(), SE3(SO3(), Vector3d(distance, 0, -1))).empty());
  }
}

TEST(VisibleEdges, RefuseRacksBeyondTheirSizes) {
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  RackModel supports = one_pipe({{0, 0.1}, {1, 0.1}});
  supports.supports.resize(kMaxSupports + 1);
  EXPECT_THROW(renderer.render(supports, {}, Camera(), SE3(), edges), std::invalid_argument);
  RackModel sections = one_pipe({{0, 0.1}, {1, 0.1}});
  for (std::size_t i = 0; i < kMaxSections; ++i) {
    sections.pipes[0].radii.push_back({2.0 + static_cast<double>(i), 0.1});
  }
  EXPECT_THROW(renderer.render(sections, {}, Camera(), SE3(), edges), std::invalid_argument);
}

TEST(SupportEdge, NamesEachOfTheTwelveOnce) {
  const Support support{"box", {1, 2, 3}, {4, 6, 8}};
  std::vector<std::pair<Vector3d, Vector3d>> seen;
  double sum = 0;
  for (std::uint16_t part = 0; part < 12; ++part) {
    const SupportEdge edge = support_edge(support, part);
    const Vector3d along = edge.end - edge.start;
    EXPECT_EQ((along.array() > 0).count(), 1);
    EXPECT_GT(along[part / 4], 0);
    sum += along.sum();
    for (const auto& [start, end] : seen) {
      EXPECT_FALSE(start == edge.start && end == edge.end);
    }
    seen.emplace_back(edge.start, edge.end);
  }
  EXPECT_DOUBLE_EQ(sum, 4 * (3 + 4 + 5));
  EXPECT_THROW((void)support_edge(support, 12), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_vision
