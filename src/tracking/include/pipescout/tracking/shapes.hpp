// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "pipescout/tracking/shape_model.hpp"

/// The shapes of pipes, valves and vessels. x to the right, y down, from the middle of the upper
/// left pixel; angles from x towards y.
namespace pipescout::tracking {

/// A straight section of a pipe: x, y of its middle, length, direction of its axis. Equation (14):
/// lambda |position| + beta dl^2 + gamma dalpha^2.
struct PipeShape {
  static constexpr std::size_t kSize = 4;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0, std::numbers::pi};
  enum : std::size_t { kX, kY, kLength, kAngle };

  double lambda = 0.5;  ///< 1/px, > 0
  double beta = 0.02;   ///< 1/px^2, > 0
  double gamma = 600;   ///< 1/rad^2, > 0

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * d[kLength] * d[kLength] +
           static_cast<T>(gamma) * d[kAngle] * d[kAngle];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A valve seen as a circle: x, y of its middle, radius.
struct ValveShape {
  static constexpr std::size_t kSize = 3;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0};
  enum : std::size_t { kX, kY, kRadius };

  double lambda = 0.5;  ///< 1/px, > 0
  double beta = 0.2;    ///< 1/px^2, > 0

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * d[kRadius] * d[kRadius];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A vessel seen as a rectangle: x, y of its middle, length along its axis, width, direction of the
/// axis.
struct VesselShape {
  static constexpr std::size_t kSize = 5;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0, 0, std::numbers::pi};
  enum : std::size_t { kX, kY, kLength, kWidth, kAngle };

  double lambda = 0.5;  ///< 1/px, > 0
  double beta = 0.02;   ///< 1/px^2, > 0: of length and width
  double gamma = 600;   ///< 1/rad^2, > 0

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * (d[kLength] * d[kLength] + d[kWidth] * d[kWidth]) +
           static_cast<T>(gamma) * d[kAngle] * d[kAngle];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

}  // namespace pipescout::tracking
