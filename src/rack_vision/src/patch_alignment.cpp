// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/patch_alignment.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "bilinear.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kHalf = kPatchSide / 2;
constexpr int kStoredHalf = kStoredPatchSide / 2;
constexpr int kArea = kPatchSide * kPatchSide;
constexpr double kLongestWalk = 2.5;        // px, of an alignment
constexpr double kConverged = 0.005;        // px, last step
constexpr float kLeastEnergyRatio = 0.02F;  // of the gradient's smaller eigenvalue to contrast

/// Sums over all pixels: Eigen adds several at a time.
using PixelVector = Eigen::Matrix<float, kArea, 1>;
Eigen::Map<const PixelVector> as_vector(const WarpedPatch::Pixels& pixels) noexcept {
  return Eigen::Map<const PixelVector>(pixels.data());
}

/// kArea rounded up to what fills whole vectors. What is beyond kArea is zero.
constexpr int kPaddedArea = 128;
template <typename Value>
using Padded = std::array<Value, kPaddedArea>;

struct WindowSums {
  std::int16_t sum = 0;  // 121 pixels of at most 255
  std::int32_t squares = 0;
  std::int32_t product = 0;
};

WindowSums window_sums(const ImageView& image, const Padded<std::int16_t>& values, int u,
                       int v) noexcept {
  Padded<std::uint8_t> pixels;
  std::fill(pixels.begin() + kArea, pixels.end(), std::uint8_t{0});
  const std::uint8_t* from = image.row(v - kHalf) + (u - kHalf);
  for (int row = 0; row < kPatchSide; ++row) {
    std::copy_n(from + row * image.stride, kPatchSide, pixels.begin() + row * kPatchSide);
  }
  WindowSums sums;
  for (std::size_t i = 0; i < kPaddedArea; ++i) {
    const std::int16_t pixel = pixels[i];
    sums.sum = static_cast<std::int16_t>(sums.sum + pixel);
    sums.squares += pixel * pixel;
    sums.product += pixel * values[i];
  }
  return sums;
}

/// `values` and `energy`: of the patch, rounded.
double correlation_at(const ImageView& image, const Padded<std::int16_t>& values, double energy,
                      int u, int v) noexcept {
  const WindowSums sums = window_sums(image, values, u, v);
  // The patch has no mean, so that of the window drops out of the product.
  const double variance =
      static_cast<double>(sums.squares) - static_cast<double>(sums.sum) * sums.sum / kArea;
  return variance > kArea ? sums.product / std::sqrt(variance * energy) : -1.0;
}

/// Values of the image around `pixel`, by bilinear interpolation: all share one fraction.
void sample_window(const ImageView& image, const Eigen::Vector2d& pixel,
                   WarpedPatch::Pixels& values) noexcept {
  const int u = static_cast<int>(std::floor(pixel.x()));
  const int v = static_cast<int>(std::floor(pixel.y()));
  const auto fu = static_cast<float>(pixel.x() - u);
  const auto fv = static_cast<float>(pixel.y() - v);
  const float w00 = (1 - fu) * (1 - fv);
  const float w10 = fu * (1 - fv);
  const float w01 = (1 - fu) * fv;
  const float w11 = fu * fv;
  // One pixel more to the right and below, and one after the last for the row's end, which goes by
  // with the rest: one long loop is vectorised, eleven short ones are not.
  constexpr std::size_t kSide = kPatchSide + 1;
  std::array<std::uint8_t, kSide * kSide> pixels;
  for (std::size_t row = 0; row < kSide; ++row) {
    std::copy_n(image.row(v - kHalf + static_cast<int>(row)) + (u - kHalf), kSide,
                pixels.begin() + row * kSide);
  }
  std::array<float, kSide * kSide + 1> levels{};
  std::ranges::copy(pixels, levels.begin());
  std::array<float, kPatchSide * kSide> between;
  for (std::size_t i = 0; i < between.size(); ++i) {
    between[i] = w00 * levels[i] + w10 * levels[i + 1] + w01 * levels[i + kSide] +
                 w11 * levels[i + kSide + 1];
  }
  for (std::size_t row = 0; row < kPatchSide; ++row) {
    std::copy_n(between.begin() + row * kSide, kPatchSide, values.begin() + row * kPatchSide);
  }
}

bool window_fits(const ImageView& image, const Eigen::Vector2d& pixel) noexcept {
  return pixel.x() >= kHalf && pixel.y() >= kHalf && pixel.x() < image.width - kHalf - 1 &&
         pixel.y() < image.height - kHalf - 1;
}

