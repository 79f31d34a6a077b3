// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace pipescout::odometry {

/// By how much a running median of an exponential variable moves for one value that is below or
/// above it: index false or true. A table, as which of them comes next cannot be foreseen.
class MedianStep {
 public:
  /// `age`: values seen, above 0.
  MedianStep(double age, double weight) noexcept {
    // d P(value > q) / d ln q at the median: how strongly it is pulled back. 1 / (age * kPull) is
    // the gain at which the estimate converges as fast as a median can.
    constexpr double kPull = 0.3466;
    const double step = std::min(0.5, 0.5 * weight / (kPull * age));
    factors_ = {1.0 - step, 1.0 + step};
  }
  [[nodiscard]] double operator[](bool above) const noexcept {
    return factors_[static_cast<std::size_t>(above)];
  }

 private:
  std::array<double, 2> factors_{};
};

/// Running median of a positive quantity by steps of a constant ratio: its memory is one number,
/// and one strong pulse moves it by one step only. While it is young its steps are longer.
class RunningMedian {
 public:
  /// `length`: values over which it forgets.
  RunningMedian(double length, double floor) noexcept : length_(length), floor_(floor) {}

  void start(double value, double age) noexcept {
    value_ = std::max(value, floor_);
    age_ = std::min(age, length_);
    step_ = MedianStep(age_, 1.0);
  }
  void update(double value) noexcept {
    if (age_ < length_) {
      age_ = std::min(age_ + 1.0, length_);
      step_ = MedianStep(age_, 1.0);
    }
    value_ = std::max(floor_, value_ * step_[value > value_]);
  }
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] bool started() const noexcept { return age_ > 0.0; }

 private:
  double length_;
  double floor_;
  double value_ = 0.0;
  double age_ = 0.0;  // values seen
  MedianStep step_{1.0, 0.0};
};

/// Median energies of the outputs of filters in noise, as functions of how many samples a cell has:
/// linear between knots at whole powers of two. White noise falls with that number, 1/f noise does
/// not; what the share of each is, the knots learn. All outputs are learnt at the same places, so
/// they share the weights of the knots.
class WeldBackground {
 public:
  /// Between two knots.
  struct Place {
    std::size_t knot;
    double share;  ///< of the next knot
  };

  WeldBackground(std::size_t outputs, double length, double floor);

  /// `log_samples`: log2 of samples per cell, clamped to the knots.
  [[nodiscard]] static Place place(double log_samples) noexcept {
    const double at =
        std::clamp(log_samples - kLowestPower, 0.0, static_cast<double>(kKnots) - 1.001);
    const auto knot = static_cast<std::size_t>(at);
    return {knot, at - static_cast<double>(knot)};
  }

  /// What is known before the first update: the medians of the first `age` > 0 values.
  void begin(const Place& at, std::span<const double> medians, double age) noexcept;

  /// The energies of all outputs. Knots that are not known yet take over from the nearest known one
  /// what is hardly too low: twice as much for half of the samples (white noise), and twice as much
  /// for twice the samples (drift in time).
  void update(const Place& at, std::span<const double> energies) noexcept;

  /// Where it was updated before, anywhere between the same two knots; else 0.
  [[nodiscard]] double median(const Place& at, std::size_t output) const noexcept {
    const double* const low = values_.data() + at.knot * outputs_ + output;
    return low[0] + at.share * (low[outputs_] - low[0]);
  }

  [[nodiscard]] bool knows(const Place& at) const noexcept {
    return ages_[at.knot] > 0.0 && ages_[at.knot + 1] > 0.0;
  }

  /// How many values a median stands for.
  [[nodiscard]] double age(const Place& at) const noexcept;

 private:
  static constexpr int kLowestPower = -4;
  static constexpr std::size_t kKnots = 14;

  void start(std::size_t knot, std::span<const double> energies) noexcept;
  void set(std::size_t knot, std::span<const double> medians, double factor, double age) noexcept;
  [[nodiscard]] std::span<double> values(std::size_t knot) noexcept {
    return std::span(values_).subspan(knot * outputs_, outputs_);
  }
  [[nodiscard]] MedianStep grow(std::size_t knot, double weight) noexcept;

  std::size_t outputs_;
  double length_;
  double floor_;
  std::array<double, kKnots> ages_{};  // values seen
  std::vector<double> values_;         // knot * outputs + output
};

/// The median of a variable of Gamma(shape, 1), shape = 1, 2, ...: of the energy of `shape` complex
/// outputs in noise, each of mean 1.
[[nodiscard]] double gamma_median(std::size_t shape);

}  // namespace pipescout::odometry
