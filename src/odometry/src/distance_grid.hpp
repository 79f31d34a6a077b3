// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pipescout::odometry {

/// Cells of equal distance in a ring: the last `capacity` cells at the end where the crawler is.
/// Each value is stored twice, `capacity` apart, so that any window of cells is contiguous.
class DistanceGrid {
 public:
  /// `rows`: values per cell. `capacity`: a power of two.
  DistanceGrid(std::size_t rows, std::size_t capacity);

  void clear() noexcept { empty_ = true; }
  [[nodiscard]] bool empty() const noexcept { return empty_; }
  [[nodiscard]] std::int64_t low() const noexcept { return low_; }
  [[nodiscard]] std::int64_t high() const noexcept { return high_; }
  [[nodiscard]] bool holds(std::int64_t first, std::int64_t last) const noexcept {
    return !empty_ && first >= low_ && last <= high_;
  }
  [[nodiscard]] std::int64_t capacity() const noexcept { return mask_ + 1; }

  /// Makes room for cell `cell`, which is low() - 1 or high() + 1, or any one when empty; drops the
  /// cell at the other end when full.
  void extend(std::int64_t cell) noexcept;

  /// `row` < rows, of a cell that is held.
  void set(std::size_t row, std::int64_t cell, double value) noexcept {
    double* const place = values_.data() + row * stride_ + slot(cell);
    place[0] = value;
    place[mask_ + 1] = value;
  }
  [[nodiscard]] double get(std::size_t row, std::int64_t cell) const noexcept {
    return *window(row, cell);
  }
  /// Up to `capacity` values of cells `first`, `first` + 1, ...
  [[nodiscard]] const double* window(std::size_t row, std::int64_t first) const noexcept {
    return values_.data() + row * stride_ + slot(first);
  }

 private:
  [[nodiscard]] std::size_t slot(std::int64_t cell) const noexcept {
    return static_cast<std::size_t>(cell & mask_);
  }

  std::int64_t mask_;
  std::size_t stride_;
  std::vector<double> values_;
  std::int64_t low_ = 0;
  std::int64_t high_ = 0;
  bool empty_ = true;
};

}  // namespace pipescout::odometry
