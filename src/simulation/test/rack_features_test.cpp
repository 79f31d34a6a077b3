// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_features.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "rack_image_scenes.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const geometry::SE3 kPose = test::looking(true, {0.8, 4.9, 3}, {0.05, -0.04, 0.1});

/// Distance of an ideal pixel from the true contour of a cylinder or cone, pixels: that between its
/// ray and the tangent plane through the camera, in the closed form of a tangent plane.
double distance_from_contour(const rack_vision::PipeSection& section, const geometry::SE3& pose,
                             const geometry::Camera& camera, const Vector2d& pixel) {
  const Vector3d eye = pose.inverse().translation();
  const double slope = (section.radius_end - section.radius_start) / section.length;
  const Vector3d w = eye - section.start;
  const double along = w.dot(section.direction);
  const Vector3d beside = w - along * section.direction;
  const double cosine = (section.radius_start + slope * along) / beside.norm();
  const Vector3d towards = beside.normalized();
  double nearest = std::numeric_limits<double>::infinity();
  for (const double sign : {-1.0, 1.0}) {
    const Vector3d e =
        cosine * towards + sign * std::sqrt(1 - cosine * cosine) * section.direction.cross(towards);
    const Vector3d normal = pose.rotation() * (e - slope * section.direction);
    const Vector3d line = camera.inverse_matrix().transpose() * normal;
    nearest = std::min(nearest, std::abs(line.dot(pixel.homogeneous())) / line.head<2>().norm());
  }
  return nearest;
}

std::vector<rack_vision::PipeSection> sections_of(const rack_vision::Pipe& pipe, double offset) {
  std::vector<rack_vision::PipeSection> sections;
  rack_vision::append_sections(pipe, offset, sections);
  return sections;
}

geometry::Camera distorting_camera() {
  geometry::CameraParameters parameters;
  parameters.k1 = -0.2;
  parameters.k2 = 0.05;
  return geometry::Camera(parameters);
}

TEST(RackFeatures, WithoutErrorsLieOnContoursAndPoints) {
  const rack_vision::RackModel model = test::paper_rack();
  const std::array<double, 4> offsets = {0, 0.05, 0.02, -0.03};
  const std::vector<TexturePoint> texture = random_texture_points(model, 400, 3);
  for (const geometry::Camera& camera : {geometry::Camera(), distorting_camera()}) {
    RackFeatureCamera eye({}, camera, 1);
    RackFeatures found;
    eye.look(model, offsets, kPose, texture, found);
    ASSERT_GT(found.edges.size(), 100U);
    for (const rack_vision::EdgeSample& sample : found.edges) {
      ASSERT_EQ(sample.candidate_count, 1);
      EXPECT_EQ(sample.sigma, 0.01);
      if (sample.edge.kind == rack_vision::EdgeKind::kPipe) {
        const auto sections = sections_of(model.pipes[sample.edge.body], offsets[sample.edge.body]);
        EXPECT_LT(
            distance_from_contour(sections[sample.edge.part], kPose, camera, sample.candidates[0]),
            1e-6);
      }
    }
    ASSERT_GT(found.points.size(), 20U);
    ASSERT_EQ(found.points.size(), found.point_ids.size());
    for (std::size_t i = 0; i < found.points.size(); ++i) {
      const TexturePoint& point = texture[found.point_ids[i]];
      EXPECT_EQ(found.points[i].pipe, point.pipe);
      EXPECT_EQ(found.points[i].place, point.place);
      const Vector3d seen =
          camera.matrix() * (kPose * (point.place + offsets[point.pipe] * Vector3d::UnitX()));
      EXPECT_LT((seen.hnormalized() - found.points[i].pixel).norm(), 1e-6);
    }
  }
}