/// Moments of the window against the patch: the right-hand side of the normal equations, and what
/// the residual needs.
struct AlignmentSums {
  Eigen::Vector4f right = Eigen::Vector4f::Zero();
  float squares = 0;
};

AlignmentSums alignment_sums(const WarpedPatch& patch, const WarpedPatch::Pixels& window) noexcept {
  // The bias absorbs the mean: numbers stay small.
  const PixelVector value = as_vector(window).array() - as_vector(window).mean();
  return {{as_vector(patch.along_u).dot(value), as_vector(patch.along_v).dot(value),
           as_vector(patch.values).dot(value), value.sum()},
          value.squaredNorm()};
}

}  // namespace

bool store_patch(const ImageView& image, const Eigen::Vector2i& centre,
                 StoredPatch& patch) noexcept {
  if (centre.x() < kStoredHalf || centre.y() < kStoredHalf ||
      centre.x() >= image.width - kStoredHalf || centre.y() >= image.height - kStoredHalf) {
    return false;
  }
  for (int row = 0; row < kStoredPatchSide; ++row) {
    const std::uint8_t* pixels =
        image.row(centre.y() - kStoredHalf + row) + (centre.x() - kStoredHalf);
    std::copy_n(pixels, kStoredPatchSide, patch.pixels.begin() + row * kStoredPatchSide);
  }
  return true;
}

bool warp_patch(const StoredPatch& stored, const Eigen::Matrix2d& stored_from_current,
                double contrast, WarpedPatch& warped) noexcept {
  // One pixel more on each side, for the derivatives.
  constexpr int kSide = kPatchSide + 2;
  constexpr double kReach = kHalf + 1;
  const Eigen::Vector2d reach = stored_from_current.cwiseAbs().rowwise().sum() * kReach;
  if (!(reach.maxCoeff() < kStoredHalf)) {
    return false;
  }
  BilinearSamples<kSide * kSide> samples;
  const auto step_u = static_cast<float>(stored_from_current(0, 0));
  const auto step_v = static_cast<float>(stored_from_current(1, 0));
  for (int row = 0; row < kSide; ++row) {
    const Eigen::Vector2d start = stored_from_current * Eigen::Vector2d(-kReach, row - kReach) +
                                  Eigen::Vector2d(kStoredHalf, kStoredHalf);
    auto u = static_cast<float>(start.x());
    auto v = static_cast<float>(start.y());
    for (int i = 0; i < kSide; ++i, u += step_u, v += step_v) {
      samples.add(u, v);
    }
  }
  std::array<float, kSide * kSide> values;
  samples.read({stored.pixels.data(), kStoredPatchSide, kStoredPatchSide, kStoredPatchSide},
               values);
  for (int row = 0; row < kPatchSide; ++row) {
    for (int i = 0; i < kPatchSide; ++i) {
      const auto from = static_cast<std::size_t>((row + 1) * kSide + i + 1);
      const auto to = static_cast<std::size_t>(row * kPatchSide + i);
      warped.values[to] = values[from];
      warped.along_u[to] = 0.5F * (values[from + 1] - values[from - 1]);
      warped.along_v[to] = 0.5F * (values[from + kSide] - values[from - kSide]);
    }
  }
  const float mean = as_vector(warped.values).mean();
  std::int32_t energy = 0;
  for (std::size_t i = 0; i < warped.values.size(); ++i) {
    warped.values[i] -= mean;
    warped.rounded[i] =
        static_cast<std::int16_t>(warped.values[i] + std::copysign(0.5F, warped.values[i]));
    energy += warped.rounded[i] * warped.rounded[i];
  }
  warped.energy = energy;
  Eigen::Matrix<float, kArea, 4> rows;
  rows << as_vector(warped.along_u), as_vector(warped.along_v), as_vector(warped.values),
      PixelVector::Ones();
  Eigen::Matrix4f normal;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      normal(i, j) = normal(j, i) = rows.col(i).dot(rows.col(j));
    }
  }
  const float half_trace = 0.5F * (normal(0, 0) + normal(1, 1));
  const float half_difference = 0.5F * (normal(0, 0) - normal(1, 1));
  warped.least_gradient_energy = half_trace - std::hypot(half_difference, normal(0, 1));
  const auto least = static_cast<float>(contrast * contrast * kArea);
  if (!(normal(2, 2) > least) || !(warped.least_gradient_energy > kLeastEnergyRatio * least)) {
    return false;
  }
  warped.normal_inverse = normal.inverse();
  return warped.normal_inverse.allFinite();
}

