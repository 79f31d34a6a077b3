// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pipescout::odometry {

/// Running median of a positive quantity by steps of a constant ratio: its memory is one number,
/// and one strong pulse moves it by one step only. While it is young its steps are longer.
class RunningMedian {
 public:
  /// `length`: values over which it forgets.
  RunningMedian(double length, double floor) noexcept;
  void start(double value, double age) noexcept;
  void update(double value, double weight) noexcept;
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] double age() const noexcept { return age_; }
  [[nodiscard]] bool started() const noexcept { return age_ > 0.0; }

 private:
  double length_;
  double floor_;
  double value_ = 0.0;
  double age_ = 0.0;  // values seen
};

/// Median energy of a filter's output in noise, as a function of how many samples a cell has:
/// linear between knots at whole powers of two. White noise falls with that number, 1/f noise does
/// not; what the share of each is, the knots learn.
class WeldBackground {
 public:
  WeldBackground(double length, double floor) noexcept;

  /// What is known before the first update: the median of the first `age` values.
  void begin(double log_samples, double energy, double age) noexcept;

  /// `log_samples`: log2 of samples per cell, clamped to the knots. Knots that are not known yet
  /// take over from the nearest known one what is hardly too low: twice as much for half of the
  /// samples (white noise), and twice as much for twice the samples (drift in time).
  void update(double log_samples, double energy) noexcept;

  /// Where it was updated before, anywhere between the same two knots; else 0.
  [[nodiscard]] double median(double log_samples) const noexcept;

  [[nodiscard]] bool knows(double log_samples) const noexcept;

  /// How many values that median stands for.
  [[nodiscard]] double age(double log_samples) const noexcept;

 private:
  static constexpr int kLowestPower = -4;
  static constexpr std::size_t kKnots = 14;

  struct Place {
    std::size_t knot;
    double share;  // of the next knot
  };
  [[nodiscard]] static Place place(double log_samples) noexcept;
  void start(std::size_t knot, double energy) noexcept;

  std::array<RunningMedian, kKnots> knots_;
};

/// The median of a variable of Gamma(shape, 1), shape = 1, 2, ...: of the energy of `shape` complex
/// outputs in noise, each of mean 1.
[[nodiscard]] double gamma_median(std::size_t shape);

}  // namespace pipescout::odometry
