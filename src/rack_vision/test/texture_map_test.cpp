// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/texture_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

using test::draw;
using test::drawn_camera;
using test::drawn_pose;
using test::drawn_rack;
using test::DrawnImage;

constexpr double kGate = 2.5;  // px

DrawnImage noise(std::uint64_t seed) {
  DrawnImage image{360, 240, std::vector<std::uint8_t>(360 * 240)};
  std::mt19937_64 engine(seed);
  std::uniform_int_distribution<int> level(0, 255);
  std::ranges::generate(image.pixels, [&] { return static_cast<std::uint8_t>(level(engine)); });
  return image;
}

class TextureMapTest : public ::testing::Test {
 protected:
  TextureMapTest() { image_ = draw(model_, camera_, first_); }

  [[nodiscard]] static UncertainView view(const geometry::SE3& T_rack_camera,
                                          double anchor_variance = 0) {
    UncertainView view{T_rack_camera.inverse(), geometry::Matrix6d::Zero(), anchor_variance, {}};
    view.covariance.diagonal().head<3>().setConstant(0.001 * 0.001);
    view.covariance.diagonal().tail<3>().setConstant(0.0005 * 0.0005);
    return view;
  }

  /// One image through all of it. Returns the number of points that agreed.
  int see(const DrawnImage& image, const UncertainView& from) {
    map_.choose(from, surface_, matches_);
    map_.match(image.view(), from, 0, matches_.size(), matches_);
    return map_.learn(from, matches_, kGate);
  }
  void grow(const DrawnImage& image, const UncertainView& from, int times = 6) {
    for (int i = 0; i < times; ++i) {
      map_.choose(from, surface_, matches_);
      map_.grow(image.view(), from, surface_);
    }
  }
  [[nodiscard]] std::size_t found() const {
    return static_cast<std::size_t>(std::ranges::count_if(matches_, &MatchedPoint::found));
  }

  RackModel model_ = drawn_rack();
  geometry::Camera camera_ = drawn_camera();
  RackSurface surface_{model_, {}};
  TextureMap map_{model_, camera_, {}};
  const geometry::SE3 first_ = drawn_pose(0.78, 4.0, 2.8, 0.1);
  const geometry::SE3 second_ = drawn_pose(0.83, 4.09, 2.72, 0.13);
  DrawnImage image_;
  std::vector<MatchedPoint> matches_;
  std::vector<PointObservation> points_;
};

TEST_F(TextureMapTest, GrowsOnTextureAndOnlyThere) {
  grow(image_, view(first_));
  EXPECT_GT(map_.size(), 10U);
  map_.clear();
  EXPECT_EQ(map_.size(), 0U);
  DrawnImage plain = image_;
  std::ranges::fill(plain.pixels, std::uint8_t{120});
  grow(plain, view(first_));
  EXPECT_EQ(map_.size(), 0U);
}

TEST_F(TextureMapTest, FindsPointsAgainAfterAKnownMotion) {
  grow(image_, view(first_));
  const DrawnImage moved = draw(model_, camera_, second_);
  map_.choose(view(second_), surface_, matches_);
  ASSERT_GT(matches_.size(), 10U);
  map_.match(moved.view(), view(second_), 0, matches_.size(), matches_);
  EXPECT_GT(found(), matches_.size() * 7 / 10);
  double square = 0;
  for (const MatchedPoint& match : matches_) {
    if (match.found) {
      square += (match.pixel - match.predicted).squaredNorm();  // no distortion
      EXPECT_GT(match.correlation, 0.8);
      EXPECT_GE(match.sigma, 0.15);
    }
  }
  EXPECT_LT(std::sqrt(square / static_cast<double>(found())), 0.4);
}

TEST_F(TextureMapTest, ABetterOffsetOfAPipeLeavesItsPointsWhereTheyWereSeen) {
  grow(image_, view(first_));
  std::vector<double> offsets(model_.pipes.size(), 0.01);
  UncertainView better = view(first_);
  better.offsets = offsets;
  surface_.update(model_, offsets);
  map_.choose(better, surface_, matches_);
  ASSERT_GT(matches_.size(), 10U);
  map_.match(image_.view(), better, 0, matches_.size(), matches_);
  EXPECT_GT(found(), matches_.size() * 8 / 10);
  for (const MatchedPoint& match : matches_) {
    EXPECT_TRUE(!match.found || (match.pixel - match.predicted).norm() < 0.5);
  }
}

