// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "pipescout/rack_vision/image_view.hpp"

/// Noise of an image, measured in the image itself: it decides what is an edge, a texture point and
/// a match.
namespace pipescout::rack_vision {

/// Noise up to which the parameters of EdgeSearch and TextureMap hold as they are stated, grey
/// levels, one sigma: that of an industrial camera by day. Above it their contrasts grow in
/// proportion.
inline constexpr double kNominalNoise = 2.0;

/// Standard deviation of the noise as a function of the grey level: photons make it larger where it
/// is brighter, a camera's tone curve may do the opposite.
///
/// Immerkaer (1996), Fast noise variance estimation: the mean absolute response to the difference
/// of two Laplacians, to which a plane is zero. Here of small blocks, and of these a low quantile
/// for each range of grey levels, because texture and edges only ever add to it.
class ImageNoise {
 public:
  /// Takes some tens of microseconds for 720 x 480. Allocates nothing. An image that is not valid,
  /// or is too small, has no noise.
  void measure(const ImageView& image) noexcept;

  /// Of pixels of this grey level, grey levels, one sigma.
  [[nodiscard]] double sigma(double level) const noexcept;
  /// What of it is beyond kNominalNoise: 0 up to that, all of it from one and a half times that.
  [[nodiscard]] double excess(double level) const noexcept;
  /// Smallest standard deviation of a patch that texture makes, where it is `least` up to
  /// kNominalNoise: twice that of the noise, so that at least three quarters of its variance are
  /// texture.
  [[nodiscard]] double texture_contrast(double least, double level) const noexcept;

  static constexpr std::size_t kLevels = 8;  ///< ranges of grey levels

 private:
  std::array<double, kLevels> sigma_{};  ///< in the middle of each range
};

}  // namespace pipescout::rack_vision
