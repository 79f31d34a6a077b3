// SPDX-License-Identifier: Apache-2.0
#include "rack_image_sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr std::size_t kNormals = std::size_t{1} << 18U;
/// Longer paths are cut: the border of the plane ends there.
constexpr float kLongestPath = 2.0F * (Plane::kBorder - 2);
/// Pixels; shorter paths leave an image as it is to a thousandth of a level.
constexpr float kShortestPath = 0.05F;

}  // namespace

Plane::Plane(int width, int height)
    : width_(width),
      height_(height),
      stride_(width + 2 * kBorder),
      values_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2 * kBorder)) {}

void Plane::extend() noexcept {
  for (int y = 0; y < height_; ++y) {
    float* line = row(y);
    std::fill(line - kBorder, line, line[0]);
    std::fill(line + width_, line + width_ + kBorder, line[width_ - 1]);
  }
  for (int y = 1; y <= kBorder; ++y) {
    std::copy_n(row(0) - kBorder, stride_, row(-y) - kBorder);
    std::copy_n(row(height_ - 1) - kBorder, stride_, row(height_ - 1 + y) - kBorder);
  }
}

Sensor::Sensor(const ImageSensor& parameters, const geometry::Camera& camera, std::uint64_t seed)
    : parameters_(parameters),
      seed_(seed),
      scratch_(camera.parameters().width, camera.parameters().height) {
  const geometry::CameraParameters& c = camera.parameters();
  tiles_across_ = (c.width + kTile - 1) / kTile;
  const int tiles_down = (c.height + kTile - 1) / kTile;
  velocities_.assign(static_cast<std::size_t>(tiles_across_ * tiles_down), Eigen::Vector2f::Zero());
  if (parameters.lens_blur > 0) {
    const int reach =
        std::min(Plane::kBorder, static_cast<int>(std::ceil(4 * parameters.lens_blur)));
    // Of each pixel the share of the Gaussian over it, less that of the pixel itself: the radiances
    // are already means over pixels, so the weights are plain samples whose second moment is right.
    double sum = 0;
    std::vector<double> weights;
    for (int i = 0; i <= reach; ++i) {
      const double x = i / parameters.lens_blur;
      weights.push_back(std::exp(-0.5 * x * x));
      sum += (i == 0 ? 1 : 2) * weights.back();
    }
    for (const double weight : weights) {
      lens_.push_back(static_cast<float>(weight / sum));
    }
  }
  const Eigen::Vector2d centre(c.centre_u, c.centre_v);
  double farthest = 0;
  for (const double u : {0.0, c.width - 1.0}) {
    for (const double v : {0.0, c.height - 1.0}) {
      farthest = std::max(farthest, (Eigen::Vector2d(u, v) - centre).squaredNorm());
    }
  }
  for (int v = 0; v < c.height; ++v) {
    for (int u = 0; u < c.width; ++u) {
      const double squared = (Eigen::Vector2d(u, v) - centre).squaredNorm();
      vignetting_.push_back(
          static_cast<float>(1 - parameters.vignetting * squared / std::max(farthest, 1.0)));
    }
  }
  std::mt19937_64 engine = statistics::make_engine(seed, 0x5e);
  normals_.resize(kNormals + static_cast<std::size_t>(c.width));
  for (std::size_t i = 0; i < kNormals; ++i) {
    normals_[i] = static_cast<float>(statistics::normal(engine));
  }
  // A row may begin anywhere in the table.
  std::copy_n(normals_.begin(), c.width, normals_.begin() + kNormals);
}

void Sensor::blur_by_lens(Plane& radiance) noexcept {
  const int reach = static_cast<int>(lens_.size()) - 1;
  if (reach < 1) {
    return;
  }
  radiance.extend();
  const int width = radiance.width();
  // Down first, so that the border to the left and the right is blurred for the second step too.
  for (int y = 0; y < radiance.height(); ++y) {
    const int columns = width + 2 * Plane::kBorder;
    float* out = scratch_.row(y) - Plane::kBorder;
    const float* middle = radiance.row(y) - Plane::kBorder;
    for (int x = 0; x < columns; ++x) {
      out[x] = lens_[0] * middle[x];
    }
    for (int n = 1; n <= reach; ++n) {
      const float weight = lens_[static_cast<std::size_t>(n)];
      const float* upper = radiance.row(y - n) - Plane::kBorder;
      const float* lower = radiance.row(y + n) - Plane::kBorder;
      for (int x = 0; x < columns; ++x) {
        out[x] += weight * (upper[x] + lower[x]);
      }
    }
  }
  for (int y = 0; y < radiance.height(); ++y) {
    const float* in = scratch_.row(y);
    float* out = radiance.row(y);
    for (int x = 0; x < width; ++x) {
      out[x] = lens_[0] * in[x];
    }
    for (int n = 1; n <= reach; ++n) {
      const float weight = lens_[static_cast<std::size_t>(n)];
      for (int x = 0; x < width; ++x) {
        out[x] += weight * (in[x - n] + in[x + n]);
      }
    }
  }
}

