// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/arm_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

void check_finite(const char* field, std::span<const double> values, std::size_t joints) {
  if (values.size() != joints ||
      !std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) {
    throw std::invalid_argument(std::string(field) + ": is not " + std::to_string(joints) +
                                " finite numbers");
  }
}

}  // namespace

void ArmDynamicsParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  if (lower.empty()) {
    throw std::invalid_argument("lower: there are no joints");
  }
  check_finite("lower", lower, lower.size());
  check_finite("upper", upper, lower.size());
  check_finite("largest_rate", largest_rate, lower.size());
  for (std::size_t i = 0; i < lower.size(); ++i) {
    check_above("upper", upper[i], lower[i], 1e3);
    check_above("largest_rate", largest_rate[i], 0, 100);
  }
  check_above("largest_acceleration", largest_acceleration, 0, 1000);
  check_within("delay", delay, 0, 0.5);
  check_within("frequency", frequency, 1, 500);
  check_within("damping", damping, 0.1, 2);
  check_within("resolution", resolution, 0, 0.1);
}

ArmDynamics::ArmDynamics(const ArmDynamicsParameters& parameters, std::span<const double> positions)
    : parameters_(parameters),
      positions_(positions.begin(), positions.end()),
      rates_(positions.size(), 0.0) {
  parameters_.validate();
  check_finite("positions", positions, parameters_.lower.size());
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    validation::check_within("positions", positions_[i], parameters_.lower[i],
                             parameters_.upper[i]);
  }
  points_.push_back({.begin = 0, .end = 0, .positions = positions_, .rates = rates_});
}

double ArmDynamics::time() const noexcept {
  return static_cast<double>(steps_) * kStep;
}

void ArmDynamics::command(std::span<const double> positions, std::span<const double> rates,
                          double time_from_start) {
  check_finite("positions", positions, positions_.size());
  check_finite("rates", rates, positions_.size());
  validation::check_within("time_from_start", time_from_start, 0, 1e6);
  const double begin = time() + parameters_.delay;
  points_.push_back({.begin = begin,
                     .end = begin + time_from_start,
                     .positions = {positions.begin(), positions.end()},
                     .rates = {rates.begin(), rates.end()}});
}

void ArmDynamics::step() {
  const double now = time();
  while (points_.size() > 1 && points_[1].begin <= now + kStep / 2) {
    points_.pop_front();
  }
  const Point& point = points_.front();
  const double left = std::max(0.0, point.end - now);
  const double frequency = parameters_.frequency;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const double wanted_rate = left > 0 ? point.rates[i] : 0;
    const double wanted = point.positions[i] - left * wanted_rate;
    const double acceleration =
        std::clamp(frequency * frequency * (wanted - positions_[i]) +
                       2 * parameters_.damping * frequency * (wanted_rate - rates_[i]),
                   -parameters_.largest_acceleration, parameters_.largest_acceleration);
    rates_[i] = std::clamp(rates_[i] + kStep * acceleration, -parameters_.largest_rate[i],
                           parameters_.largest_rate[i]);
    const double moved = positions_[i] + kStep * rates_[i];
    positions_[i] = std::clamp(moved, parameters_.lower[i], parameters_.upper[i]);
    if (positions_[i] != moved) {
      rates_[i] = 0;
    }
  }
  ++steps_;
}

void ArmDynamics::encoders(std::span<double> shown) const {
  const double resolution = parameters_.resolution;
  std::ranges::transform(positions_, shown.begin(), [resolution](double position) {
    return resolution > 0 ? resolution * std::round(position / resolution) : position;
  });
}

}  // namespace pipescout::simulation
