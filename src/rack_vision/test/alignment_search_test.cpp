// SPDX-License-Identifier: Apache-2.0
#include "alignment_search.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <vector>

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::Vector6d;

constexpr int kWidth = 360;
constexpr int kHeight = 240;
const Eigen::Vector2d kMiddle(kWidth / 2.0, kHeight / 2.0);
constexpr double kStep = 2.5;
constexpr double kDistance = 8;

geometry::Camera camera() {
  geometry::CameraParameters parameters;
  parameters.width = kWidth;
  parameters.height = kHeight;
  parameters.centre_u = kMiddle.x();
  parameters.centre_v = kMiddle.y();
  return geometry::Camera(parameters);
}

/// Motions of these tests: along u and v, px, and a turn about the middle of the image, rad. The
/// other three move nothing.
Vector6d motion(double u, double v, double turn) {
  Vector6d result = Vector6d::Zero();
  result << u, v, 0, 0, 0, turn;
  return result;
}

Matrix6d covariance(double u, double v, double turn) {
  return motion(u, v, turn).cwiseAbs2().asDiagonal();
}

AlignmentContour contour(const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                         const Eigen::Vector2d& normal, double sign = 0) {
  const auto by_motion = [&normal](const Eigen::Vector2d& at) {
    const Eigen::Vector2d from = at - kMiddle;
    return motion(normal.x(), normal.y(), normal.dot(Eigen::Vector2d(-from.y(), from.x())));
  };
  return {start, end, normal, by_motion(start), by_motion(end), sign};
}

struct Image {
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] ImageView view() const { return {pixels.data(), kWidth, kHeight, kWidth}; }
};

/// The scene `grey`, of which the contours are rendered unmoved, as it is seen after a motion.
Image seen(const std::function<double(const Eigen::Vector2d&)>& grey, const Vector6d& moved) {
  Image image{std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight)};
  const Eigen::Rotation2Dd back(-moved(5));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector2d at =
          back * (Eigen::Vector2d(u, v) - kMiddle - moved.head<2>()) + kMiddle;
      image.pixels[static_cast<std::size_t>(v * kWidth + u)] =
          static_cast<std::uint8_t>(std::lround(grey(at)));
    }
  }
  return image;
}

/// Three bright bars over a beam across them, with texture on all.
double bars(const Eigen::Vector2d& at) {
  const double texture = 12 * std::sin(1.1 * at.x() + 0.7 * at.y()) * std::cos(0.9 * at.y());
  for (const auto& [from, to] : {std::pair{60.0, 110.0}, {150.0, 215.0}, {270.0, 295.0}}) {
    if (at.x() > from && at.x() < to) {
      return 190 + texture;
    }
  }
  return (at.y() > 95 && at.y() < 130 ? 135 : 70) + texture;
}

std::vector<AlignmentContour> contours_of_bars(double sign = 0) {
  std::vector<AlignmentContour> contours;
  for (const auto& [from, to] : {std::pair{60.0, 110.0}, {150.0, 215.0}, {270.0, 295.0}}) {
    contours.push_back(contour({from, 30}, {from, 210}, {-1, 0}, sign));
    contours.push_back(contour({to, 30}, {to, 210}, {1, 0}, sign));
  }
  for (const auto& [from, to] : {std::pair{110.0, 150.0}, {215.0, 270.0}}) {
    contours.push_back(contour({from, 95}, {to, 95}, {0, -1}, sign));
    contours.push_back(contour({from, 130}, {to, 130}, {0, 1}, sign));
  }
  return contours;
}

/// How far two motions have the contours from each other, root of the mean square, px.
double apart(const std::vector<AlignmentContour>& contours, const Vector6d& a, const Vector6d& b) {
  double sum = 0;
  for (const AlignmentContour& contour : contours) {
    sum += std::pow(contour.start_by_motion.dot(a - b), 2);
    sum += std::pow(contour.end_by_motion.dot(a - b), 2);
  }
  return std::sqrt(sum / static_cast<double>(2 * contours.size()));
}