TEST_F(TextureMapTest, ACorrectionMovesPointsAsThePoseThatTheyWereMadeFrom) {
  grow(image_, view(first_));
  // No turn about x: what that moves along y in the middle of the view is the anchor's.
  geometry::Vector6d error;
  error << 0.02, 0, 0.01, 0, -0.003, 0.002;
  map_.correct(error);
  const geometry::SE3 corrected(geometry::SO3::exp(error.tail<3>()) * first_.rotation(),
                                first_.translation() + error.head<3>());
  const UncertainView from = view(corrected);
  map_.choose(from, surface_, matches_);
  ASSERT_GT(matches_.size(), 10U);
  map_.match(image_.view(), from, 0, matches_.size(), matches_);
  EXPECT_GT(found(), matches_.size() * 8 / 10);
  for (const MatchedPoint& match : matches_) {
    EXPECT_TRUE(!match.found || (match.pixel - match.predicted).norm() < 0.5);
  }
}

TEST_F(TextureMapTest, ACorrectionLeavesTheMiddleOfTheViewWhereItIsAlongThePipes) {
  grow(image_, view(first_));
  geometry::Vector6d error = geometry::Vector6d::Zero();
  error(3) = 0.005;
  map_.correct(error);
  // The camera turns about the middle of what it sees: at z = 0, straight below.
  const geometry::SO3 turned = geometry::SO3::exp(error.tail<3>()) * first_.rotation();
  const Eigen::Vector3d height(0, 0, first_.translation().z());
  const UncertainView from =
      view({turned, first_.translation() - height + geometry::SO3::exp(error.tail<3>()) * height});
  map_.choose(from, surface_, matches_);
  ASSERT_GT(matches_.size(), 10U);
  map_.match(image_.view(), from, 0, matches_.size(), matches_);
  EXPECT_GT(found(), matches_.size() * 8 / 10);
}

TEST_F(TextureMapTest, SearchesOnlyThoseThatItIsAskedFor) {
  grow(image_, view(first_));
  map_.choose(view(first_), surface_, matches_);
  ASSERT_GT(matches_.size(), 8U);
  map_.match(image_.view(), view(first_), 3, 4, matches_);
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    EXPECT_TRUE((i >= 3 && i < 7) || !matches_[i].found) << i;
  }
}

TEST_F(TextureMapTest, PointsAreProvenWhenTheyWereFoundSeveralTimes) {
  grow(image_, view(first_));
  map_.choose(view(first_), surface_, matches_);
  EXPECT_TRUE(std::ranges::none_of(matches_, &MatchedPoint::proven));
  for (int i = 0; i < 2; ++i) {
    EXPECT_GT(see(image_, view(first_)), 10);
  }
  map_.choose(view(first_), surface_, matches_);
  EXPECT_GT(std::ranges::count_if(matches_, &MatchedPoint::proven), 10);
}

TEST_F(TextureMapTest, PrunesPointsThatFail) {
  grow(image_, view(first_));
  ASSERT_GT(map_.size(), 10U);
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    (void)see(noise(seed), view(first_));
  }
  EXPECT_EQ(map_.size(), 0U);
}

TEST_F(TextureMapTest, AMatchFarFromWhereTheViewHasItFails) {
  grow(image_, view(first_));
  map_.choose(view(first_), surface_, matches_);
  map_.match(image_.view(), view(first_), 0, matches_.size(), matches_);
  ASSERT_GT(found(), 10U);
  const geometry::SE3 elsewhere = drawn_pose(0.88, 4.0, 2.8, 0.1);
  EXPECT_EQ(map_.learn(view(elsewhere), matches_, kGate), 0);
}

TEST_F(TextureMapTest, KeepsWithinItsCapacityAndLeavesWhatIsFar) {
  map_ = TextureMap(model_, camera_, {.capacity = 12});
  for (int k = 0; k < 6; ++k) {
    const geometry::SE3 place = drawn_pose(0.78, 3.0 + 0.5 * k, 2.8, 0.1);
    grow(draw(model_, camera_, place), view(place), 3);
    EXPECT_LE(map_.size(), 12U);
  }
  EXPECT_EQ(map_.size(), 12U);
  // The last place is the one that it knows.
  map_.choose(view(drawn_pose(0.78, 5.5, 2.8, 0.1)), surface_, matches_);
  EXPECT_GT(matches_.size(), 6U);

  map_ = TextureMap(model_, camera_, {.capacity = 0});
  grow(image_, view(first_));
  EXPECT_EQ(map_.size(), 0U);
}

TEST_F(TextureMapTest, SearchesNoMorePointsThanItShould) {
  map_ = TextureMap(model_, camera_, {.points_per_frame = 7});
  grow(image_, view(first_));
  map_.choose(view(first_), surface_, matches_);
  EXPECT_EQ(matches_.size(), 7U);
}