TEST(RackFeatures, SamplesDivideEachVisiblePiece) {
  const rack_vision::RackModel model = test::paper_rack();
  RackFeatureCamera eye({.samples_per_edge = 7}, geometry::Camera(), 1);
  RackFeatures found;
  eye.look(model, {}, kPose, {}, found);
  std::vector<rack_vision::VisibleEdge> edges;
  rack_vision::EdgeRenderer().render(model, {}, geometry::Camera(), kPose, edges);
  ASSERT_EQ(found.edges.size(), 7 * edges.size());
  for (std::size_t i = 0; i < found.edges.size(); ++i) {
    const rack_vision::VisibleEdge& edge = edges[i / 7];
    EXPECT_EQ(found.edges[i].edge, edge.id);
    const double share = static_cast<double>(i % 7 + 1) / 8;
    const Vector2d place = edge.image_start + share * (edge.image_end - edge.image_start);
    EXPECT_LT((found.edges[i].candidates[0] - place).norm(), 1e-9);
  }
}

TEST(RackFeatures, ErrorsAreAsStated) {
  const rack_vision::RackModel model = test::paper_rack();
  const std::vector<TexturePoint> texture = random_texture_points(model, 100, 3);
  RackFeatureCamera perfect({}, geometry::Camera(), 1);
  RackFeatures truth;
  perfect.look(model, {}, kPose, texture, truth);
  RackFeatureCamera noisy({.noise = 2, .quantised = true}, geometry::Camera(), 1);
  RackFeatures found;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  Vector2d mean = Vector2d::Zero();
  int count = 0;
  for (int frame = 0; frame < 60; ++frame) {
    noisy.look(model, {}, kPose, texture, found);
    ASSERT_EQ(found.edges.size(), truth.edges.size());
    ASSERT_EQ(found.points.size(), truth.points.size());
    const auto add = [&](const Vector2d& pixel, const Vector2d& place, double sigma) {
      EXPECT_NEAR(sigma, std::sqrt(4 + 1.0 / 12), 1e-12);
      EXPECT_LT((pixel - Vector2d(pixel.array().round())).norm(), 1e-9);
      covariance += (pixel - place) * (pixel - place).transpose();
      mean += pixel - place;
      ++count;
    };
    for (std::size_t i = 0; i < found.edges.size(); ++i) {
      add(found.edges[i].candidates[0], truth.edges[i].candidates[0], found.edges[i].sigma);
    }
    for (std::size_t i = 0; i < found.points.size(); ++i) {
      add(found.points[i].pixel, truth.points[i].pixel, found.points[i].sigma);
    }
  }
  const double variance = 4 + 1.0 / 12;
  EXPECT_LT((mean / count).norm(), 4 * std::sqrt(2 * variance / count));
  covariance /= count;
  EXPECT_NEAR(covariance(0, 0), variance, 4 * variance * std::sqrt(2.0 / count));
  EXPECT_NEAR(covariance(1, 1), variance, 4 * variance * std::sqrt(2.0 / count));
  EXPECT_NEAR(covariance(0, 1), 0, 4 * variance / std::sqrt(count));
}

TEST(RackFeatures, OutliersAndDropoutsHaveTheirShares) {
  const rack_vision::RackModel model = test::paper_rack();
  RackFeatures truth;
  RackFeatureCamera({}, geometry::Camera(), 1).look(model, {}, kPose, {}, truth);
  for (const double reach : {0.0, 25.0}) {
    RackFeatureCamera eye({.outlier_share = 0.3, .outlier_reach = reach}, geometry::Camera(), 4);
    RackFeatures found;
    int outliers = 0;
    int all = 0;
    double farthest = 0;
    for (int frame = 0; frame < 50; ++frame) {
      eye.look(model, {}, kPose, {}, found);
      ASSERT_EQ(found.edges.size(), truth.edges.size());
      for (std::size_t i = 0; i < found.edges.size(); ++i) {
        const double error =
            (found.edges[i].candidates[0] - truth.edges[i].candidates[0]).lpNorm<Eigen::Infinity>();
        ++all;
        if (found.edge_is_outlier[i]) {
          ++outliers;
          farthest = std::max(farthest, error);
        } else {
          EXPECT_LT(error, 1e-9);
        }
      }
    }
    EXPECT_NEAR(static_cast<double>(outliers) / all, 0.3, 4 * std::sqrt(0.21 / all));
    if (reach > 0) {
      EXPECT_LT(farthest, reach);
      EXPECT_GT(farthest, 0.9 * reach);
    } else {
      EXPECT_GT(farthest, 300);
    }
  }
  RackFeatureCamera eye({.dropout_share = 0.2}, geometry::Camera(), 4);
  RackFeatures found;
  std::size_t seen = 0;
  for (int frame = 0; frame < 50; ++frame) {
    eye.look(model, {}, kPose, {}, found);
    seen += found.edges.size();
  }
  const double all = 50.0 * static_cast<double>(truth.edges.size());
  EXPECT_NEAR(static_cast<double>(seen) / all, 0.8, 4 * std::sqrt(0.16 / all));
}