// Off by up to half a step along each of the three directions, and by the half step to which places
// of edges are rounded.
const double kWithinAStep = (0.5 * std::sqrt(3.0) + 0.5) * kStep;

TEST(AlignmentSearch, FindsAKnownMotionWithinAStep) {
  AlignmentSearch search(camera());
  const auto contours = contours_of_bars();
  std::vector<AlignmentPeak> peaks;
  for (const Vector6d& truth : {motion(0, 0, 0), motion(58, -22, 0), motion(-57, 31, 0.03),
                                motion(21, 12, -0.06), motion(-34, -40, 0.05)}) {
    const Image image = seen(bars, truth);
    search.search(image.view(), contours, covariance(20, 15, 0.025), kStep, kDistance, 6, peaks);
    ASSERT_FALSE(peaks.empty());
    EXPECT_LT(apart(contours, peaks.front().motion, truth), kWithinAStep) << truth.transpose();
  }
}

TEST(AlignmentSearch, PeaksAreDistinctAndTheBestComesFirst) {
  AlignmentSearch search(camera());
  const auto contours = contours_of_bars();
  const Image image = seen(bars, motion(17, -9, 0.02));
  std::vector<AlignmentPeak> peaks;
  search.search(image.view(), contours, covariance(20, 15, 0.025), kStep, kDistance, 6, peaks);
  ASSERT_EQ(peaks.size(), 6U);
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE(peaks[j].score, peaks[i].score);
      EXPECT_GE(apart(contours, peaks[i].motion, peaks[j].motion), kDistance);
    }
  }
}

TEST(AlignmentSearch, ScoresAgreeWithHowProbableTheMotionIs) {
  // Nothing to see: what is left is the prior, at its best where nothing moves.
  AlignmentSearch search(camera());
  const auto contours = contours_of_bars();
  const Image image = seen([](const Eigen::Vector2d&) { return 100.0; }, Vector6d::Zero());
  std::vector<AlignmentPeak> peaks;
  search.search(image.view(), contours, covariance(20, 0, 0), kStep, kDistance, 2, peaks);
  ASSERT_EQ(peaks.size(), 2U);
  EXPECT_LT(peaks[0].motion.norm(), 1e-9);
  EXPECT_NEAR(peaks[0].score, 0, 1e-6);
  const double deviations = peaks[1].motion(0) / 20;
  EXPECT_NEAR(peaks[1].score, -0.5 * deviations * deviations, 1e-4);
}

TEST(AlignmentSearch, TheSignOfEdgesTellsABarFromAGap) {
  // Bars and gaps of the same width: without the signs the nearer gap looks like the bar.
  const auto stripes = [](const Eigen::Vector2d& at) {
    return std::fmod(at.x() + 800, 80) < 40 ? 190.0 : 70.0;  // bright from 160 to 200
  };
  const Image image = seen(stripes, motion(36, 0, 0));
  AlignmentSearch search(camera());
  std::vector<AlignmentPeak> peaks;
  for (const double sign : {0.0, -1.0}) {
    const std::vector<AlignmentContour> bar{contour({160, 20}, {160, 220}, {-1, 0}, sign),
                                            contour({200, 20}, {200, 220}, {1, 0}, sign)};
    search.search(image.view(), bar, covariance(20, 0, 0), 1.0, kDistance, 1, peaks);
    ASSERT_EQ(peaks.size(), 1U);
    EXPECT_NEAR(peaks.front().motion(0), sign == 0 ? -4 : 36, 1.5) << sign;
  }
}

TEST(AlignmentSearch, NoContoursNoPeaks) {
  AlignmentSearch search(camera());
  const Image image = seen(bars, Vector6d::Zero());
  std::vector<AlignmentPeak> peaks(3);
  search.search(image.view(), {}, covariance(20, 15, 0.02), kStep, kDistance, 6, peaks);
  EXPECT_TRUE(peaks.empty());
  EXPECT_EQ(AlignmentSearch::remaining({}, covariance(20, 15, 0.02), kStep),
            covariance(20, 15, 0.02));
}

