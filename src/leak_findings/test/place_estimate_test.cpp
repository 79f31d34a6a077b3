// SPDX-License-Identifier: Apache-2.0
#include "place_estimate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace pipescout::leak_findings {
namespace {

Bearing bearing_to(const Eigen::Vector3d& point, const Eigen::Vector3d& eye, double time = 0) {
  Bearing b;
  b.time = time;
  b.eye = eye;
  b.base = eye;
  b.ray = (point - eye).normalized();
  b.along = (Eigen::Vector3d::UnitX() - b.ray.x() * b.ray).normalized();
  b.along_deviation = b.across_deviation = 0.002;
  b.position_jitter = 0.01;
  return b;
}

RangePrior prior_at(const Bearing& b, double range, double deviation) {
  return {b.eye + range * b.ray, b.ray * b.ray.transpose() / (deviation * deviation), range};
}

TEST(PlaceEstimate, BearingsFromSeveralPlacesMeet) {
  const Eigen::Vector3d truth(3, 11, 2);
  PlaceEstimate place;
  const Bearing first = bearing_to(truth, {0, 0, 1});
  place.begin(first, prior_at(first, 8, 4));  // the range is off
  EXPECT_GT((place.point() - truth).norm(), 2);
  for (int i = 1; i <= 20; ++i) {
    place.add(bearing_to(truth, {0.25 * i, 0, 1}, 0.04 * i));
  }
  EXPECT_LT((place.point() - truth).norm(), 0.05);
  const Eigen::Vector3d ray = bearing_to(truth, {2.5, 0, 1}).ray;
  EXPECT_LT(std::sqrt(ray.dot(place.relative_covariance() * ray)), 0.2);
}

/// From one place, the range stays what the prior says.
TEST(PlaceEstimate, WithoutMotionTheRangeIsThePriors) {
  const Eigen::Vector3d truth(0, 10, 0);
  PlaceEstimate place;
  const Bearing b = bearing_to(truth, Eigen::Vector3d::Zero());
  place.begin(b, prior_at(b, 9, 1));
  for (int i = 0; i < 50; ++i) {
    place.add(b);
  }
  EXPECT_NEAR(place.point().y(), 9, 1e-6);
  EXPECT_NEAR(std::sqrt(place.relative_covariance()(1, 1)), 1, 1e-6);
}

/// J Sigma J^T with J by differences of turning and shifting the pose.
TEST(PlaceEstimate, PosePartAgreesWithDifferences) {
  const Eigen::Vector3d point(4, 9, 3);
  const Eigen::Vector3d base(1, 0.5, 0.2);
  geometry::Matrix6d root;
  for (int i = 0; i < 36; ++i) {
    root(i / 6, i % 6) = 0.01 * std::sin(1.7 * i + 0.3);
  }
  const geometry::Matrix6d covariance = root * root.transpose();
  Eigen::Matrix<double, 3, 6> numeric;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const auto moved = [&](double step) -> Eigen::Vector3d {
      geometry::Vector6d xi = geometry::Vector6d::Zero();
      xi[k] = step;
      return base + xi.head<3>() +
             geometry::SO3::exp(Eigen::Vector3d(xi.tail<3>())) * Eigen::Vector3d(point - base);
    };
    numeric.col(k) = (moved(kStep) - moved(-kStep)) / (2 * kStep);
  }
  const Eigen::Matrix3d expected = numeric * covariance * numeric.transpose();
  EXPECT_LT((pose_part(point, base, covariance) - expected).norm(), 1e-8);
}

TEST(PlaceEstimate, MountingPartIsThatOfAPose) {
  const Eigen::Vector3d point(4, 9, 3);
  const Eigen::Vector3d eye(1, 0, 1);
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  covariance.diagonal() << 0.04, 0.04, 0.04, 1e-4, 1e-4, 1e-4;
  EXPECT_LT((mounting_part(point, eye, 0.01, 0.2) - pose_part(point, eye, covariance)).norm(),
            1e-12);
}

/// Of a first-order Gauss-Markov error, by summing its covariance.
TEST(PlaceEstimate, VarianceOfTheMeanOfACorrelatedError) {
  for (const double duration : {0.01, 1.0, 10.0, 100.0}) {
    constexpr int kSteps = 1500;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        sum += std::exp(-std::abs(i - j) * duration / kSteps / 10.0);
      }
    }
    EXPECT_NEAR(variance_of_mean(duration, 10.0), sum / kSteps / kSteps, 2e-3);
  }
  EXPECT_NEAR(variance_of_mean(0, 10), 1, 1e-12);
  // Both branches agree where they meet.
  EXPECT_NEAR(variance_of_mean(0.99e-3, 10), variance_of_mean(1.01e-3, 10), 1e-6);
}

TEST(PlaceEstimate, PlaceOnALine) {
  const Eigen::Vector3d along = Eigen::Vector3d(1, 0.2, 0).normalized();
  const Eigen::Vector3d origin(1, 10, 2);
  const Eigen::Vector3d target = origin + 3.5 * along;
  const Eigen::Vector3d eye(0, 0, 1);
  EXPECT_NEAR(place_on_line(eye, (target - eye).normalized(), origin, along), 3.5, 1e-9);
  EXPECT_TRUE(std::isnan(place_on_line(eye, along, origin, along)));
}

TEST(PlaceEstimate, FusionIsTheProductOfGaussians) {
  MapPosition a;
  a.point = {1, 2, 3};
  a.covariance.diagonal() << 1, 4, 9;
  MapPosition b;
  b.point = {2, 2, 6};
  b.covariance.diagonal() << 1, 1, 9;
  const MapPosition both = fuse(a, b);
  EXPECT_LT((both.point - Eigen::Vector3d(1.5, 2, 4.5)).norm(), 1e-12);
  EXPECT_NEAR(both.covariance(0, 0), 0.5, 1e-12);
  EXPECT_NEAR(both.covariance(1, 1), 0.8, 1e-12);
  EXPECT_NEAR(both.covariance(2, 2), 4.5, 1e-12);
}

TEST(Miss, IsTheOffsetAtTheRangeOfThePoint) {
  const Eigen::Vector3d point(0, 10, 0);
  const Bearing b = bearing_to(point + Eigen::Vector3d(0.2, 0, 0.1), Eigen::Vector3d::Zero());
  const Miss m = miss(b, point, 0.01 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(m.offset.x(), 0.2, 0.01);
  EXPECT_NEAR(std::abs(m.offset.y()), 0.1, 0.01);
  EXPECT_NEAR(m.covariance(0, 0), 0.01 + 0.02 * 0.02 + 0.01 * 0.01, 1e-6);
}

}  // namespace
}  // namespace pipescout::leak_findings
