// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

/// The signal of an eddy-current probe in a pipe, with ground truth: a differential coil that
/// passes girth welds, valves, bends and dents. Both channels together are one complex number, the
/// point in the impedance plane: X is its real part, Y its imaginary part.
///
/// signal = gain(time) * lift-off gain and phase (distance) * pulses of the features (distance)
///        + baseline (time) + lift-off baseline (distance) + white and 1/f noise + mains hum
///        + spikes, and now and then a dropout instead.
///
/// Pulses are functions of distance; noise, hum, spikes and dropouts are functions of time.
/// Distances are in metres, angles in radians, times in seconds; signal values in any unit, that of
/// `weld_peak`. All draws come from engines that the caller seeds; the same seed gives the same
/// draws with every standard library.
namespace pipescout::simulation {

enum class FeatureKind : std::uint8_t {
  kWeld = 0,
  kValve = 1,  ///< 0.4 to 1.2 m of strong pulses of many widths and phases
  kBend = 2,   ///< 1 to 6 m; the coil is lifted off smoothly
  kDent = 3,  ///< a doublet as that of a weld, but 0.12 to 0.5 m wide, in the direction of lift-off
};

/// amplitude * exp(-((d - position - offset) / deviation)^2 / 2).
struct PulseLobe {
  double offset = 0.0;                  ///< m, from the position of the feature
  double deviation = 0.01;              ///< m, above 0
  std::complex<double> amplitude{1.0};  ///< in the impedance plane
};

/// A feature and its pulse.
struct PipeFeature {
  FeatureKind kind = FeatureKind::kWeld;
  double position = 0.0;  ///< m; a weld's is the middle between its two lobes
  std::vector<PulseLobe> lobes;
};

/// A girth weld as a differential coil sees it: two lobes of opposite sign, `lobe_distance` apart,
/// and between them the signal leaves the straight line through the origin by `quadrature` of the
/// peak, which gives the open figure of eight of real passes.
struct WeldPulse {
  double peak = 1.0;            ///< largest magnitude, to 1 % for quadrature 0
  double phase = 0.0;           ///< direction of the first lobe
  double lobe_distance = 0.04;  ///< m
  double slenderness =
      1.5;  ///< lobe_distance / (2 * deviation of a lobe); 1 is nearly d/dx of a bell
  double asymmetry = 0.0;  ///< the first lobe is (1 + asymmetry), the second (1 - asymmetry) high
  double quadrature = 0.0;
};
[[nodiscard]] PipeFeature make_weld(double position, const WeldPulse& pulse);

/// What lies along a pipe.
struct PipeParameters {
  double length = 1000.0;                ///< m, (0, 1e6]
  double joint_length = 12.0;            ///< m, [0.5, length]
  double joint_spread = 0.01;            ///< standard deviation / joint_length, [0, 0.2]
  double weld_peak = 1.0;                ///< median of the peaks, above 0
  double peak_spread = 0.15;             ///< standard deviation of ln(peak / weld_peak), [0, 1]
  double smallest_lobe_distance = 0.03;  ///< m, above 0
  double largest_lobe_distance = 0.05;   ///< m, at least the smallest
  double weld_phase = 2.0;               ///< rad
  double phase_spread = 0.2;             ///< rad, standard deviation, not below 0
  double largest_asymmetry = 0.15;       ///< [0, 0.9]
  double largest_quadrature = 0.3;       ///< of the peak, [0, 1]
  double valves_per_km = 0.5;            ///< [0, 100]; at least 1 m from the nearest weld
  double bends_per_km = 3.0;             ///< [0, 100]; anywhere
  double dents_per_km = 3.0;             ///< [0, 100]; anywhere, on a weld too

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Sorted by position. Throws what `PipeParameters::validate` throws.
[[nodiscard]] std::vector<PipeFeature> draw_features(const PipeParameters& parameters,
                                                     std::uint64_t seed);
/// The same along a pipe whose welds are at `welds`, m: `joint_length` and `joint_spread` do not
/// count. Throws std::invalid_argument too when they do not rise or are not finite.
[[nodiscard]] std::vector<PipeFeature> draw_features(const PipeParameters& parameters,
                                                     std::span<const double> welds,
                                                     std::uint64_t seed);

struct EddyCurrentParameters {
  double sample_rate = 200.0;  ///< Hz, [1, 1e6]
  double weld_peak = 1.0;      ///< reference of all amplitudes below, above 0
  /// dB, 20 log10(weld_peak / standard deviation of the noise of ONE channel, white and 1/f
  /// together),
  /// [-20, 400]. Lift-off only takes from the peaks and hum, spikes and baselines come on top, so
  /// the ratio that a detector meets is lower.
  double peak_snr = 12.0;
  double pink_share = 0.5;            ///< of the noise variance that is 1/f, [0, 1]
  double amplitude_drift = 0.2;       ///< largest |ln gain| over minutes, [0, 2]
  double baseline_drift = 1.0;        ///< weld peaks, over minutes, [0, 100]
  double lift_off_loss = 0.3;         ///< largest -ln gain by lift-off, [0, 3]
  double lift_off_rotation = 0.35;    ///< rad, largest rotation by lift-off, [-pi, pi]
  double lift_off_baseline = 1.0;     ///< weld peaks at the largest lift-off, [0, 100]
  double lift_off_direction = 0.4;    ///< rad, of that baseline
  double hum = 0.1;                   ///< weld peaks, amplitude in each channel, [0, 100]
  double hum_frequency = 50.0;        ///< Hz, [0, 1e6]; aliases when above sample_rate / 2
  double spikes_per_second = 0.1;     ///< [0, sample_rate]
  double spike_peak = 5.0;            ///< weld peaks, of the largest, [0, 1e3]
  double dropouts_per_second = 0.01;  ///< [0, sample_rate]
  double longest_dropout = 0.1;       ///< s, [0, 60]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// All disturbances off: pulses with unit gain only.
[[nodiscard]] EddyCurrentParameters undisturbed();

/// Disturbance of a sample; ground truth, unknown to a driver.
enum class SampleFault : std::uint8_t {
  kNone = 0,
  kSpike = 1,
  kMissing = 2,     ///< dropout: this sample never arrives
  kNotANumber = 3,  ///< dropout: both channels are NaN
  kHeld = 4,        ///< dropout: the last value is repeated
  kZero = 5,        ///< dropout: both channels are zero
};

struct EddyCurrentSample {
  double time = 0.0;      ///< s, from 0
  double distance = 0.0;  ///< m, as given
  std::complex<double> value;
  SampleFault fault = SampleFault::kNone;
};

/// White noise through first-order low passes, a factor of 4 between corners: 1/f from about
/// rate / 100000 to rate / 4, where its Allan variance is constant to a factor of 1.5; flat below.
/// Standard deviation 1.
class PinkNoise {
 public:
  explicit PinkNoise(std::mt19937_64& engine);
  double next(std::mt19937_64& engine);

