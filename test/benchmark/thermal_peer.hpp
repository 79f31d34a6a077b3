// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/pipe_profile.hpp"

namespace pipescout::benchmarks {

/// Section 5 of Ibarguren and others (2013) with what OpenCV offers: temperatures to grey levels,
/// threshold, `cv::ximgproc::thinning`, the longest straight section by `cv::HoughLinesP`, the
/// temperatures along it averaged across; then our own split, filter and label.
class ThinningPeer {
 public:
  ThinningPeer();
  ~ThinningPeer();
  /// How many leaks it finds on the longest section.
  std::size_t detect(const thermal::CountView& image, std::span<const float> celsius);
  /// Pixels, of that section; 0: there was none.
  [[nodiscard]] double length() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::benchmarks
