// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace pipescout::navigation {

/// A stretch of a pipe in one image.
struct PipeView {
  std::int64_t pipe = 0;   ///< which
  double from = 0;         ///< m along the pipe
  double to = 0;           ///< m, not less than `from`
  double time = 0;         ///< s
  double temperature = 0;  ///< degrees Celsius; NaN: not known
  double blur = 0;         ///< px
};

/// Which metre of which pipe was seen sharp, and at which temperature. It grows with what is seen.
class CoverageMap {
 public:
  struct Cell {
    bool sharp = false;
    double blur = 0;         ///< px, the least so far
    double temperature = 0;  ///< degrees Celsius, of the sharpest image
    double time = 0;         ///< s, of that image
  };
  struct Gap {
    double from = 0;  ///< m
    double to = 0;
  };

  /// `cell` in m, [0.01, 10]; `largest_blur` in px, (0, 100]. Throws std::invalid_argument.
  CoverageMap(double cell, double largest_blur);

  /// A cell counts when the image holds all of it. False for views that are not finite, that
  /// begin before the pipe, whose ends are swapped, or beyond 1000 km. May allocate.
  bool add(const PipeView& view);
  /// Of the metres from `from` to `to` of a pipe, in percent; 0 for an unknown pipe or no length.
  [[nodiscard]] double sharp_percent(std::int64_t pipe, double from, double to) const;
  /// Stretches in it that were not seen sharp.
  [[nodiscard]] std::vector<Gap> gaps(std::int64_t pipe, double from, double to) const;
  /// From the beginning of each pipe on.
  [[nodiscard]] const std::map<std::int64_t, std::vector<Cell>>& pipes() const { return pipes_; }
  [[nodiscard]] double cell() const { return cell_; }

 private:
  double cell_;
  double largest_blur_;
  std::map<std::int64_t, std::vector<Cell>> pipes_;
};

}  // namespace pipescout::navigation