TEST(AlignmentSearch, WhatTheCovarianceKnowsStays) {
  AlignmentSearch search(camera());
  const auto contours = contours_of_bars();
  std::vector<AlignmentPeak> peaks;
  const Image image = seen(bars, motion(23, 0, 0));
  search.search(image.view(), contours, covariance(20, 0, 0), kStep, kDistance, 1, peaks);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_NEAR(peaks.front().motion(0), 23, kStep);
  EXPECT_LT(peaks.front().motion.tail<5>().norm(), 1e-9);

  search.search(image.view(), contours, Matrix6d::Zero(), kStep, kDistance, 6, peaks);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_EQ(peaks.front().motion, Vector6d::Zero());

  // Two motions that can only come together.
  Vector6d together = motion(15, 10, 0);
  search.search(seen(bars, 1.5 * together).view(), contours, together * together.transpose(), kStep,
                kDistance, 1, peaks);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_LT(apart(contours, peaks.front().motion, 1.5 * together), kStep);
}

TEST(AlignmentSearch, ContoursAtTheBorderAndBeyondItDoNoHarm) {
  AlignmentSearch search(camera());
  auto contours = contours_of_bars();
  contours.push_back(contour({-4, -20}, {-4, 260}, {-1, 0}));
  contours.push_back(contour({359, 0}, {359, 239}, {1, 0}));
  contours.push_back(contour({0, 239.4}, {359, 239.4}, {0, 1}));
  contours.push_back(contour({5000, 100}, {5000, 200}, {1, 0}));
  const Vector6d truth = motion(-40, 25, 0.02);
  const Image image = seen(bars, truth);
  std::vector<AlignmentPeak> peaks;
  search.search(image.view(), contours, covariance(20, 15, 0.01), kStep, kDistance, 6, peaks);
  ASSERT_FALSE(peaks.empty());
  EXPECT_TRUE(std::isfinite(peaks.front().score));
  EXPECT_LT(apart(contours_of_bars(), peaks.front().motion, truth), kWithinAStep);
}

TEST(AlignmentSearch, TheSameQuestionGetsTheSameAnswer) {
  const auto contours = contours_of_bars();
  const Image image = seen(bars, motion(17, -9, 0.02));
  const Image other_image = seen(bars, motion(-30, 12, 0));
  AlignmentSearch search(camera());
  std::vector<AlignmentPeak> first;
  std::vector<AlignmentPeak> peaks;
  search.search(image.view(), contours, covariance(20, 15, 0.025), kStep, kDistance, 6, first);
  search.search(other_image.view(), contours, covariance(30, 5, 0.01), 2.0, kDistance, 3, peaks);
  search.search(image.view(), contours, covariance(20, 15, 0.025), kStep, kDistance, 6, peaks);
  ASSERT_EQ(peaks.size(), first.size());
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    EXPECT_EQ(peaks[i].motion, first[i].motion);
    EXPECT_EQ(peaks[i].score, first[i].score);
  }
}

TEST(AlignmentSearch, WhatRemainsIsWhatTheContoursDoNotShow) {
  // Upright bars alone: nothing about v.
  std::vector<AlignmentContour> upright{contour({60, 30}, {60, 210}, {-1, 0}),
                                        contour({110, 30}, {110, 210}, {1, 0})};
  const Matrix6d before = covariance(20, 15, 0.025);
  const Matrix6d after = AlignmentSearch::remaining(upright, before, kStep);
  EXPECT_LT(std::sqrt(after(0, 0)), kStep);
  EXPECT_NEAR(after(1, 1), before(1, 1), 1e-6 * before(1, 1));
  EXPECT_LT(after(5, 5), before(5, 5));
  const Eigen::SelfAdjointEigenSolver<Matrix6d> lost(before - after);
  EXPECT_GE(lost.eigenvalues().minCoeff(), -1e-9);
}

}  // namespace
}  // namespace pipescout::rack_vision
