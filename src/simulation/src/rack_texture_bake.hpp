// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "pipescout/simulation/rack_image.hpp"
#include "rack_texture_map.hpp"

namespace pipescout::simulation::internal {

/// Noise of eight octaves that wraps around, mean 0 and standard deviation 1: what all textures of
/// a scene are made of, each from other places of it.
class Fractal {
 public:
  static constexpr int kWidth = 512;
  static constexpr int kHeight = 4096;

  explicit Fractal(std::mt19937_64& engine);

  /// Any texel, wrapped.
  [[nodiscard]] float at(int x, int y) const noexcept {
    return values_[static_cast<std::size_t>(((y & (kHeight - 1)) * kWidth) + (x & (kWidth - 1)))];
  }
  /// The same, stretched `factor` times along x.
  [[nodiscard]] float stretched(int x, int y, int factor) const noexcept {
    const float left = at(x / factor, y);
    const auto share = static_cast<float>(x % factor) / static_cast<float>(factor);
    return left + share * (at(x / factor + 1, y) - left);
  }

 private:
  std::vector<float> values_;
};

/// Columns go once around a pipe, rows along it, both in equal steps.
inline constexpr int kTexelsAround = 512;

/// Paint, rust, streaks, weld seams, bands, stencilled signs and splashes on a pipe.
/// `plain`: stretches in metres along the pipe that show nothing but paint.
[[nodiscard]] TextureMap bake_pipe(const PipeFinish& finish, double radius, double length,
                                   std::span<const PlainStretch> plain, const Fractal& fractal,
                                   std::mt19937_64& engine);

/// Metres per texel of the ground and of the sheet that all other bodies wear.
inline constexpr float kGroundTexel = 0.0125F;
inline constexpr float kGrimeTexel = 0.004F;

/// Gravel between concrete slabs whose joints, kerbs and painted stripes run along y and across.
[[nodiscard]] TextureMap bake_ground(double albedo, const Fractal& fractal,
                                     std::mt19937_64& engine);

/// Weathered steel or cloth, mean 0.5.
[[nodiscard]] TextureMap bake_grime(const Fractal& fractal);

}  // namespace pipescout::simulation::internal