double StoredPatch::mean() const noexcept {
  int sum = 0;
  for (const std::uint8_t pixel : pixels) {
    sum += pixel;
  }
  return static_cast<double>(sum) / static_cast<double>(pixels.size());
}

PatchInNoise patch_in_noise(const WarpedPatch& warped, double noise) noexcept {
  static constexpr double kLeastShare = 0.2;
  const double energy = noise * noise * kArea;
  const auto share = [](double noise_energy, double whole) {
    return std::max(kLeastShare, 1 - noise_energy / std::max(whole, 1e-9));
  };
  // A derivative over two pixels has half the variance of a pixel.
  return {share(energy, static_cast<double>(warped.energy)),
          1 / share(0.5 * energy, static_cast<double>(warped.least_gradient_energy))};
}

PatchMatch search_patch(const ImageView& image, const WarpedPatch& patch,
                        const PatchWindow& window) noexcept {
  // Written so that NaN gives an empty window.
  const auto bound = [](double value, int low, int high) {
    return value > low ? (value < high ? static_cast<int>(std::lround(value)) : high) : low;
  };
  PatchMatch best;
  const Eigen::Vector2d low = window.centre - window.half_size;
  const Eigen::Vector2d high = window.centre + window.half_size;
  if (!low.allFinite() || !high.allFinite() || high.x() < kHalf || high.y() < kHalf ||
      low.x() > image.width - 1 - kHalf || low.y() > image.height - 1 - kHalf) {
    return best;
  }
  const int first_u = bound(low.x(), kHalf, image.width - 1 - kHalf);
  const int last_u = bound(high.x(), kHalf, image.width - 1 - kHalf);
  const int first_v = bound(low.y(), kHalf, image.height - 1 - kHalf);
  const int last_v = bound(high.y(), kHalf, image.height - 1 - kHalf);
  best.correlation = -1;
  Padded<std::int16_t> values{};
  std::ranges::copy(patch.rounded, values.begin());
  const auto energy = static_cast<double>(patch.energy);
  int best_u = first_u;
  int best_v = first_v;
  for (int v = first_v; v <= last_v; ++v) {
    for (int u = first_u; u <= last_u; ++u) {
      const double correlation = correlation_at(image, values, energy, u, v);
      const bool near = std::abs(u - best_u) <= 2 && std::abs(v - best_v) <= 2;
      if (correlation > best.correlation) {
        if (!near) {
          best.second = std::max(best.second, best.correlation);
        }
        best.correlation = correlation;
        best_u = u;
        best_v = v;
        best.found = true;
      } else if (!near) {
        best.second = std::max(best.second, correlation);
      }
    }
  }
  best.pixel = {best_u, best_v};
  return best;
}

PatchAlignment align_patch(const ImageView& image, const WarpedPatch& patch,
                           const Eigen::Vector2d& start, int iterations) noexcept {
  PatchAlignment result;
  if (!start.allFinite()) {
    return result;
  }
  Eigen::Vector2d pixel = start;
  WarpedPatch::Pixels window;
  AlignmentSums sums;
  Eigen::Vector4f solution = Eigen::Vector4f::Zero();
  for (int i = 0; i < iterations; ++i) {
    if (!window_fits(image, pixel)) {
      return result;
    }
    sample_window(image, pixel, window);
    sums = alignment_sums(patch, window);
    solution = patch.normal_inverse * sums.right;
    const float gain = solution(2);
    if (!(gain > 0.1F)) {
      return result;
    }
    // window(x) = gain patch(x + d) + bias: the window lies d too far.
    const Eigen::Vector2d step = solution.head<2>().cast<double>() / static_cast<double>(gain);
    const double length = step.norm();
    pixel -= length > 1 ? Eigen::Vector2d(step / length) : step;
    if (!((pixel - start).norm() < kLongestWalk)) {
      return result;
    }
    if (length < kConverged) {
      result.converged = true;
      break;
    }
  }
  result.pixel = pixel;
  result.gain = static_cast<double>(solution(2));
  const double left = std::max(0.0, static_cast<double>(sums.squares - solution.dot(sums.right)));
  result.residual = std::sqrt(left / (kArea - 4));
  result.correlation =
      sums.squares > 0 ? std::sqrt(std::max(0.0, 1 - left / static_cast<double>(sums.squares))) : 0;
  const double per_gain = result.residual / result.gain;
  result.covariance =
      patch.normal_inverse.topLeftCorner<2, 2>().cast<double>() * (per_gain * per_gain);
  return result;
}

}  // namespace pipescout::rack_vision