TEST(RackFeatures, AreTheSameForASeed) {
  const rack_vision::RackModel model = test::paper_rack();
  RackFeatures one;
  RackFeatures other;
  RackFeatureCamera({.noise = 1}, geometry::Camera(), 9).look(model, {}, kPose, {}, one);
  RackFeatureCamera({.noise = 1}, geometry::Camera(), 9).look(model, {}, kPose, {}, other);
  ASSERT_EQ(one.edges.size(), other.edges.size());
  for (std::size_t i = 0; i < one.edges.size(); ++i) {
    EXPECT_EQ(one.edges[i].candidates[0], other.edges[i].candidates[0]);
  }
}

TEST(RandomTexturePoints, LieOnTheirPipesInEqualNumbers) {
  const rack_vision::RackModel model = test::paper_rack();
  const std::vector<TexturePoint> points = random_texture_points(model, 402, 8);
  ASSERT_EQ(points.size(), 402U);
  std::map<int, int> counts;
  double mean_along = 0;
  double mean_up = 0;
  for (const TexturePoint& point : points) {
    ++counts[point.pipe];
    const rack_vision::Pipe& pipe = model.pipes[point.pipe];
    const Vector3d m = point.place - pipe.start;
    const double along = m.dot(pipe.direction);
    EXPECT_GE(along, 0);
    EXPECT_LE(along, 10);
    const double slope = point.pipe == 0 && along > 5 && along < 5.4 ? 0.05 / 0.4 : 0.0;
    const double radius =
        point.pipe == 0 ? 0.15 + 0.125 * std::clamp(along - 5, 0.0, 0.4) : pipe.radii[0].radius;
    const Vector3d radial = m - along * pipe.direction;
    EXPECT_NEAR(radial.norm(), radius, 1e-9);
    EXPECT_LT((point.normal - (radial / radius - slope * pipe.direction).normalized()).norm(),
              1e-9);
    mean_along += along / 402;
    mean_up += radial.z() / radius / 402;
  }
  EXPECT_EQ(counts[0], 101);
  EXPECT_EQ(counts[1], 101);
  EXPECT_EQ(counts[2], 100);
  EXPECT_EQ(counts[3], 100);
  EXPECT_NEAR(mean_along, 5, 4 * 10 / std::sqrt(12.0 * 402));
  EXPECT_NEAR(mean_up, 0, 4 / std::sqrt(2.0 * 402));
  for (const TexturePoint& point : random_texture_points(model, 100, 8, 0.5)) {
    EXPECT_GT(point.normal.z(), std::cos(0.5) - 0.05);
  }
}

TEST(RackFeatures, RefuseBadInput) {
  const rack_vision::RackModel model = test::paper_rack();
  EXPECT_THROW((void)random_texture_points(model, 5, 1, 0), std::invalid_argument);
  EXPECT_THROW((void)random_texture_points(model, 5, 1, 4), std::invalid_argument);
  EXPECT_THROW((void)random_texture_points({}, 5, 1), std::invalid_argument);
  EXPECT_THROW(RackFeatureCamera({.noise = -1}, geometry::Camera(), 1), std::invalid_argument);
  EXPECT_THROW(RackFeatureCamera({.outlier_share = 1.1}, geometry::Camera(), 1),
               std::invalid_argument);
  EXPECT_THROW(RackFeatureCamera({.samples_per_edge = -1}, geometry::Camera(), 1),
               std::invalid_argument);
  RackFeatureCamera eye({}, geometry::Camera(), 1);
  RackFeatures found;
  const std::vector<TexturePoint> texture = {{.pipe = 4}};
  EXPECT_THROW(eye.look(model, {}, kPose, texture, found), std::invalid_argument);
  const std::array<double, 3> too_few{};
  EXPECT_THROW(eye.look(model, too_few, kPose, {}, found), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
