// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/gaussian_noise.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pipescout::tracking {
namespace {

constexpr std::size_t kPairs = 64;  // that are computed together
// A draw of 64 bits makes two pairs: of each, 20 bits for the radius, which reach 5.4 deviations,
// and 12 for the direction.
constexpr std::uint32_t kDirections = 1U << 12;
constexpr float kRadiusStep = 0x1p-20F;
constexpr float kTurnStep = 2.0F / kDirections;

/// ln(x) for x in (0, 1], to 2e-6.
inline float natural_logarithm(float x) {
  // x = m 2^e with m in [sqrt(1/2), sqrt(2)): ln(m) = 2 artanh((m - 1) / (m + 1)).
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t above = bits - 0x3f3504f3;  // of sqrt(1/2)
  const std::int32_t exponent = above >> 23;
  const float m = std::bit_cast<float>(bits - (exponent << 23));
  const float s = (m - 1.0F) / (m + 1.0F);
  const float s2 = s * s;
  const float series = 2.0F * s * (1.0F + s2 * (1.0F / 3 + s2 * (1.0F / 5)));
  return static_cast<float>(exponent) * 0.693147181F + series;
}

struct SineAndCosine {
  float sine;
  float cosine;
};

/// Of pi t, for t in [-1, 1], to 7e-4, by those of half the angle.
inline SineAndCosine of_half_turns(float t) {
  const float a = 1.57079633F * t;
  const float a2 = a * a;
  const float sine = a * (1.0F + a2 * (-1.0F / 6 + a2 * (1.0F / 120 + a2 * (-1.0F / 5040))));
  const float cosine =
      1.0F + a2 * (-0.5F + a2 * (1.0F / 24 + a2 * (-1.0F / 720 + a2 * (1.0F / 40320))));
  return {2.0F * sine * cosine, 1.0F - 2.0F * sine * sine};
}

}  // namespace

void draw_gaussian(std::mt19937_64& engine, std::span<float> noise) {
  std::array<std::uint32_t, kPairs> bits_of{};
  std::array<float, kPairs> first;
  std::array<float, kPairs> second;
  for (std::size_t begin = 0; begin < noise.size(); begin += 2 * kPairs) {
    const std::size_t count = std::min(2 * kPairs, noise.size() - begin);
    for (std::size_t i = 0; 2 * i < count; i += 2) {
      const std::uint64_t bits = engine();
      bits_of[i] = static_cast<std::uint32_t>(bits >> 32);
      bits_of[i + 1] = static_cast<std::uint32_t>(bits);
    }
    for (std::size_t i = 0; i < kPairs; ++i) {
      const auto of_radius = static_cast<std::int32_t>(bits_of[i] / kDirections);
      const auto of_turn = static_cast<std::int32_t>(bits_of[i] % kDirections);
      // In (0, 1), and in (-1, 1).
      const float uniform = (static_cast<float>(of_radius) + 0.5F) * kRadiusStep;
      const float turn = (static_cast<float>(of_turn) + 0.5F) * kTurnStep - 1.0F;
      const float radius = std::sqrt(-2.0F * natural_logarithm(uniform));
      const SineAndCosine direction = of_half_turns(turn);
      first[i] = radius * direction.cosine;
      second[i] = radius * direction.sine;
    }
    const std::size_t in_first = std::min(kPairs, (count + 1) / 2);
    std::copy_n(first.begin(), in_first, noise.begin() + static_cast<std::ptrdiff_t>(begin));
    std::copy_n(second.begin(), count - in_first,
                noise.begin() + static_cast<std::ptrdiff_t>(begin + in_first));
  }
}

}  // namespace pipescout::tracking
