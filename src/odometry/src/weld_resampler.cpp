// SPDX-License-Identifier: Apache-2.0
#include "weld_resampler.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace pipescout::odometry {
namespace {

constexpr double kMostSamples = 64.0;  // of a cell; later ones of a stand have drifted
constexpr int kWitnesses = 3;
constexpr double kStandingCells = 0.1;     // a crawler that stands moves less
constexpr std::size_t kLevelSamples = 32;  // that make a level

void approach(Impedance& mean, const Impedance& value, double gain) {
  mean.x += gain * (value.x - mean.x);
  mean.y += gain * (value.y - mean.y);
}

}  // namespace

WeldResampler::WeldResampler(const WeldDetectorParameters& parameters)
    : channels_(parameters.channels),
      cells_per_metre_(1.0 / parameters.cell),
      largest_step_(
          static_cast<std::int64_t>(std::ceil(parameters.largest_step / parameters.cell))),
      standing_after_(parameters.standing_after) {}

void WeldResampler::open(std::int64_t cell) noexcept {
  open_.index = cell;
  open_.samples = 0.0;
  open_.offset = 0.0;
  for (std::size_t i = 0; i < channels_; ++i) {
    open_.means[i] = {};
  }
  is_open_ = true;
}

void WeldResampler::compensate(double place, std::span<const Impedance> channels) noexcept {
  if (stand_samples_ == 0 || std::abs(place - stand_) > kStandingCells) {
    if (stand_samples_ >= standing_after_) {
      for (std::size_t i = 0; i < channels_; ++i) {
        drift_[i].x += latest_[i].x - first_[i].x;
        drift_[i].y += latest_[i].y - first_[i].y;
      }
    }
    stand_ = place;
    stand_samples_ = 0;
  }
  ++stand_samples_;
  const std::size_t age = std::min(stand_samples_, kLevelSamples);
  for (std::size_t i = 0; i < channels_; ++i) {
    approach(latest_[i], channels[i], 1.0 / static_cast<double>(age));
    if (stand_samples_ <= kLevelSamples) {
      first_[i] = latest_[i];
    }
    level_free_[i] = {channels[i].x - drift_[i].x, channels[i].y - drift_[i].y};
  }
}

void WeldResampler::accumulate(double place) noexcept {
  open_.samples += 1.0;
  open_.offset += place - static_cast<double>(open_.index);
  for (std::size_t i = 0; i < channels_; ++i) {
    open_.means[i].x += level_free_[i].x;
    open_.means[i].y += level_free_[i].y;
  }
}

bool WeldResampler::close() noexcept {
  if (!is_open_) {
    return false;
  }
  is_open_ = false;
  closed_.index = open_.index;
  closed_.samples = open_.samples;
  closed_.offset = open_.offset / open_.samples;
  for (std::size_t i = 0; i < channels_; ++i) {
    closed_.means[i] = {open_.means[i].x / open_.samples, open_.means[i].y / open_.samples};
  }
  return true;
}

bool WeldResampler::confirmed(std::int64_t cell, WeldDetectorCounts& counts) noexcept {
  const bool again = witnesses_ > 0 && std::abs(cell - suspect_) <= largest_step_;
  witnesses_ = again ? witnesses_ + 1 : 1;
  suspect_ = cell;
  if (witnesses_ < kWitnesses) {
    ++counts.outliers;
    return false;
  }
  counts.outliers -= kWitnesses - 1;  // they told the truth
  ++counts.jumps;
  return true;
}

WeldResampler::Outcome WeldResampler::add(double distance, std::span<const Impedance> channels,
                                          WeldDetectorCounts& counts) {
  const double place = distance * cells_per_metre_;
  const auto cell = static_cast<std::int64_t>(std::floor(place + 0.5));  // its middle is its index
  Outcome outcome = Outcome::kNothing;
  if (!is_open_) {
    open(cell);
  } else if (cell != open_.index) {
    outcome = Outcome::kCell;
    if (std::abs(cell - open_.index) > largest_step_) {
      if (!confirmed(cell, counts)) {
        return Outcome::kNothing;
      }
      outcome = Outcome::kNewOrigin;
    }
    close();
    open(cell);
  }
  witnesses_ = 0;
  compensate(place, channels);
  if (open_.samples < kMostSamples) {
    accumulate(place);
  } else {
    ++counts.surplus;
  }
  return outcome;
}

}  // namespace pipescout::odometry
