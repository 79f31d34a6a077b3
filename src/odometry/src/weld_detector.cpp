// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_detector.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "weld_detector_state.hpp"

namespace pipescout::odometry {
namespace {

/// A doublet's output is below a fifth of its peak from here on, in half widths.
constexpr double kOwnHalfWidths = 3.5;
/// Over which the noise may rise unpunished, m.
constexpr double kFastLength = 3.0;

std::int64_t to_cells(double metres, double cell) {
  return static_cast<std::int64_t>(std::ceil(metres / cell));
}

/// The noise of a filter goes with its width to at most this power: 1/f noise has 1. Redder noise
/// is drift of a smooth signal; a narrow filter that is let loose on it takes the flanks of pulses
/// for pulses.
constexpr double kReddest = 1.5;
constexpr std::int64_t kFewestOutputs = 64;  // that the noise can be learnt from
constexpr double kMostCells = 1e9;           // from the origin
constexpr double kLargestValue = 1e100;

bool usable(std::span<const Impedance> channels) {
  return std::all_of(channels.begin(), channels.end(), [](const Impedance& value) {
    // False for NaN too.
    return std::abs(value.x) <= kLargestValue && std::abs(value.y) <= kLargestValue;
  });
}

}  // namespace

WeldDetector::State::State(const WeldDetectorParameters& parameters)
    : parameters_((parameters.validate(), parameters)),
      filters_(weld_filters(parameters)),
      threshold_(weld_threshold(parameters)),
      median_strength_(gamma_median(parameters.channels)),
      widest_(filters_.back().half),
      own_(static_cast<std::int64_t>(std::ceil(kOwnHalfWidths * filters_.back().half_width))),
      crowd_(to_cells(parameters.crowd_distance, parameters.cell)),
      margin_(0),
      bridged_(static_cast<std::int64_t>(filters_.front().half_width)),
      largest_step_(to_cells(parameters.largest_step, parameters.cell)),
      largest_jump_(to_cells(parameters.largest_jump, parameters.cell)),
      warm_up_(to_cells(parameters.warm_up, parameters.cell)),
      offset_row_(2 * parameters.channels),
      missing_row_(offset_row_ + 1),
      samples_row_(offset_row_ + 2),
      strength_row_(offset_row_ + 3),
      filter_row_(offset_row_ + 4),
      ratio_row_(offset_row_ + 5),
      gate_(parameters.channels, parameters.noise_floor),
      resampler_(parameters),
      levels_(parameters.channels),
      fitter_(filters_.front().half_width, filters_.back().half_width,
              {.channels = parameters.channels, .offset = offset_row_, .missing = missing_row_}),
      grid_(ratio_row_ + 1, std::bit_ceil(static_cast<std::size_t>(
                                warm_up_ + 4 * (widest_ + crowd_ + own_ + fitter_.reach() + 2)))),
      background_(filters_.size() * parameters.channels,
                  parameters.background_length / parameters.cell,
                  std::numbers::ln2 * parameters.noise_floor * parameters.noise_floor),
      energies_(filters_.size() * parameters.channels),
      recent_(kFastLength / parameters.cell, 1e-300) {
  margin_ = std::max({own_, crowd_, fitter_.reach() + 1 - widest_});
  recent_.start(median_strength_, kFastLength / parameters.cell);
  warm_up_energies_.reserve(static_cast<std::size_t>(grid_.capacity()));
  for (const auto& filter : filters_) {
    least_noise_.push_back(std::pow(filter.half_width / filters_.back().half_width, kReddest));
  }
  events_.reserve(static_cast<std::size_t>(grid_.capacity() / own_) + 2);
}

std::span<const WeldEvent> WeldDetector::State::update(double distance,
                                                       std::span<const Impedance> channels) {
  if (channels.size() != parameters_.channels) {
    throw std::invalid_argument("channels: " + std::to_string(channels.size()) + " values for " +
                                std::to_string(parameters_.channels) +
                                " channels, must be as many");
  }
  events_.clear();
  if (accept(distance, channels)) {
    bool spike = false;
    const SpikeGate::Sample* const sample = gate_.push(distance, channels, spike);
    counts_.spikes += spike ? 1 : 0;
    if (sample != nullptr) {
      resample(*sample);
    }
  }
  return events_;
}

bool WeldDetector::State::accept(double distance, std::span<const Impedance> channels) {
  ++counts_.samples;
  if (!(std::abs(distance) <= kMostCells * parameters_.cell)) {
    ++counts_.bad_distances;
    return false;
  }
  if (!usable(channels)) {
    ++counts_.bad_values;
    return false;
  }
  if (parameters_.frozen_after > 0) {
    repeats_ = gate_.repeats(channels) ? repeats_ + 1 : 0;
    if (repeats_ >= parameters_.frozen_after) {
      // Those that it repeats too: one zero is worse than none.
      counts_.frozen += 1 + gate_.freeze(parameters_.frozen_after);
      return false;
    }
  }
  return true;
}

void WeldDetector::State::resample(const SpikeGate::Sample& sample) {
  const auto channels = std::span(sample.values).first(parameters_.channels);
  if (resampler_.add(sample.distance, channels, counts_) != WeldResampler::Outcome::kNothing) {
    take(resampler_.closed());
  }
}

std::span<const WeldEvent> WeldDetector::State::finish() {
  events_.clear();
  while (const SpikeGate::Sample* const sample = gate_.drain()) {
    resample(*sample);
  }
  if (resampler_.close()) {
    take(resampler_.closed());
  }
  if (!learnt_) {
    learn();
  }
  if (direction_ >= 0) {
    decide_up(1);
  } else {
    decide_down(1);
  }
  return events_;
}

bool WeldDetector::State::has_turned(std::int64_t cell) {
  if (direction_ == 0 || (cell - farthest_) * direction_ >= 0) {
    farthest_ = cell;
    return false;
  }
  if (std::abs(cell - farthest_) < to_cells(parameters_.turn_distance, parameters_.cell)) {
    return false;
  }
  farthest_ = cell;
  return true;
}

void WeldDetector::State::forget_pass() {
  grid_.clear();
  levels_.forget();
  responded_ = {};
  decided_ = {};
  direction_ = 0;
  last_weld_.reset();
}

void WeldDetector::State::take(const WeldCell& closed) {
  WeldCell cell = closed;
  levels_.correct(cell);
  if (has_turned(cell.index) && parameters_.report_again) {
    forget_pass();
  }
  if (grid_.empty()) {
    put(cell, false, direction_ < 0 ? -1 : 1);
    return;
  }
  if (grid_.holds(cell.index, cell.index)) {
    counts_.revisiting += static_cast<std::uint64_t>(cell.samples);
    for (std::size_t c = 0; c < parameters_.channels; ++c) {
      levels_.compare(c, cell.means[c],
                      {grid_.get(2 * c, cell.index), grid_.get(2 * c + 1, cell.index)});
    }
    levels_.next_cell();
    return;
  }
  const int direction = cell.index > grid_.high() ? 1 : -1;
  const std::int64_t from = direction > 0 ? grid_.high() : grid_.low();
  const std::int64_t gap = std::abs(cell.index - from) - 1;
  direction_ = direction;
  if (gap > largest_step_) {
    ++counts_.gaps;
    if (gap > largest_jump_) {
      forget_pass();
      farthest_ = cell.index;
    }
    grid_.clear();
    responded_ = {};
    levels_.forget();
  } else {
    levels_.settle(cell);
    bridge(from, cell, gap, direction);
  }
  put(cell, false, direction);
}

void WeldDetector::State::bridge(std::int64_t from, const WeldCell& to, std::int64_t gap,
                                 int direction) {
  const bool missing = gap > bridged_;
  counts_.gaps += missing ? 1 : 0;
  for (std::int64_t i = 1; i <= gap; ++i) {
    const double share = 1.0 / static_cast<double>(gap + 2 - i);  // of the way that is left
    const std::int64_t last = from + direction * (i - 1);
    WeldCell cell{.index = last + direction,
                  .samples = 1.0 / static_cast<double>(gap + 1),
                  .offset = std::lerp(grid_.get(offset_row_, last), to.offset, share)};
    for (std::size_t c = 0; c < parameters_.channels; ++c) {
      cell.means[c] = {std::lerp(grid_.get(2 * c, last), to.means[c].x, share),
                       std::lerp(grid_.get(2 * c + 1, last), to.means[c].y, share)};
    }
    put(cell, missing, direction);
  }
}

void WeldDetector::State::put(const WeldCell& cell, bool missing, int direction) {
  ++counts_.cells;
  grid_.extend(cell.index);
  for (std::size_t c = 0; c < parameters_.channels; ++c) {
    grid_.set(2 * c, cell.index, cell.means[c].x);
    grid_.set(2 * c + 1, cell.index, cell.means[c].y);
  }
  grid_.set(offset_row_, cell.index, cell.offset);
  grid_.set(missing_row_, cell.index, missing ? 1.0 : 0.0);
  grid_.set(samples_row_, cell.index, std::log2(cell.samples));
  responded_.low = std::max(responded_.low, grid_.low() + widest_);
  responded_.high = std::min(responded_.high, grid_.high() - widest_);
  const std::int64_t centre = cell.index - direction * widest_;
  if (!grid_.holds(centre - widest_, centre + widest_)) {
    return;
  }
  responded_.add(centre);
  if (learnt_) {
    respond(centre, true);
  } else if (counts_.cells >= static_cast<std::uint64_t>(warm_up_) &&
             responded_.high - responded_.low >= kFewestOutputs) {
    learn();
  } else {
    return;
  }
  if (direction > 0) {
    decide_up(margin_);
  } else {
    decide_down(margin_);
  }
}

WeldDetector::WeldDetector(const WeldDetectorParameters& parameters)
    : state_(std::make_unique<State>(parameters)) {}
WeldDetector::~WeldDetector() = default;
WeldDetector::WeldDetector(WeldDetector&&) noexcept = default;
WeldDetector& WeldDetector::operator=(WeldDetector&&) noexcept = default;

std::span<const WeldEvent> WeldDetector::update(double distance,
                                                std::span<const Impedance> channels) {
  return state_->update(distance, channels);
}

std::span<const WeldEvent> WeldDetector::finish() {
  return state_->finish();
}

double WeldDetector::delay() const noexcept {
  return state_->delay();
}

const WeldDetectorCounts& WeldDetector::counts() const noexcept {
  return state_->counts();
}

const WeldDetectorParameters& WeldDetector::parameters() const noexcept {
  return state_->parameters();
}

}  // namespace pipescout::odometry
