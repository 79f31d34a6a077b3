// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// Girth welds in the signal of an eddy-current probe, sample by sample.
///
/// The signal of a differential coil at a weld is a doublet, two lobes of opposite sign, whose
/// shape is constant in distance, not in time. Samples are averaged into cells of equal distance,
/// and filters matched to doublets of several widths run along the distance. A local maximum of
/// their output above the threshold with the width and shape of a weld is a detection. As a
/// function of position, the detector works equally in both directions of travel.
///
/// Distances are in metres, angles in radians, signal values in any unit.
namespace pipescout::odometry {

inline constexpr std::size_t kMaxEddyCurrentChannels = 8;

/// A point in the impedance plane. Validated: values that are not finite are excluded and counted.
struct Impedance {
  double x = 0.0;
  double y = 0.0;
};

struct WeldDetectorParameters {
  std::size_t channels = 1;  ///< coils, [1, 8]; each with its own noise, all at the same position
  /// m, length of a cell; in (0, smallest_width / 4]: a doublet needs four points.
  double cell = 0.004;
  /// m, between the two lobes of a weld's pulse; (0, 1]. The widths of the filters are between
  /// these two.
  double smallest_width = 0.025;
  double largest_width = 0.06;  ///< m, [smallest_width, 1]
  /// A pulse is refused when its width is outside [smallest / tolerance, largest * tolerance];
  /// [1, 3]: allows for the error of the fit.
  double width_tolerance = 1.2;
  /// False alarms by noise for each km of pipe, (0, 1000]: see `weld_threshold`.
  double false_alarms_per_km = 0.05;
  /// Smallest share of the pulse's energy, without noise, that a doublet explains; [0, 1). Real
  /// passages have 0.83 to 0.93.
  double smallest_match = 0.6;
  /// Largest |a - b| / (a + b), with the heights a and b of the two lobes, reduced by twice its
  /// standard deviation from noise; [0, 1]. A single lobe has 1.
  double largest_asymmetry = 0.5;
  /// Largest energy of another pulse closer than `crowd_distance`, as a share of that of the weld;
  /// (0, 1]. A valve has many pulses, a weld has one. 1: only the largest counts.
  double largest_neighbour = 0.5;
  double crowd_distance = 0.4;  ///< m, [0, 5]; below the shortest joint
  /// Direction of a weld's first lobe (in ascending distance) on channel 0, and its tolerance, [0,
  /// pi]; pi: any direction.
  double phase = 0.0;
  double phase_tolerance = 3.14159265358979323846;
  double background_length = 20.0;  ///< m, over which the noise is estimated, [1, 1000]
  /// m, travelled before the first decision, [0.5, 100]; this part is then evaluated in retrospect.
  double warm_up = 2.0;
  /// Lower bound of the standard deviation of one cell (resolution of the driver); > 0.
  double noise_floor = 1e-9;
  /// Samples that repeat the previous one exactly in all channels indicate a frozen driver: from
  /// this number of repetitions on they are excluded, with the last three that they repeat. 0:
  /// never (for a signal whose resolution is coarse compared with its noise).
  std::size_t frozen_after = 1;
  /// Number of samples within a tenth of a cell that means standstill, [32, 1e9]. Drift of the
  /// level during standstill is removed. Must exceed the number of samples between two ticks of a
  /// coarse odometer.
  std::size_t standing_after = 200;
  /// m, added in quadrature to the standard deviation of a position, because pulses differ from the
  /// doublet; [0, 1].
  double position_floor = 0.001;
  /// m, [cell, 100]. Between two samples: a longer step must be confirmed by three samples in a
  /// row, else it is an outlier of the odometer.
  double largest_step = 0.5;
  /// m, [largest_step, 1e6]. A confirmed step up to this length is an unobserved section of pipe. A
  /// longer one is a new origin of the odometer: earlier reports are discarded.
  double largest_jump = 20.0;
  /// Report a weld at each passage, not only at the first one. A new passage is possible
  /// `turn_distance` after the crawler has reversed.
  bool report_again = false;
  double turn_distance = 1.0;  ///< m, [0.1, 100]
  /// For `WeldEvent::confidence`: distance between welds, m, [0.1, 1000].
  double joint_length = 12.0;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct WeldEvent {
  double distance = 0.0;            ///< m, of its middle, by the odometer
  double standard_deviation = 0.0;  ///< m, of `distance`, without the odometer's error
  /// [0, 1]. 1 / (1 + expected number of noise peaks of at least this strength per joint), reduced
  /// to half at most when the match is just sufficient.
  double confidence = 0.0;
  double amplitude = 0.0;  ///< largest magnitude of the fitted pulse, channel 0
  double width = 0.0;      ///< m, between its lobes
  double phase = 0.0;  ///< rad, (-pi, pi], direction of the lobe at the lesser distance, channel 0
  double strength = 0.0;  ///< the quantity that the threshold applies to
  double match = 0.0;     ///< as in `WeldDetectorParameters::smallest_match`
};

/// Outcomes of the samples and of the peaks above the threshold, since construction.
struct WeldDetectorCounts {
  std::uint64_t samples = 0;
  std::uint64_t bad_distances = 0;  ///< not finite or beyond 1e9 cells
  std::uint64_t bad_values = 0;     ///< a channel not finite or beyond 1e100
  std::uint64_t frozen = 0;         ///< see `frozen_after`
  std::uint64_t spikes = 0;         ///< outliers among their neighbours in time
  std::uint64_t outliers = 0;       ///< steps of the distance that were not confirmed
  std::uint64_t surplus = 0;        ///< not needed: the distance does not advance (standing, stuck)
  std::uint64_t revisiting = 0;     ///< in cells that were passed before
  std::uint64_t gaps = 0;           ///< sections without samples, too long to bridge
  std::uint64_t jumps = 0;          ///< confirmed steps beyond `largest_step`
  std::uint64_t cells = 0;          ///< processed
  std::uint64_t welds = 0;          ///< reported
  std::uint64_t too_narrow = 0;     ///< peaks rejected by width
  std::uint64_t too_wide = 0;       ///< by width
  std::uint64_t wrong_shape = 0;    ///< by `smallest_match` or `largest_asymmetry`
  std::uint64_t wrong_phase = 0;    ///< by `phase_tolerance`
  std::uint64_t crowded = 0;        ///< by `largest_neighbour`
  std::uint64_t incomplete = 0;     ///< a quarter or more of the pulse is in a gap
  std::uint64_t repeated = 0;  ///< closer than `crowd_distance` to the previously reported weld
};

/// The threshold T on the strength S for `false_alarms_per_km`.
///
/// S is the sum over the channels of |a|^2 / (2 sigma^2), a the complex output of a filter and
/// sigma the standard deviation of its real part in noise alone. In Gaussian noise a is a random
/// point in the plane, and S crosses T upwards (Rice 1944; chi with 2C degrees of freedom)
///
///     sum over the filters of  sqrt(rho / pi) T^(C - 1/2) / Gamma(C) exp(-T)
///
/// times for each metre, with rho the mean square slope of the filter divided by its mean square,
/// 1/m^2; C channels. This is an upper bound for noise that is white over the band of the filters:
/// outputs of neighbouring filters are correlated, noise with more power at long wavelengths (1/f)
/// has smaller slopes, and not every peak has the shape of a weld. While the noise was estimated
/// from a few metres only, the threshold is higher: n (exp(T / n) - 1), with n the equivalent
/// number of independent outputs of the variance estimate. Both throw what
/// `WeldDetectorParameters::validate` throws.
[[nodiscard]] double weld_threshold(const WeldDetectorParameters& parameters);
[[nodiscard]] double weld_false_alarms_per_km(const WeldDetectorParameters& parameters,
                                              double threshold);

/// Memory is bounded and taken at construction. The same samples give the same bits. Not for
/// several threads at once.
///
/// The noise is estimated from the signal: for each filter and channel the running median of the
/// output, as a function of the samples per metre (white noise averages out over a slow passage,
/// 1/f noise does not). Increasing noise raises the threshold within metres; decreasing noise
/// lowers it slowly.
class WeldDetector {
 public:
  /// Throws what `WeldDetectorParameters::validate` throws.
  explicit WeldDetector(const WeldDetectorParameters& parameters);
  ~WeldDetector();
  WeldDetector(WeldDetector&&) noexcept;
  WeldDetector& operator=(WeldDetector&&) noexcept;

  /// The next sample: position of the coil and its reading. Returns the new detections, usually
  /// none; they are `delay()` behind in the direction of travel, and the span is valid until the
  /// next call. Missing samples need no call; invalid ones are counted and excluded. Throws
  /// std::invalid_argument when there are not as many channels as in the parameters.
  std::span<const WeldEvent> update(double distance, std::span<const Impedance> channels);

  /// Evaluates the last `delay()` metres as far as possible, at the end of a run. Further samples
  /// may follow.
  std::span<const WeldEvent> finish();

  /// m, from a weld to the position where it is reported.
  [[nodiscard]] double delay() const noexcept;

  [[nodiscard]] const WeldDetectorCounts& counts() const noexcept;
  [[nodiscard]] const WeldDetectorParameters& parameters() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace pipescout::odometry
