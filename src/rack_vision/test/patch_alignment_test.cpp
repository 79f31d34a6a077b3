// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/patch_alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <vector>

namespace pipescout::rack_vision {
namespace {

constexpr int kSide = 96;

/// A smooth texture, moved by `shift`, turned and scaled by `turn` about its middle.
std::vector<std::uint8_t> texture(const Eigen::Vector2d& shift, const Eigen::Matrix2d& turn,
                                  double gain = 1, double bias = 0) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kSide * kSide));
  const Eigen::Vector2d middle(kSide / 2, kSide / 2);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const Eigen::Vector2d p = turn * (Eigen::Vector2d(u, v) - middle - shift);
      const double value =
          110 + 35 * std::sin(0.55 * p.x() + 0.3 * p.y()) * std::cos(0.41 * p.y() - 0.13 * p.x()) +
          25 * std::sin(0.23 * p.x() * p.y() / 9 + 0.7 * p.y());
      pixels[static_cast<std::size_t>(v * kSide + u)] =
          static_cast<std::uint8_t>(std::lround(gain * value + bias));
    }
  }
  return pixels;
}

ImageView view(const std::vector<std::uint8_t>& pixels) {
  return {pixels.data(), kSide, kSide, kSide};
}

const Eigen::Vector2i kMiddle(kSide / 2, kSide / 2);

WarpedPatch warped(const StoredPatch& stored, const Eigen::Matrix2d& stored_from_current) {
  WarpedPatch patch;
  EXPECT_TRUE(warp_patch(stored, stored_from_current, 3.0, patch));
  return patch;
}

TEST(PatchAlignment, FindsAShiftToHundredthsOfAPixelUnderOtherLight) {
  const auto before = texture({0, 0}, Eigen::Matrix2d::Identity());
  StoredPatch stored;
  ASSERT_TRUE(store_patch(view(before), kMiddle, stored));
  const WarpedPatch patch = warped(stored, Eigen::Matrix2d::Identity());
  for (const Eigen::Vector2d& shift :
       {Eigen::Vector2d(3.0, -2.0), Eigen::Vector2d(4.37, 2.81), Eigen::Vector2d(-5.5, 0.49)}) {
    const auto after = texture(shift, Eigen::Matrix2d::Identity(), 0.8, 30);
    const Eigen::Vector2d truth = kMiddle.cast<double>() + shift;
    const PatchMatch match = search_patch(view(after), patch, {kMiddle.cast<double>(), {8, 8}});
    ASSERT_TRUE(match.found);
    EXPECT_LT((match.pixel - truth).cwiseAbs().maxCoeff(), 1.0);
    EXPECT_GT(match.correlation, 0.9);
    const PatchAlignment fine = align_patch(view(after), patch, match.pixel);
    ASSERT_TRUE(fine.converged);
    EXPECT_LT((fine.pixel - truth).norm(), 0.05);
    EXPECT_NEAR(fine.gain, 0.8, 0.06);
    EXPECT_GT(fine.correlation, 0.98);
  }
}

TEST(PatchAlignment, FollowsATurnAndAScaleThatAreKnown) {
  const auto before = texture({0, 0}, Eigen::Matrix2d::Identity());
  StoredPatch stored;
  ASSERT_TRUE(store_patch(view(before), kMiddle, stored));
  const Eigen::Matrix2d turn = 1.1 * Eigen::Rotation2D<double>(0.3).toRotationMatrix();
  const Eigen::Vector2d shift(1.3, -0.6);
  const auto after = texture(shift, turn);
  const WarpedPatch patch = warped(stored, turn);
  const PatchMatch match = search_patch(view(after), patch, {kMiddle.cast<double>(), {5, 5}});
  ASSERT_TRUE(match.found);
  const PatchAlignment fine = align_patch(view(after), patch, match.pixel);
  ASSERT_TRUE(fine.converged);
  EXPECT_LT((fine.pixel - (kMiddle.cast<double>() + shift)).norm(), 0.06);
}

TEST(PatchAlignment, RefusesPatchesWithoutTextureAndWarpsThatLeaveThePatch) {
  const std::vector<std::uint8_t> plain(static_cast<std::size_t>(kSide * kSide), 90);
  StoredPatch stored;
  ASSERT_TRUE(store_patch(view(plain), kMiddle, stored));
  WarpedPatch patch;
  EXPECT_FALSE(warp_patch(stored, Eigen::Matrix2d::Identity(), 3.0, patch));
  const auto textured = texture({0, 0}, Eigen::Matrix2d::Identity());
  ASSERT_TRUE(store_patch(view(textured), kMiddle, stored));
  EXPECT_FALSE(warp_patch(stored, 2.5 * Eigen::Matrix2d::Identity(), 3.0, patch));
  EXPECT_FALSE(warp_patch(
      stored, Eigen::Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN()), 3.0, patch));
}

TEST(PatchAlignment, KeepsWithinTheImage) {
  const auto pixels = texture({0, 0}, Eigen::Matrix2d::Identity());
  StoredPatch stored;
  EXPECT_FALSE(store_patch(view(pixels), {9, 48}, stored));
  EXPECT_FALSE(store_patch(view(pixels), {48, kSide - 10}, stored));
  ASSERT_TRUE(store_patch(view(pixels), kMiddle, stored));
  const WarpedPatch patch = warped(stored, Eigen::Matrix2d::Identity());
  EXPECT_FALSE(search_patch(view(pixels), patch, {{-40, 20}, {5, 5}}).found);
  EXPECT_TRUE(search_patch(view(pixels), patch, {{0, 0}, {10, 10}}).found);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(search_patch(view(pixels), patch, {{nan, 20}, {5, 5}}).found);
  EXPECT_FALSE(align_patch(view(pixels), patch, {nan, nan}).converged);
  EXPECT_FALSE(align_patch(view(pixels), patch, {2, 2}).converged);
}

}  // namespace
}  // namespace pipescout::rack_vision
