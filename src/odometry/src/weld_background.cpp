// SPDX-License-Identifier: Apache-2.0
#include "weld_background.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry {

WeldBackground::WeldBackground(std::size_t outputs, double length, double floor)
    : outputs_(outputs), length_(length), floor_(floor), values_(kKnots * outputs, 0.0) {}

void WeldBackground::set(std::size_t knot, std::span<const double> medians, double factor,
                         double age) noexcept {
  const auto values_there = values(knot);
  for (std::size_t i = 0; i < outputs_; ++i) {
    values_there[i] = std::max(factor * medians[i], floor_);
  }
  ages_[knot] = age;
}

void WeldBackground::start(std::size_t knot, std::span<const double> energies) noexcept {
  constexpr double kYoung = 500.0;  // values; younger, it would scatter too much to be trusted
  for (std::size_t away = 1; away < kKnots; ++away) {
    const double guess = std::ldexp(1.0, static_cast<int>(away));
    if (knot + away < kKnots && ages_[knot + away] > 0.0) {
      set(knot, values(knot + away), guess, kYoung);
      return;
    }
    if (knot >= away && ages_[knot - away] > 0.0) {
      set(knot, values(knot - away), guess, kYoung);
      return;
    }
  }
  set(knot, energies, 1.0, 1.0);
}

double WeldBackground::age(const Place& at) const noexcept {
  return std::lerp(ages_[at.knot], ages_[at.knot + 1], at.share);
}

void WeldBackground::begin(const Place& at, std::span<const double> medians, double age) noexcept {
  set(at.knot, medians, 1.0, age);
  set(at.knot + 1, medians, 1.0, age);
}

MedianStep WeldBackground::grow(std::size_t knot, double weight) noexcept {
  ages_[knot] = std::min(ages_[knot] + weight, length_);
  return {ages_[knot], weight};
}

void WeldBackground::update(const Place& at, std::span<const double> energies) noexcept {
  for (std::size_t knot = at.knot; knot < at.knot + 2; ++knot) {
    if (!(ages_[knot] > 0.0)) {
      start(knot, energies);
    }
  }
  const MedianStep low_step = grow(at.knot, 1.0 - at.share);
  const MedianStep high_step = grow(at.knot + 1, at.share);
  const auto low = values(at.knot);
  const auto high = values(at.knot + 1);
  for (std::size_t i = 0; i < outputs_; ++i) {
    // Which side of the interpolated median it is on is what both knots are told.
    const bool above = energies[i] > median(at, i);
    low[i] = std::max(floor_, low[i] * low_step[above]);
    high[i] = std::max(floor_, high[i] * high_step[above]);
  }
}

double gamma_median(std::size_t shape) {
  // P(value > x) = exp(-x) sum of x^k / k!, k < shape: bisection.
  double low = 0.0;
  double high = static_cast<double>(shape);
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2.0;
    double term = std::exp(-middle);
    double above = 0.0;
    for (std::size_t k = 0; k < shape; ++k) {
      above += term;
      term *= middle / static_cast<double>(k + 1);
    }
    (above > 0.5 ? low : high) = middle;
  }
  return (low + high) / 2.0;
}

}  // namespace pipescout::odometry
