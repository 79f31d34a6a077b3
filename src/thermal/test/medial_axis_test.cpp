// SPDX-License-Identifier: Apache-2.0
#include "medial_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "pipe_pictures_helpers.hpp"

namespace pipescout::thermal {
namespace {

using test::Picture;

BitMask mask_of(const Picture& picture) {
  const TemperatureView view = picture.view();
  BitMask mask;
  mask.resize(view.width, view.height);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (view(x, y) > 100) {
        mask.row(y)[x / 64] |= std::uint64_t{1} << (x % 64);
      }
    }
  }
  return mask;
}

/// To the nearest pixel that is not set, by trying all of them.
std::vector<double> brute_force_distances(const BitMask& mask) {
  std::vector<Eigen::Vector2i> clear;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!mask.get(x, y)) {
        clear.emplace_back(x, y);
      }
    }
  }
  std::vector<double> distances;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      int least = mask.get(x, y) ? 1'000'000 : 0;
      if (mask.get(x, y)) {
        for (const Eigen::Vector2i& c : clear) {
          least = std::min(least, (c - Eigen::Vector2i(x, y)).squaredNorm());
        }
      }
      distances.push_back(std::sqrt(least));
    }
  }
  return distances;
}

struct Strip {
  double degrees;
  double half_width;
};

class MedialAxisOfAStrip : public testing::TestWithParam<Strip> {
 protected:
  static constexpr int kWidth = 96;
  static constexpr int kHeight = 80;
};

/// Both ways: the points found are where the distance to the edge is largest across, and wherever
/// it is largest, a point was found.
TEST_P(MedialAxisOfAStrip, IsTheRidgeOfTheDistanceToTheEdge) {
  const double angle = GetParam().degrees * std::numbers::pi / 180;
  const Eigen::Vector2d u(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d middle(47.3, 39.6);
  const BitMask mask = mask_of(
      Picture(kWidth, kHeight).pipe(middle - 33 * u, middle + 33 * u, GetParam().half_width, 180));
  const std::vector<double> distances = brute_force_distances(mask);
  const auto distance = [&](const Eigen::Vector2d& p) {
    return distances[static_cast<std::size_t>(std::lround(p.y()) * kWidth + std::lround(p.x()))];
  };
  MedialAxis axis;
  ASSERT_TRUE(axis.find(mask, {3, 60}));
  std::vector<Eigen::Vector2d> points;
  for (const Chord& c : axis.columns()) {
    points.emplace_back(c.line, c.middle());
  }
  for (const Chord& c : axis.rows()) {
    points.emplace_back(c.middle(), c.line);
  }
  ASSERT_GE(points.size(), 30U);
  // Square ends have other branches: the strip is judged a width before them.
  const double reach = 33 - 2 * GetParam().half_width - 2;
  const Eigen::Vector2d normal(-u.y(), u.x());
  for (const Eigen::Vector2d& p : points) {
    if (std::abs(u.dot(p - middle)) > reach) {
      continue;
    }
    double most = 0;
    for (double off = -GetParam().half_width; off <= GetParam().half_width; off += 0.25) {
      most = std::max(most, distance(p + off * normal));
    }
    EXPECT_GE(distance(p), most - 1.0) << p.transpose();
    EXPECT_LE(std::abs(normal.dot(p - middle)), 1.0) << p.transpose();
  }
  for (double along = -reach; along <= reach; along += 1) {
    const Eigen::Vector2d expected = middle + along * u;
    const bool found = std::any_of(points.begin(), points.end(), [&](const Eigen::Vector2d& p) {
      return (p - expected).norm() <= 1.5;
    });
    EXPECT_TRUE(found) << expected.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(AllDirections, MedialAxisOfAStrip,
                         testing::Values(Strip{0, 4}, Strip{7, 4}, Strip{21, 3}, Strip{38, 6},
                                         Strip{45, 5}, Strip{52, 4}, Strip{69, 5}, Strip{90, 4},
                                         Strip{97, 3}, Strip{135, 6}, Strip{160, 2.5}));

/// The radius of the largest disc inside is half a chord, times the cosine of its slant.
TEST(MedialAxis, HalfAChordIsTheDistanceToTheEdge) {
  const BitMask mask = mask_of(Picture(200, 60).pipe({-5, 30}, {205, 30}, 7, 180));
  const std::vector<double> distances = brute_force_distances(mask);
  MedialAxis axis;
  ASSERT_TRUE(axis.find(mask, {3, 60}));
  EXPECT_EQ(axis.columns().size(), 200U);
  EXPECT_TRUE(axis.rows().empty());
  for (const Chord& c : axis.columns()) {
    const double distance =
        distances[static_cast<std::size_t>(std::lround(c.middle()) * 200 + c.line)];
    EXPECT_NEAR(0.5 * c.length(), distance, 0.6);
  }
}

TEST(MedialAxis, ChordsAtTheBorderSaySo) {
  const BitMask mask = mask_of(Picture(130, 40).pipe({-5, 1}, {135, 1}, 5, 180));
  MedialAxis axis;
  ASSERT_TRUE(axis.find(mask, {3, 60}));
  ASSERT_EQ(axis.columns().size(), 130U);
  EXPECT_TRUE(std::all_of(axis.columns().begin(), axis.columns().end(),
                          [](const Chord& c) { return c.cut; }));
}

TEST(MedialAxis, ChordsOutsideTheLimitsAreLeftOut) {
  const BitMask mask =
      mask_of(Picture(128, 64).pipe({10, 10}, {120, 10}, 1, 180).box(20, 25, 60, 30, 180));
  MedialAxis axis;
  ASSERT_TRUE(axis.find(mask, {5, 20}));
  EXPECT_TRUE(axis.columns().empty());
  EXPECT_TRUE(axis.rows().empty());
}

TEST(MedialAxis, MoreThanPipesMakeIsClutter) {
  Picture picture(640, 512, 0);
  picture.noise(1, 1);
  BitMask mask;
  mask.resize(640, 512);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 640; ++x) {
      if (picture.view()(x, y) > 0) {
        mask.row(y)[x / 64] |= std::uint64_t{1} << (x % 64);
      }
    }
  }
  MedialAxis axis;
  EXPECT_FALSE(axis.find(mask, {1, 100}));
  EXPECT_TRUE(axis.columns().empty());
}

}  // namespace
}  // namespace pipescout::thermal
