// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "distance_grid.hpp"
#include "level_matcher.hpp"
#include "pipescout/odometry/weld_detector.hpp"
#include "spike_gate.hpp"
#include "weld_background.hpp"
#include "weld_filters.hpp"
#include "weld_resampler.hpp"
#include "weld_shape.hpp"

namespace pipescout::odometry {

/// Those that run along the pipe. Throws what `WeldDetectorParameters::validate` throws.
[[nodiscard]] std::vector<WeldFilter> weld_filters(const WeldDetectorParameters& parameters);

/// A range of cells; empty at first.
struct CellRange {
  std::int64_t low = 0;
  std::int64_t high = -1;
  [[nodiscard]] bool empty() const { return high < low; }
  void add(std::int64_t cell) {
    if (empty()) {
      low = high = cell;
    } else {
      low = std::min(low, cell);
      high = std::max(high, cell);
    }
  }
};

/// Samples pass the gate into cells (weld_detector.cpp); each new cell lets the filters respond one
/// half of the widest filter behind it, and peaks are decided `margin_` behind that
/// (weld_decision.cpp).
class WeldDetector::State {
 public:
  explicit State(const WeldDetectorParameters& parameters);

  std::span<const WeldEvent> update(double distance, std::span<const Impedance> channels);
  std::span<const WeldEvent> finish();

  [[nodiscard]] double delay() const {
    return static_cast<double>(widest_ + margin_ + 1) * parameters_.cell;
  }
  [[nodiscard]] const WeldDetectorCounts& counts() const { return counts_; }
  [[nodiscard]] const WeldDetectorParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] bool accept(double distance, std::span<const Impedance> channels);
  void resample(const SpikeGate::Sample& sample);
  void take(const WeldCell& closed);
  [[nodiscard]] bool has_turned(std::int64_t cell);
  void forget_pass();
  void bridge(std::int64_t from, const WeldCell& to, std::int64_t gap, int direction);
  void put(const WeldCell& cell, bool missing, int direction);
  [[nodiscard]] double log_samples_around(std::int64_t centre) const;
  [[nodiscard]] WeldBackground::Place place_of(std::int64_t centre) const {
    return WeldBackground::place(log_samples_around(centre));
  }
  [[nodiscard]] double energy_at(const WeldFilter& filter, std::size_t channel,
                                 std::int64_t centre) const;
  /// Of the output of a filter, its real part.
  [[nodiscard]] double noise_variance(std::size_t filter, std::size_t channel,
                                      const WeldBackground::Place& place) const;
  /// The end of the warm-up: learns the noise from all of it at once, then responds to it.
  void learn();
  void respond(std::int64_t centre, bool learning);
  /// How much the threshold rises because the noise of a filter is known from few outputs only.
  [[nodiscard]] double uncertainty(std::size_t filter, const WeldBackground::Place& place) const;
  void decide_up(std::int64_t margin);
  void decide_down(std::int64_t margin);
  void decide(std::int64_t centre);
  [[nodiscard]] double largest_strength(std::int64_t from, std::int64_t to) const;
  [[nodiscard]] double redness(const WeldBackground::Place& place) const;
  [[nodiscard]] bool is_weld(const WeldShape& shape);
  [[nodiscard]] double noise_ratio() const;

  WeldDetectorParameters parameters_;
  std::vector<WeldFilter> filters_;
  double threshold_;
  double median_strength_;  // of noise
  std::int64_t widest_;     // half of the widest filter; this and the following: cells
  std::int64_t own_;        // as far as a pulse reaches in the output
  std::int64_t crowd_;
  std::int64_t margin_;  // of outputs beyond a peak, before it is decided
  std::int64_t bridged_;
  std::int64_t largest_step_;
  std::int64_t largest_jump_;
  std::int64_t warm_up_;
  // Rows of the grid after those of the channels.
  std::size_t offset_row_;
  std::size_t missing_row_;
  std::size_t samples_row_;   // log2
  std::size_t strength_row_;  // of the best filter
  std::size_t filter_row_;    // which
  std::size_t ratio_row_;     // `noise_ratio` at that time
  SpikeGate gate_;
  std::uint64_t repeats_ = 0;  // of the last sample, in a row
  WeldResampler resampler_;
  LevelMatcher levels_;
  WeldShapeFitter fitter_;
  DistanceGrid grid_;
  std::vector<double> least_noise_;       // of a filter, as a share of that of the widest
  WeldBackground background_;             // of outputs filter * channels + channel
  std::vector<double> energies_;          // of those outputs, scratch of `respond` and `learn`
  std::vector<double> warm_up_energies_;  // scratch of `learn`
  bool learnt_ = false;
  RunningMedian recent_;  // of the strength
  CellRange responded_;   // cells that have a strength
  CellRange decided_;
  int direction_ = 0;  // of travel, while a pass lasts
  std::int64_t farthest_ = 0;
  std::optional<double> last_weld_;
  std::vector<WeldEvent> events_;
  WeldDetectorCounts counts_;
};

}  // namespace pipescout::odometry