TEST_F(TextureMapTest, CarriesTheAnchorOfTheViewThatMadeThePoints) {
  constexpr double kAnchor = 0.02 * 0.02;
  EXPECT_FALSE(map_.observations({}, points_).has_value());
  grow(image_, view(first_, kAnchor));
  map_.choose(view(first_, kAnchor), surface_, matches_);
  map_.match(image_.view(), view(first_, kAnchor), 0, matches_.size(), matches_);
  const std::optional<double> anchor = map_.observations(matches_, points_);
  ASSERT_TRUE(anchor.has_value());
  EXPECT_EQ(points_.size(), found());
  // With what the pose adds to it relative to its anchor.
  EXPECT_GE(*anchor, kAnchor);
  EXPECT_LT(*anchor, kAnchor + 0.005 * 0.005);
  // All share it: it is no error of one against the others.
  for (const PointObservation& point : points_) {
    EXPECT_LT(point.place_covariance(1, 1), 0.25 * kAnchor);
  }
}

TEST_F(TextureMapTest, PointsOfAWorseAnchorCountLessBesideABetterOne) {
  constexpr double kWorse = 0.05 * 0.05;
  constexpr double kBetter = 0.01 * 0.01;
  map_ = TextureMap(model_, camera_, {.cells_per_frame = 3});
  grow(image_, view(first_, kWorse), 1);
  const std::size_t worse = map_.size();
  ASSERT_GT(worse, 3U);
  grow(image_, view(first_, kBetter));
  ASSERT_GT(map_.size(), worse + 3);
  map_.choose(view(first_, kBetter), surface_, matches_);
  map_.match(image_.view(), view(first_, kBetter), 0, matches_.size(), matches_);
  const std::optional<double> anchor = map_.observations(matches_, points_);
  ASSERT_TRUE(anchor.has_value());
  EXPECT_LT(*anchor, 2 * kBetter);
  const auto loose = std::ranges::count_if(points_, [](const PointObservation& point) {
    return point.place_covariance(1, 1) > kWorse - kBetter;
  });
  EXPECT_GT(loose, 0);
  EXPECT_LE(loose, static_cast<std::ptrdiff_t>(worse));
  EXPECT_LT(static_cast<std::size_t>(loose), points_.size());
  // Seen together, the worse ones take over the better anchor.
  (void)map_.learn(view(first_, kBetter), matches_, kGate);
  map_.choose(view(first_, kBetter), surface_, matches_);
  map_.match(image_.view(), view(first_, kBetter), 0, matches_.size(), matches_);
  ASSERT_TRUE(map_.observations(matches_, points_).has_value());
  EXPECT_TRUE(std::ranges::all_of(points_, [](const PointObservation& point) {
    return point.place_covariance(1, 1) < 0.1 * (kWorse - kBetter);
  }));
}

TEST_F(TextureMapTest, WhatWasSeenIsShiftedAlongAndAnchoredAnew) {
  constexpr double kShift = 0.012;
  constexpr double kAnchor = 0.02 * 0.02;
  constexpr double kReached = 0.002 * 0.002;
  grow(image_, view(first_, kAnchor));
  EXPECT_GT(see(image_, view(first_, kAnchor)), 10);
  map_.shift_seen(kShift, kReached);
  // The same image, from the place that is believed now.
  const geometry::SE3 shifted(first_.rotation(),
                              first_.translation() + kShift * Eigen::Vector3d::UnitY());
  map_.choose(view(shifted, kReached), surface_, matches_);
  map_.match(image_.view(), view(shifted, kReached), 0, matches_.size(), matches_);
  const std::optional<double> anchor = map_.observations(matches_, points_);
  ASSERT_TRUE(anchor.has_value());
  EXPECT_LE(*anchor, kReached);
  EXPECT_GT(map_.learn(view(shifted, kReached), matches_, 1.0), 10);
}

TEST_F(TextureMapTest, TheSameImagesGiveTheSameMap) {
  TextureMap other(model_, camera_, {});
  std::vector<MatchedPoint> matches;
  const DrawnImage moved = draw(model_, camera_, second_);
  grow(image_, view(first_), 2);
  (void)see(moved, view(second_));
  for (int i = 0; i < 2; ++i) {
    other.choose(view(first_), surface_, matches);
    other.grow(image_.view(), view(first_), surface_);
  }
  other.choose(view(second_), surface_, matches);
  other.match(moved.view(), view(second_), 0, matches.size(), matches);
  ASSERT_EQ(matches.size(), matches_.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].found, matches_[i].found);
    EXPECT_EQ(matches[i].pixel, matches_[i].pixel);
  }
}

TEST(TextureMapParameters, AreValidated) {
  TextureMapParameters parameters;
  parameters.cell_side = 10;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.point_sigma = 0;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.least_correlation = std::nan("");
  EXPECT_THROW(TextureMap(drawn_rack(), drawn_camera(), parameters), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_vision
