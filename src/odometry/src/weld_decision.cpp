// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pipescout/statistics/median.hpp"
#include "weld_detector_state.hpp"

namespace pipescout::odometry {
namespace {

constexpr double kLn2 = std::numbers::ln2;
using Row = Eigen::Map<const Eigen::ArrayXd>;

}  // namespace

double WeldDetector::State::noise_ratio() const {
  return std::max(1.0, recent_.value() / median_strength_);
}

double WeldDetector::State::log_samples_around(std::int64_t centre) const {
  const auto around = static_cast<Eigen::Index>(2 * (widest_ / 2) + 1);
  return Row(grid_.window(samples_row_, centre - widest_ / 2), around).mean();
}

double WeldDetector::State::energy_at(const WeldFilter& filter, std::size_t channel,
                                      std::int64_t centre) const {
  const std::int64_t first = centre - filter.half;
  return apply(filter.taps, grid_.window(2 * channel, first), grid_.window(2 * channel + 1, first))
             .energy() /
         2.0;
}

double WeldDetector::State::noise_variance(std::size_t filter, std::size_t channel,
                                           const WeldBackground::Place& place) const {
  const std::size_t last = filters_.size() - 1;
  const double own = background_.median(place, filter * parameters_.channels + channel);
  if (filter == last) {
    return own / kLn2;
  }
  const double widest = background_.median(place, last * parameters_.channels + channel);
  return std::max(own, least_noise_[filter] * widest) / kLn2;
}

void WeldDetector::State::learn() {
  if (responded_.empty()) {
    return;
  }
  learnt_ = true;
  const auto median = [&](const auto& value_at) {
    warm_up_energies_.clear();
    for (std::int64_t centre = responded_.low; centre <= responded_.high; ++centre) {
      warm_up_energies_.push_back(value_at(centre));
    }
    return statistics::median_in_place(warm_up_energies_);
  };
  const auto place = WeldBackground::place(
      median([&](std::int64_t centre) { return log_samples_around(centre); }));
  const auto age = static_cast<double>(responded_.high - responded_.low + 1);
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    for (std::size_t c = 0; c < parameters_.channels; ++c) {
      energies_[f * parameters_.channels + c] =
          median([&](std::int64_t centre) { return energy_at(filters_[f], c, centre); });
    }
  }
  background_.begin(place, energies_, age);
  for (std::int64_t centre = responded_.low; centre <= responded_.high; ++centre) {
    respond(centre, false);
  }
}

double WeldDetector::State::uncertainty(std::size_t filter,
                                        const WeldBackground::Place& place) const {
  // Outputs closer than the pulse is wide go together, and a median is worth half as many values as
  // a mean. With a variance that is known from n values the exponential tail of the strength
  // becomes that of a ratio: (1 + T' / n)^-n = exp(-T).
  constexpr double kOutputs = 4.0;  // half widths
  const double n = std::max(1.0, background_.age(place) / (kOutputs * filters_[filter].half_width));
  return n / threshold_ * std::expm1(threshold_ / n);
}

void WeldDetector::State::respond(std::int64_t centre, bool learning) {
  const std::size_t channels = parameters_.channels;
  const auto place = place_of(centre);
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    for (std::size_t c = 0; c < channels; ++c) {
      energies_[f * channels + c] = energy_at(filters_[f], c, centre);
    }
  }
  if (learning || !background_.knows(place)) {
    background_.update(place, energies_);
  }
  double best = -1.0;
  double middle = 0.0;
  std::size_t which = 0;
  for (std::size_t f = filters_.size(); f-- > 0;) {  // of equals the widest
    double strength = 0.0;
    for (std::size_t c = 0; c < channels; ++c) {
      strength += energies_[f * channels + c] / noise_variance(f, c, place);
    }
    if (f == filters_.size() / 2) {
      middle = strength;
    }
    if (strength > best) {
      best = strength;
      which = f;
    }
  }
  recent_.update(middle);
  grid_.set(strength_row_, centre, best);
  grid_.set(filter_row_, centre, static_cast<double>(which));
  grid_.set(ratio_row_, centre, noise_ratio());
}

void WeldDetector::State::decide_up(std::int64_t margin) {
  if (responded_.empty()) {
    return;
  }
  std::int64_t next = responded_.low;
  if (!decided_.empty()) {
    next = std::max(next, decided_.high + 1);
  }
  for (; next <= responded_.high - margin; ++next) {
    decided_.add(next);
    decide(next);
  }
}

void WeldDetector::State::decide_down(std::int64_t margin) {
  if (responded_.empty()) {
    return;
  }
  std::int64_t next = responded_.high;
  if (!decided_.empty()) {
    next = std::min(next, decided_.low - 1);
  }
  for (; next >= responded_.low + margin; --next) {
    decided_.add(next);
    decide(next);
  }
}

