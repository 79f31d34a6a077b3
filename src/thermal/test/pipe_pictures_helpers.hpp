// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

#include "pipescout/thermal/image.hpp"

namespace pipescout::thermal::test {

/// A picture of temperatures that pipes are drawn into.
class Picture {
 public:
  Picture(int width, int height, float background = 20.0F)
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background) {}

  struct Warm {  ///< a stretch along a pipe, pixels from its first point
    double from = 0;
    double to = 0;
    double celsius = 0;
  };

  /// A straight pipe from a to b, its ends square; the edges mix with what was there before.
  Picture& pipe(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half_width,
                double celsius, const std::vector<Warm>& warm = {});
  /// What is between two circles about a point.
  Picture& ring(const Eigen::Vector2d& centre, double radius, double half_width, double celsius);
  /// Pixels from (x, y) on.
  Picture& box(int x, int y, int width, int height, double celsius);
  Picture& noise(double deviation, std::uint64_t seed);

  [[nodiscard]] float& at(int x, int y) {
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  [[nodiscard]] TemperatureView view() const { return {pixels_.data(), width_, height_, width_}; }
  /// 16 bits, `kCountsPerKelvin` from -100 degC on, with rows of `stride` pixels.
  [[nodiscard]] std::vector<std::uint16_t> counts(int stride) const;
  static constexpr double kCountsPerKelvin = 100;
  [[nodiscard]] static std::vector<float> table();

 private:
  int width_;
  int height_;
  std::vector<float> pixels_;
};

}  // namespace pipescout::thermal::test