 private:
  static constexpr std::size_t kPoles = 9;
  std::array<double, kPoles> poles_{};
  std::array<double, kPoles> gains_{};
  std::array<double, kPoles> states_{};
};

/// A slow wander within [-1, 1]: a mean of sinusoids, a closed form of its argument.
class Wander {
 public:
  /// Periods are drawn between the two, evenly in their logarithm.
  Wander(double shortest_period, double longest_period, std::mt19937_64& engine);
  [[nodiscard]] double at(double argument) const noexcept;

 private:
  static constexpr std::size_t kWaves = 5;
  std::array<double, kWaves> rates_{};   // rad per unit
  std::array<double, kWaves> phases_{};  // rad
};

class EddyCurrentSignal {
 public:
  /// `features`: in any order. Throws what `validate` throws, and std::invalid_argument when a
  /// feature has a value that is not finite or a lobe without width.
  EddyCurrentSignal(const EddyCurrentParameters& parameters, std::vector<PipeFeature> features,
                    std::uint64_t seed);

  /// The next sample, 1 / sample_rate after the last, with the coil at `distance` (finite; any
  /// speed, standing and reversing too).
  EddyCurrentSample next(double distance);

  /// Pulses at a position before gains: the reading of an ideal instrument without noise.
  [[nodiscard]] std::complex<double> pulses_at(double distance) const;

  /// Lift-off at a position, [0, 1].
  [[nodiscard]] double lift_off_at(double distance) const noexcept;

  [[nodiscard]] const std::vector<PipeFeature>& features() const noexcept { return features_; }

  /// Of the noise of one channel.
  [[nodiscard]] double noise_deviation() const noexcept { return noise_deviation_; }

 private:
  [[nodiscard]] std::complex<double> noise();
  void disturb(EddyCurrentSample& sample);
  [[nodiscard]] bool happens(double per_second);

  EddyCurrentParameters parameters_;
  std::vector<PipeFeature> features_;  // sorted by position
  double reach_ = 0.0;                 // m, of the widest pulse
  double noise_deviation_ = 0.0;
  std::mt19937_64 engine_;
  Wander gain_;
  Wander baseline_x_;
  Wander baseline_y_;
  Wander lift_off_;
  PinkNoise pink_x_;
  PinkNoise pink_y_;
  double hum_phase_ = 0.0;
  std::uint64_t count_ = 0;
  std::complex<double> spike_{};
  int spike_samples_ = 0;
  SampleFault dropout_ = SampleFault::kNone;
  std::int64_t dropout_samples_ = 0;
  std::complex<double> last_value_{};
};

/// For messages: "weld", "valve", "bend", "dent"; "unknown" for any other value.
[[nodiscard]] const char* to_string(FeatureKind kind) noexcept;

}  // namespace pipescout::simulation
