// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/leak_detector.hpp"

/// Evidence of a finding: image, profile and parts.
namespace pipescout {

/// A section of an image for display: colours for temperatures, without annotations.
struct Thumbnail {
  int width = 0;  ///< pixels of the thumbnail
  int height = 0;
  std::vector<std::uint8_t> png;
  double coldest = 0;  ///< degC, of the first colour
  double hottest = 0;  ///< degC, of the last
};

/// A line to draw over a thumbnail, in its pixels.
struct OverlayLine {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double half_width = 0;  ///< of the object that it represents
};

/// Part of a pipe in its profile; places in samples.
struct ProfilePart {
  double from = 0;
  double to = 0;
  double mean = 0;  ///< degC; NaN where hidden
  thermal::PartKind kind = thermal::PartKind::kPipe;
};

/// One image of one leak.
struct Evidence {
  double time = 0;     ///< s, of the finding's clock
  std::string source;  ///< file, or topic and frame
  Thumbnail thumbnail;
  OverlayLine pipe;
  OverlayLine leak;
  /// Along the pipe: degC, one a sample; NaN where it is hidden.
  std::vector<float> profile;
  std::vector<ProfilePart> parts;
  double leak_from = 0;  ///< samples
  double leak_to = 0;
  double metres_per_sample = 0;      ///< 0: not known
  double reference_temperature = 0;  ///< degC, of the sound pipe; NaN: not known
  int split_distance = 1;            ///< samples, distance over which the change was computed
  double split_delta = 0;            ///< K, change at which the pipe was split
};

/// The image around `leak`, which is one of `detections.leaks`, with its pipe's profile. The
/// arguments are copied. Throws std::invalid_argument when there is no such leak or the image size
/// differs from that of the detections.
[[nodiscard]] Evidence make_evidence(const thermal::TemperatureView& picture,
                                     const thermal::Detections& detections, std::size_t leak,
                                     const thermal::ProfileParameters& profile, double time,
                                     std::string source);

/// A whole image with its pipes, with at most `largest` pixels per side.
struct Overview {
  Thumbnail thumbnail;
  std::vector<OverlayLine> pipes;
  std::vector<OverlayLine> leaks;
};
[[nodiscard]] Overview make_overview(const thermal::TemperatureView& picture,
                                     const thermal::Detections& detections, int largest);

}  // namespace pipescout
