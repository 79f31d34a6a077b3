// SPDX-License-Identifier: Apache-2.0
#include "radius_rank.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::rack_vision {
namespace {

constexpr double kSpacing = 4;        // px, of samples along a contour
constexpr double kHalfStrength = 10;  // grey levels: a step that scores one half
constexpr double kLeastLength = 60;   // px, seen of a side
constexpr double kOfWidth = 0.4;      // of the pipe: how much wider to either side others are
constexpr int kLeastWider = 8;        // px: of the widest of the others
constexpr int kSame = 3;              // px to either side: not another radius
constexpr int kOwnShift = 2;          // px: that the pose may be wrong by

}  // namespace

void RadiusRank::add(const ImageView& image, const AlignmentContour& contour, Side& side) const {
  // Two px more on either side: the step is that between the means of two px each.
  std::array<float, kWidth + 4> profile;
  std::array<float, kWidth> sums{};
  const double length = (contour.end - contour.start).norm();
  const int samples = std::max(1, static_cast<int>(length / kSpacing));
  for (int j = 0; j < samples; ++j) {
    const Eigen::Vector2d middle =
        contour.start + (j + 0.5) / samples * (contour.end - contour.start);
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const Eigen::Vector2d ideal = middle + (static_cast<double>(i) - kReach - 2) * contour.normal;
      profile[i] = nearest_grey(image, camera_, ideal);
    }
    for (std::size_t i = 0; i < kWidth; ++i) {
      sums[i] += 0.5F * (profile[i + 4] + profile[i + 3] - profile[i + 1] - profile[i]);
    }
  }
  for (std::size_t i = 0; i < kWidth; ++i) {
    const double step = std::abs(static_cast<double>(sums[i])) / samples;
    side.strength[i] += length * step / (step + kHalfStrength);
  }
  side.middle += length * 0.5 * (contour.start + contour.end);
  side.length += length;
}

std::optional<double> RadiusRank::share_of_better(
    const ImageView& image, std::span<const AlignmentContour> contours) const {
  std::array<Side, 2> sides;
  for (const AlignmentContour& contour : contours) {
    const bool other = contour.normal.dot(contours.front().normal) < 0;
    add(image, contour, sides[other ? 1 : 0]);
  }
  if (std::min(sides[0].length, sides[1].length) < kLeastLength) {
    return std::nullopt;
  }
  const double width = std::abs(contours.front().normal.dot(sides[0].middle / sides[0].length -
                                                            sides[1].middle / sides[1].length));
  const int widest = std::clamp(static_cast<int>(kOfWidth * width), kLeastWider, kMostWider);
  const int narrowest = -std::min(widest, static_cast<int>(0.5 * width) - kSame);
  if (narrowest >= -kSame) {
    return std::nullopt;
  }
  const auto strength = [&](int wider, int most_shift) {
    double best = 0;
    for (int shift = -most_shift; shift <= most_shift; ++shift) {
      const auto at = [&](int outwards) { return static_cast<std::size_t>(kReach + outwards); };
      best = std::max(best, sides[0].strength[at(wider + shift)] / sides[0].length +
                                sides[1].strength[at(wider - shift)] / sides[1].length);
    }
    return best;
  };
  const double own = strength(0, kOwnShift);
  int others = 0;
  int better = 0;
  for (int wider = narrowest; wider <= widest; ++wider) {
    if (std::abs(wider) > kSame) {
      ++others;
      better += strength(wider, kOtherShift) >= own ? 1 : 0;
    }
  }
  return (better + 0.5) / (others + 1.0);
}

}  // namespace pipescout::rack_vision
