// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "image_source.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout::track {

/// Tracks a pipe from image to image, without knowing how the camera moves, and keeps a line of CSV
/// for each.
class PipeTracks {
 public:
  PipeTracks(const thermal::LeakDetectorParameters& detector, std::uint64_t seed);

  void take(const SourceImage& image);
  /// An image that could not be used.
  void fail(const std::string& name, const std::string& problem);

  [[nodiscard]] const std::string& csv() const noexcept { return csv_; }
  /// In words, with line ends.
  [[nodiscard]] std::string summary() const;
  /// Why there may be no track though there are pipes; empty: there is one.
  [[nodiscard]] std::string advice() const;
  [[nodiscard]] std::size_t failed() const noexcept { return failed_; }
  /// Images that were taken, and those of them in which a pipe was detected.
  [[nodiscard]] std::size_t images() const noexcept { return images_; }
  [[nodiscard]] std::size_t with_pipes() const noexcept { return with_pipes_; }
  /// Of the last image.
  [[nodiscard]] const std::vector<tracking::PipeRegion>& regions() const noexcept {
    return regions_;
  }
  [[nodiscard]] const tracking::PipeTrack& track() const noexcept { return tracker_.track(); }

 private:
  thermal::LeakDetector detector_;
  tracking::PipeTracker tracker_;
  std::vector<tracking::PipeRegion> regions_;
  std::string csv_;
  std::vector<double> times_;  // s, of the images
  std::size_t images_ = 0;
  std::size_t failed_ = 0;
  std::size_t with_pipes_ = 0;
  std::size_t locked_ = 0;
  std::size_t coasting_ = 0;
  std::uint64_t tracks_ = 0;
};

}  // namespace pipescout::track