double WeldDetector::State::largest_strength(std::int64_t from, std::int64_t to) const {
  const std::int64_t first = std::max(from, responded_.low);
  const std::int64_t last = std::min(to, responded_.high);
  if (first > last) {
    return 0.0;
  }
  return Row(grid_.window(strength_row_, first), static_cast<Eigen::Index>(last - first + 1))
      .maxCoeff();
}

/// As of `WeldShapeFitter::fit`, from the narrowest and the widest filter.
double WeldDetector::State::redness(const WeldBackground::Place& place) const {
  if (filters_.size() == 1) {
    return 0.0;
  }
  double sum = 0.0;
  for (std::size_t c = 0; c < parameters_.channels; ++c) {
    sum += std::log(noise_variance(filters_.size() - 1, c, place) / noise_variance(0, c, place));
  }
  const double range = std::log(filters_.back().half_width / filters_.front().half_width);
  return std::max(0.0, sum / (range * static_cast<double>(parameters_.channels)));
}

void WeldDetector::State::decide(std::int64_t centre) {
  double strength = grid_.get(strength_row_, centre);
  if (strength < threshold_) {
    return;
  }
  const double ratio = std::max(grid_.get(ratio_row_, centre), noise_ratio());
  const bool at_edge = centre == responded_.low || centre == responded_.high;
  if (strength < threshold_ * ratio || at_edge ||
      strength <= largest_strength(centre - own_, centre - 1) ||
      strength < largest_strength(centre + 1, centre + own_)) {
    return;
  }

  std::array<double, kMaxEddyCurrentChannels> variances{};
  const auto filter = static_cast<std::size_t>(grid_.get(filter_row_, centre));
  const auto place = place_of(centre);
  double strength_now = 0.0;  // the noise is known better by now
  for (std::size_t c = 0; c < parameters_.channels; ++c) {
    strength_now += energy_at(filters_[filter], c, centre) / noise_variance(filter, c, place);
    variances[c] = ratio * noise_variance(0, c, place);
  }
  strength = std::min(strength, strength_now);
  if (strength < threshold_ * ratio * uncertainty(filter, place)) {
    return;
  }
  const WeldShape shape =
      fitter_.fit(grid_, centre, std::span(variances).first(parameters_.channels), redness(place));
  if (!is_weld(shape)) {
    return;
  }
  const double others = std::max(largest_strength(centre - crowd_, centre - own_ - 1),
                                 largest_strength(centre + own_ + 1, centre + crowd_));
  if (others > parameters_.largest_neighbour * strength) {
    ++counts_.crowded;
    return;
  }
  const double distance = shape.centre * parameters_.cell;
  if (last_weld_ && std::abs(distance - *last_weld_) < parameters_.crowd_distance) {
    ++counts_.repeated;
    return;
  }

  const double s = strength / ratio;
  const double rivals = false_alarms_per_cell(filters_, parameters_.channels, s) *
                        parameters_.joint_length / parameters_.cell;
  const double surplus_match = std::min(
      1.0, (shape.match - parameters_.smallest_match) / (1.0 - parameters_.smallest_match));
  // Cramer-Rao for the position of a known pulse in white noise.
  const double noise = parameters_.cell / std::sqrt(2.0 * s * shape.rho);
  last_weld_ = distance;
  ++counts_.welds;
  events_.push_back({.distance = distance,
                     .standard_deviation = std::hypot(noise, parameters_.position_floor),
                     .confidence = (0.5 + 0.5 * surplus_match) / (1.0 + rivals),
                     .amplitude = shape.peak,
                     .width = 2.0 * shape.half_width * parameters_.cell,
                     .phase = shape.phase,
                     .strength = s,
                     .match = shape.match});
}

bool WeldDetector::State::is_weld(const WeldShape& shape) {
  const auto& p = parameters_;
  const double width = 2.0 * shape.half_width * p.cell;
  const double turned = std::remainder(shape.phase - p.phase, 2.0 * std::numbers::pi);
  std::uint64_t* reason = nullptr;
  if (!shape.fitted || shape.missing > 0.25) {
    reason = &counts_.incomplete;
  } else if (width < p.smallest_width / p.width_tolerance) {
    reason = &counts_.too_narrow;
  } else if (width > p.largest_width * p.width_tolerance) {
    reason = &counts_.too_wide;
  } else if (!(shape.match >= p.smallest_match) ||
             std::abs(shape.asymmetry) > p.largest_asymmetry + 2.0 * shape.asymmetry_deviation) {
    reason = &counts_.wrong_shape;
  } else if (std::abs(turned) > p.phase_tolerance) {
    reason = &counts_.wrong_phase;
  }
  if (reason != nullptr) {
    ++*reason;
  }
  return reason == nullptr;
}

}  // namespace pipescout::odometry
