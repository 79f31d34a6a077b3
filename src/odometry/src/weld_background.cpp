// SPDX-License-Identifier: Apache-2.0
#include "weld_background.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::odometry {
namespace {

/// d P(value > q) / d ln q at the median of an exponential variable: how strongly it is pulled
/// back.
constexpr double kPull = 0.3466;

template <std::size_t... indices>
std::array<RunningMedian, sizeof...(indices)> make_knots(double length, double floor,
                                                         std::index_sequence<indices...>) {
  return {((void)indices, RunningMedian(length, floor))...};
}

}  // namespace

RunningMedian::RunningMedian(double length, double floor) noexcept
    : length_(length), floor_(floor) {}

void RunningMedian::start(double value, double age) noexcept {
  value_ = std::max(value, floor_);
  age_ = age;
}

void RunningMedian::update(double value, double weight) noexcept {
  age_ = std::min(age_ + weight, length_);
  // 1 / (age * kPull) is the gain at which the estimate converges as fast as a median can.
  const double step = std::min(0.5, 0.5 * weight / (kPull * age_));
  value_ = std::max(floor_, value_ * (value > value_ ? 1.0 + step : 1.0 - step));
}

WeldBackground::WeldBackground(double length, double floor) noexcept
    : knots_(make_knots(length, floor, std::make_index_sequence<kKnots>())) {}

WeldBackground::Place WeldBackground::place(double log_samples) noexcept {
  const double at =
      std::clamp(log_samples - kLowestPower, 0.0, static_cast<double>(kKnots) - 1.001);
  const auto knot = static_cast<std::size_t>(at);
  return {knot, at - static_cast<double>(knot)};
}

void WeldBackground::start(std::size_t knot, double energy) noexcept {
  constexpr double kYoung = 500.0;  // values; younger, it would scatter too much to be trusted
  for (std::size_t away = 1; away < kKnots; ++away) {
    const double guess = std::ldexp(1.0, static_cast<int>(away));
    if (knot + away < kKnots && knots_[knot + away].started()) {
      knots_[knot].start(guess * knots_[knot + away].value(), kYoung);
      return;
    }
    if (knot >= away && knots_[knot - away].started()) {
      knots_[knot].start(guess * knots_[knot - away].value(), kYoung);
      return;
    }
  }
  knots_[knot].start(energy, 1.0);
}

double WeldBackground::median(double log_samples) const noexcept {
  const Place at = place(log_samples);
  return knots_[at.knot].value() +
         at.share * (knots_[at.knot + 1].value() - knots_[at.knot].value());
}

bool WeldBackground::knows(double log_samples) const noexcept {
  const Place at = place(log_samples);
  return knots_[at.knot].started() && knots_[at.knot + 1].started();
}

double WeldBackground::age(double log_samples) const noexcept {
  const Place at = place(log_samples);
  return std::lerp(knots_[at.knot].age(), knots_[at.knot + 1].age(), at.share);
}

void WeldBackground::begin(double log_samples, double energy, double age) noexcept {
  const Place at = place(log_samples);
  knots_[at.knot].start(energy, age);
  knots_[at.knot + 1].start(energy, age);
}

void WeldBackground::update(double log_samples, double energy) noexcept {
  const Place at = place(log_samples);
  for (std::size_t knot = at.knot; knot < at.knot + 2; ++knot) {
    if (!knots_[knot].started()) {
      start(knot, energy);
    }
  }
  // Which side of the interpolated median it is on is what both knots are told.
  const double ratio = energy / median(log_samples);
  for (std::size_t i = 0; i < 2; ++i) {
    auto& knot = knots_[at.knot + i];
    knot.update(ratio * knot.value(), i == 0 ? 1.0 - at.share : at.share);
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
