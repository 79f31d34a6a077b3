// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "pipescout/simulation/rack_image.hpp"

namespace pipescout::simulation::internal {

/// Radiances with a border, so that filters need no case for the image's edge.
class Plane {
 public:
  static constexpr int kBorder = 24;

  Plane(int width, int height);
  [[nodiscard]] float* row(int y) noexcept {
    return values_.data() + static_cast<std::ptrdiff_t>(y + kBorder) * stride_ + kBorder;
  }
  [[nodiscard]] const float* row(int y) const noexcept {
    return values_.data() + static_cast<std::ptrdiff_t>(y + kBorder) * stride_ + kBorder;
  }
  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  /// Repeats the outermost pixels into the border.
  void extend() noexcept;

 private:
  int width_;
  int height_;
  int stride_;
  std::vector<float> values_;
};

/// From radiances to grey levels: lens blur, motion blur, vignetting, noise, 8 bits.
class Sensor {
 public:
  Sensor(const ImageSensor& parameters, const geometry::Camera& camera, std::uint64_t seed);

  /// Velocities of image points, pixels per second, one per tile of kTile x kTile pixels, row by
  /// row. All are zero at first.
  static constexpr int kTile = 16;
  [[nodiscard]] std::span<Eigen::Vector2f> velocities() noexcept { return velocities_; }
  [[nodiscard]] int tiles_across() const noexcept { return tiles_across_; }

  /// Overwrites `radiance`.
  void expose(Plane& radiance, const RackLight& light, std::uint64_t frame,
              std::span<std::uint8_t> grey) noexcept;

 private:
  void blur_by_lens(Plane& radiance) noexcept;
  const Plane& blur_by_motion(const Plane& radiance) noexcept;
  void blur_tile(const Plane& radiance, int x0, int y0, Eigen::Vector2f path) noexcept;

  ImageSensor parameters_;
  std::uint64_t seed_;
  int tiles_across_;
  std::vector<float> lens_;  // half of the kernel, from the middle
  std::vector<Eigen::Vector2f> velocities_;
  std::vector<float> vignetting_;
  std::vector<float> normals_;  // mean 0, standard deviation 1
  Plane scratch_;
};

}  // namespace pipescout::simulation::internal