void Sensor::blur_tile(const Plane& radiance, int x0, int y0, Eigen::Vector2f path) noexcept {
  const int width = std::min(kTile, radiance.width() - x0);
  const int height = std::min(kTile, radiance.height() - y0);
  // The path as a kernel over whole pixels: points evenly along it, each shared by its neighbours.
  constexpr int kReach = Plane::kBorder;
  constexpr int kSize = 2 * kReach + 1;
  std::array<float, std::size_t{kSize} * kSize> kernel{};
  const float length = path.norm();
  if (length > kLongestPath) {
    path *= kLongestPath / length;
  }
  const int points = length < kShortestPath ? 1 : 2 * static_cast<int>(std::ceil(length)) + 1;
  int reach = 0;
  float spread = 0;  // variance along u and along v of the kernel, together
  for (int n = 0; n < points; ++n) {
    const float place = (static_cast<float>(n) + 0.5F) / static_cast<float>(points) - 0.5F;
    const float x = place * path.x();
    const float y = place * path.y();
    const int i = static_cast<int>(std::floor(x));
    const int j = static_cast<int>(std::floor(y));
    const float fx = x - static_cast<float>(i);
    const float fy = y - static_cast<float>(j);
    const float weight = 1 / static_cast<float>(points);
    const auto at = [&kernel](int column, int row) -> float& {
      return kernel[static_cast<std::size_t>((row + kReach) * kSize + column + kReach)];
    };
    at(i, j) += weight * (1 - fx) * (1 - fy);
    at(i + 1, j) += weight * fx * (1 - fy);
    at(i, j + 1) += weight * (1 - fx) * fy;
    at(i + 1, j + 1) += weight * fx * fy;
    spread += weight * (x * x + fx * (1 - fx) + y * y + fy * (1 - fy));
    reach = std::max({reach, std::abs(i), std::abs(i + 1), std::abs(j), std::abs(j + 1)});
  }
  // Sharing a point among its neighbours spreads it; leaving part of the image where it was makes
  // up for that, so that the blur has the variance of the path.
  const float moved = spread > 0 ? std::min(1.0F, path.squaredNorm() / 12 / spread) : 0.0F;
  for (float& weight : kernel) {
    weight *= moved;
  }
  kernel[static_cast<std::size_t>(kReach * kSize + kReach)] += 1 - moved;
  for (int y = 0; y < height; ++y) {
    float* out = scratch_.row(y0 + y) + x0;
    std::fill(out, out + width, 0.0F);
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        const float weight = kernel[static_cast<std::size_t>((j + kReach) * kSize + i + kReach)];
        if (weight > 0) {
          const float* in = radiance.row(y0 + y + j) + x0 + i;
          for (int x = 0; x < width; ++x) {
            out[x] += weight * in[x];
          }
        }
      }
    }
  }
}

const Plane& Sensor::blur_by_motion(const Plane& radiance) noexcept {
  const auto exposure = static_cast<float>(parameters_.exposure);
  for (std::size_t i = 0; i < velocities_.size(); ++i) {
    const int tile = static_cast<int>(i);
    blur_tile(radiance, tile % tiles_across_ * kTile, tile / tiles_across_ * kTile,
              exposure * velocities_[i]);
  }
  return scratch_;
}

void Sensor::expose(Plane& radiance, const RackLight& light, std::uint64_t frame,
                    std::span<std::uint8_t> grey) noexcept {
  blur_by_lens(radiance);
  const bool moves = std::ranges::any_of(velocities_, [this](const Eigen::Vector2f& velocity) {
    return velocity.norm() * static_cast<float>(parameters_.exposure) >= kShortestPath;
  });
  const Plane* blurred = &radiance;
  if (moves) {
    radiance.extend();
    blurred = &blur_by_motion(radiance);
  }
  // One word of seed, unlike make_engine: that one allocates.
  std::mt19937_64 engine(seed_ * 0x9e3779b97f4a7c15U + frame);
  const auto gain = static_cast<float>(255 * light.gain);
  const auto offset = static_cast<float>(light.offset);
  const auto read_variance = static_cast<float>(parameters_.read_noise * parameters_.read_noise);
  const auto shot = static_cast<float>(
      parameters_.electrons_per_level > 0 ? 1 / parameters_.electrons_per_level : 0);
  const int width = radiance.width();
  for (int y = 0; y < radiance.height(); ++y) {
    const float* in = blurred->row(y);
    const float* normals = normals_.data() + (engine() & (kNormals - 1));
    const float* vignetting = vignetting_.data() + static_cast<std::ptrdiff_t>(y) * width;
    std::uint8_t* out = grey.data() + static_cast<std::ptrdiff_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      const float signal = gain * vignetting[x] * in[x];
      const float deviation = std::sqrt(read_variance + shot * signal);
      const float level = signal + offset + deviation * normals[x] + 0.5F;
      const float above = level > 0 ? level : 0.0F;
      out[x] = static_cast<std::uint8_t>(static_cast<int>(above < 255 ? above : 255.0F));
    }
  }
}

}  // namespace pipescout::simulation::internal
