// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// Girth welds in the signal of an eddy-current probe, sample by sample.
///
/// A differential coil sees a weld as a doublet, two lobes of opposite sign, whose shape is
/// constant in distance, not in time. So samples are first averaged into cells of equal distance;
/// then filters matched to doublets of several widths run along the distance; where their output
/// stands out of the background, is largest and has the width and shape of a weld, there is a weld.
/// A function of position is the same in both directions of travel: so is the detector.
///
/// Distances are in metres, angles in radians, signal values in any unit.
namespace pipescout::odometry {

inline constexpr std::size_t kMaxEddyCurrentChannels = 8;

/// A point in the impedance plane. Not trusted: what is not finite is left out and counted.
struct Impedance {
  double x = 0.0;
  double y = 0.0;
};

struct WeldDetectorParameters {
  std::size_t channels = 1;  ///< coils, [1, 8]; each with its own noise, all over the same place
  /// m, the length of a cell; in (0, smallest_width / 4]: a doublet needs that many points.
  double cell = 0.004;
  /// m, between the two lobes of a weld's pulse; (0, 1]. The filters lie between the two widths.
  double smallest_width = 0.025;
  double largest_width = 0.06;  ///< m, [smallest_width, 1]
  /// A pulse is refused when its width is outside [smallest / tolerance, largest * tolerance];
  /// [1, 3]: allows for the error of the fit.
  double width_tolerance = 1.2;
  /// False alarms by noise for each km of pipe, (0, 1000]: see `weld_threshold`.
  double false_alarms_per_km = 0.05;
  /// Share of the pulse's energy, noise taken off, that a doublet explains; [0, 1). Real passes
  /// have 0.83 to 0.93.
  double smallest_match = 0.6;
  /// Largest |a - b| / (a + b), a and b being the heights of the two lobes, twice its deviation by
  /// noise taken off; [0, 1]. A lone bump has 1.
  double largest_asymmetry = 0.5;
  /// Largest energy of another pulse closer than `crowd_distance`, as a share of that of the weld;
  /// (0, 1]. Valves are crowds of pulses; a weld stands alone. 1: only the largest counts.
  double largest_neighbour = 0.5;
  double crowd_distance = 0.4;  ///< m, [0, 5]; below the shortest joint
  /// Direction of a weld's first lobe (in ascending distance) on channel 0, and how far it may be
  /// off, [0, pi]; pi: any direction will do.
  double phase = 0.0;
  double phase_tolerance = 3.14159265358979323846;
  double background_length = 20.0;  ///< m, over which the noise is learnt, [1, 1000]
  /// m, travelled before the first decision, [0.5, 100]; what lies on the way is made up for then.
  double warm_up = 2.0;
  /// Standard deviation of one cell that even a quiet signal has (resolution of the driver); > 0.
  double noise_floor = 1e-9;
  /// Samples that repeat the one before bit by bit in all channels are a driver that hangs: from
  /// this repetition on they are left out, with the last three that they repeat. 0: never (a signal
  /// that is coarse beside its noise).
  std::size_t frozen_after = 1;
  /// Samples within a tenth of a cell, from which on the crawler stands, [32, 1e9]. What the level
  /// drifts meanwhile is taken off. More than the samples between two ticks of a coarse odometer.
  std::size_t standing_after = 200;
  /// m, added in quadrature to the standard deviation of a position: pulses differ from the
  /// doublet; [0, 1].
  double position_floor = 0.001;
  /// m, [cell, 100]. Between two samples: a longer step must be confirmed by three samples in a
  /// row, else it is an outlier of the odometer.
  double largest_step = 0.5;
  /// m, [largest_step, 1e6]. A confirmed step up to here is pipe that was passed unseen. A longer
  /// one is a new origin of the odometer: what was reported before is forgotten.
  double largest_jump = 20.0;
  /// Report a weld each time that it is passed, not only the first time. A pass begins
  /// `turn_distance` after the crawler has turned.
  bool report_again = false;
  double turn_distance = 1.0;  ///< m, [0.1, 100]
  /// For `WeldEvent::confidence`: how far apart welds are, m, [0.1, 1000].
  double joint_length = 12.0;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct WeldEvent {
  double distance = 0.0;            ///< m, of its middle, as the odometer counts
  double standard_deviation = 0.0;  ///< m, of `distance`, the odometer's own error left out
  /// [0, 1]. 1 / (1 + noise peaks at least as strong that a joint holds on average), halved at most
  /// when the match is just enough.
  double confidence = 0.0;
  double amplitude = 0.0;  ///< largest magnitude of the fitted pulse, channel 0
  double width = 0.0;      ///< m, between its lobes
  double phase = 0.0;  ///< rad, (-pi, pi], direction of the lobe at the lesser distance, channel 0
  double strength = 0.0;  ///< the quantity that the threshold applies to
  double match = 0.0;     ///< as in `WeldDetectorParameters::smallest_match`
};

/// What became of the samples and of the peaks above the threshold, since construction.
struct WeldDetectorCounts {
  std::uint64_t samples = 0;
  std::uint64_t bad_distances = 0;  ///< not finite or beyond 1e9 cells
  std::uint64_t bad_values = 0;     ///< a channel not finite or beyond 1e100
  std::uint64_t frozen = 0;         ///< see `frozen_after`
  std::uint64_t spikes = 0;         ///< stand out of their neighbours in time
  std::uint64_t outliers = 0;       ///< steps of the distance that were not confirmed
  std::uint64_t surplus = 0;        ///< not needed: the distance does not advance (standing, stuck)
  std::uint64_t revisiting = 0;     ///< over cells that are known
  std::uint64_t gaps = 0;           ///< stretches without samples, too long to bridge
  std::uint64_t jumps = 0;          ///< confirmed steps beyond `largest_step`
  std::uint64_t cells = 0;          ///< processed
  std::uint64_t welds = 0;          ///< reported
  std::uint64_t too_narrow = 0;     ///< peaks that are no weld: by width
  std::uint64_t too_wide = 0;       ///< by width
  std::uint64_t wrong_shape = 0;    ///< by `smallest_match` or `largest_asymmetry`
  std::uint64_t wrong_phase = 0;    ///< by `phase_tolerance`
  std::uint64_t crowded = 0;        ///< by `largest_neighbour`
  std::uint64_t incomplete = 0;     ///< a quarter or more of the pulse lies in a gap
  std::uint64_t repeated = 0;       ///< closer than `crowd_distance` to the weld reported before
};

/// The threshold T on the strength S that keeps the promise of `false_alarms_per_km`.
///
/// S is the sum over the channels of |a|^2 / (2 sigma^2), a the complex output of a filter and
/// sigma the standard deviation of its real part in noise alone. In Gaussian noise of one output a
/// is a point that wanders about the plane, and S rises through T (Rice 1944; chi with 2C degrees
/// of freedom)
///
///     sum over the filters of  sqrt(rho / pi) T^(C - 1/2) / Gamma(C) exp(-T)
///
/// times for each metre, rho being the mean square slope of the filter over its mean square, 1/m^2;
/// C channels. This is an upper bound for noise that is white over the band of the filters: outputs
/// of neighbouring filters go together, noise with more power in long waves (1/f) has smaller
/// slopes, and not each peak has the shape of a weld. A detector that knows the noise from few
/// metres only asks for more: n (exp(T / n) - 1), n being the independent outputs that its variance
/// stands for. Both throw what
/// `WeldDetectorParameters::validate` throws.
[[nodiscard]] double weld_threshold(const WeldDetectorParameters& parameters);
[[nodiscard]] double weld_false_alarms_per_km(const WeldDetectorParameters& parameters,
                                              double threshold);

/// Memory is bounded and taken at construction. The same samples give the same bits. Not for
/// several threads at once.
///
/// The noise is learnt from the signal itself: for each filter and channel the running median of
/// the output, as a function of the samples per metre (white noise averages out over a slow
/// passage, 1/f noise does not). A rise of the noise over metres raises the threshold; a fall
/// lowers it slowly.
class WeldDetector {
 public:
  /// Throws what `WeldDetectorParameters::validate` throws.
  explicit WeldDetector(const WeldDetectorParameters& parameters);
  ~WeldDetector();
  WeldDetector(WeldDetector&&) noexcept;
  WeldDetector& operator=(WeldDetector&&) noexcept;

  /// The next sample: where the coil is, and what it reads there. Returns the welds that are now
  /// certain, mostly none; they lie `delay()` behind in the direction of travel, and the span is
  /// good until the next call. Samples that are missing need no call; bad ones are counted and left
  /// out. Throws std::invalid_argument when there are not as many channels as in the parameters.
  std::span<const WeldEvent> update(double distance, std::span<const Impedance> channels);

  /// Decides what it can of the last `delay()` metres: the end of a run. The next sample may
  /// follow.
  std::span<const WeldEvent> finish();

  /// m, from a weld to the place where it is reported.
  [[nodiscard]] double delay() const noexcept;

  [[nodiscard]] const WeldDetectorCounts& counts() const noexcept;
  [[nodiscard]] const WeldDetectorParameters& parameters() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace pipescout::odometry
