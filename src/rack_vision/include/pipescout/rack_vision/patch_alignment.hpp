// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "pipescout/rack_vision/image_view.hpp"

/// Matching of a small texture patch. The paper matches descriptors (SIFT, SURF, ORB). Here the
/// surface is known, so that the patch can be warped to the new view: this is faster than a
/// descriptor, more precise (hundredths of a pixel), and rejects more outliers. Functions allocate
/// nothing, throw nothing and never read outside the image.
namespace pipescout::rack_vision {

/// Side of the compared window, px.
inline constexpr int kPatchSide = 11;
/// Side of the stored patch around a point, with margins for rotation and scale.
inline constexpr int kStoredPatchSide = 21;

/// Pixels around a point in its first image.
struct StoredPatch {
  std::array<std::uint8_t, kStoredPatchSide * kStoredPatchSide> pixels{};
  [[nodiscard]] double mean() const noexcept;  ///< grey level
};

/// A patch warped to a new view, with precomputed values of the alignment.
struct WarpedPatch {
  using Pixels = std::array<float, kPatchSide * kPatchSide>;
  Pixels values;            ///< grey levels, mean removed
  Pixels along_u, along_v;  ///< their derivatives, grey levels per px
  std::array<std::int16_t, kPatchSide * kPatchSide> rounded;  ///< of `values`
  std::int64_t energy = 0;                                    ///< sum of squares of `rounded`
  /// Inverse of the normal matrix of (du, dv, gain, bias).
  Eigen::Matrix4f normal_inverse;
  /// Information about the position: smaller eigenvalue of the 2x2 gradient matrix.
  float least_gradient_energy = 0;
};

/// Copies the pixels around `centre` (rounded to a whole pixel, the middle of the patch). False
/// when they are not all in the image.
[[nodiscard]] bool store_patch(const ImageView& image, const Eigen::Vector2i& centre,
                               StoredPatch& patch) noexcept;

/// `stored_from_current`: 2x2, from an offset in the new image to one in the stored patch, px/px.
/// `contrast`: smallest standard deviation of grey levels of a texture. False when the window
/// leaves the stored patch, or its texture does not determine a position.
[[nodiscard]] bool warp_patch(const StoredPatch& stored, const Eigen::Matrix2d& stored_from_current,
                              double contrast, WarpedPatch& warped) noexcept;

/// What white noise of the stored patch and of the new image does to a match.
struct PatchInNoise {
  double correlation = 1;  ///< that two images of the same place have, 0..1
  /// Of the standard deviation of its position: gradients of noise tell nothing of it, and the
  /// alignment takes them for texture.
  double widening = 1;
};
/// `noise`: grey levels, one sigma, >= 0.
[[nodiscard]] PatchInNoise patch_in_noise(const WarpedPatch& warped, double noise) noexcept;

/// A window to search: `centre` +- `half_size`, px, along u and v.
struct PatchWindow {
  Eigen::Vector2d centre;
  Eigen::Vector2d half_size;
};

struct PatchMatch {
  bool found = false;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double correlation = 0;  ///< zero-mean normalised, -1..1, at the whole pixel
  double second = -1;      ///< the best that is not adjacent to it
};

/// Best position of the patch in the window, to a whole pixel, by zero-mean normalised correlation.
/// Not found when the window has no position at which all pixels are in the image.
[[nodiscard]] PatchMatch search_patch(const ImageView& image, const WarpedPatch& patch,
                                      const PatchWindow& window) noexcept;

struct PatchAlignment {
  bool converged = false;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double gain = 0;         ///< of the brightness relative to the stored patch
  double residual = 0;     ///< rms, grey levels
  double correlation = 0;  ///< -1..1
  /// Of `pixel`, px^2, from the residual and the gradients of the patch.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// Inverse compositional alignment of position, gain and bias from an initial position within about
/// 1.5 px. Not converged when it moves farther than that, or out of the image.
[[nodiscard]] PatchAlignment align_patch(const ImageView& image, const WarpedPatch& patch,
                                         const Eigen::Vector2d& start, int iterations = 8) noexcept;

}  // namespace pipescout::rack_vision
