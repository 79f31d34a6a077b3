// SPDX-License-Identifier: Apache-2.0
#include "texture_corner.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace pipescout::rack_vision {
namespace {

constexpr int kReach = 3;  // of the window
constexpr int kWindow = 2 * kReach + 1;
constexpr int kWidest = kLargestCell + 2 * kReach;

/// Products of derivatives, which are twice what they are per pixel: whole numbers.
struct GradientRow {
  std::array<std::int32_t, kWidest> uu, uv, vv;
};

/// Products of the derivatives along one row of the image, summed over the window's width.
void gradient_row(const ImageView& image, int v, int u, int width, GradientRow& out) noexcept {
  GradientRow products;
  const std::uint8_t* above = image.row(v - 1) + u;
  const std::uint8_t* here = image.row(v) + u;
  const std::uint8_t* below = image.row(v + 1) + u;
  for (int i = 0; i < width + 2 * kReach; ++i) {
    const auto along_u = static_cast<std::int16_t>(here[i + 1 - kReach] - here[i - 1 - kReach]);
    const auto along_v = static_cast<std::int16_t>(below[i - kReach] - above[i - kReach]);
    const auto at = static_cast<std::size_t>(i);
    products.uu[at] = along_u * along_u;
    products.uv[at] = along_u * along_v;
    products.vv[at] = along_v * along_v;
  }
  for (int i = 0; i < width; ++i) {
    std::int32_t uu = 0;
    std::int32_t uv = 0;
    std::int32_t vv = 0;
    for (int j = 0; j < kWindow; ++j) {
      const auto at = static_cast<std::size_t>(i + j);
      uu += products.uu[at];
      uv += products.uv[at];
      vv += products.vv[at];
    }
    const auto at = static_cast<std::size_t>(i);
    out.uu[at] = uu;
    out.uv[at] = uv;
    out.vv[at] = vv;
  }
}

}  // namespace

std::optional<Eigen::Vector2i> strongest_corner(const ImageView& image, const Eigen::Vector2i& low,
                                                int side, float least) noexcept {
  std::array<GradientRow, kWindow> rows;
  GradientRow sums;
  sums.uu.fill(0);
  sums.uv.fill(0);
  sums.vv.fill(0);
  std::optional<Eigen::Vector2i> best;
  // Sums hold four times the squared derivatives per pixel.
  float strongest = 4 * least * static_cast<float>(kWindow * kWindow);
  for (int row = -kReach; row < side + kReach; ++row) {
    GradientRow& ring = rows[static_cast<std::size_t>((row + kReach) % kWindow)];
    const bool full = row >= kReach + 1;
    for (int i = 0; full && i < side; ++i) {
      const auto at = static_cast<std::size_t>(i);
      sums.uu[at] -= ring.uu[at];
      sums.uv[at] -= ring.uv[at];
      sums.vv[at] -= ring.vv[at];
    }
    gradient_row(image, low.y() + row, low.x(), side, ring);
    for (int i = 0; i < side; ++i) {
      const auto at = static_cast<std::size_t>(i);
      sums.uu[at] += ring.uu[at];
      sums.uv[at] += ring.uv[at];
      sums.vv[at] += ring.vv[at];
    }
    if (row < kReach) {
      continue;
    }
    // The smaller eigenvalue is never above half the trace: most rows end here.
    const float bound = 2 * strongest;
    int above = 0;
    for (int i = 0; i < side; ++i) {
      const auto at = static_cast<std::size_t>(i);
      above += static_cast<float>(sums.uu[at] + sums.vv[at]) > bound ? 1 : 0;
    }
    for (int i = 0; above > 0 && i < side; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const auto trace = static_cast<float>(sums.uu[at] + sums.vv[at]);
      if (trace <= 2 * strongest) {
        continue;
      }
      const float half = 0.5F * static_cast<float>(sums.uu[at] - sums.vv[at]);
      const auto mixed = static_cast<float>(sums.uv[at]);
      const float smaller = 0.5F * trace - std::sqrt(half * half + mixed * mixed);
      if (smaller > strongest) {
        strongest = smaller;
        best = Eigen::Vector2i(low.x() + i, low.y() + row - kReach);
      }
    }
  }
  return best;
}

}  // namespace pipescout::rack_vision
