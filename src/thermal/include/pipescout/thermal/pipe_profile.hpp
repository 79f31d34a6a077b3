// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

/// Detection of leaking parts in the temperatures along a pipe: section 5 of Ibarguren, Molina,
/// Susperregi, Maurtua, "Thermal tracking in mobile robots for leak inspection activities", Sensors
/// 13 (2013), from equation (4) to the label. Temperatures in degC, their differences in K;
/// positions along the pipe in samples from the first one; sample i extends from i to i + 1.
namespace pipescout::thermal {

enum class PartKind : std::uint8_t {
  kPipe,
  kLeak,
  kShort,        ///< shorter than a leak: a joint, an edge, an image defect
  kHidden,       ///< the pipe is not visible there
  kNotThisPipe,  ///< the shape differs from the pipe's: another pipe, an object in front of it
};
/// "pipe", "leak", "short", "hidden", "not_this_pipe"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(PartKind kind) noexcept;

struct ProfileParameters {
  /// K, > 0: Delta-T, smallest change that splits the pipe. The paper has 70, without blur.
  double split_delta = 35.0;
  /// Samples, 1 to 64: distance over which the change is computed, so that the full step of a
  /// blurred edge is used. 1 is equation (4).
  int split_distance = 5;
  /// Whether a part whose temperature changes gradually by more than `split_delta` is split too,
  /// half-way.
  bool split_creeping = true;
  /// Samples, >= 1: shorter warm parts are joints and not leaks; other shorter parts are defects.
  double min_part_width = 8.0;
  /// m, >= 0: the same if the scale is known; it then replaces `min_part_width`, but not below
  /// `kLeastSamples`. Half-way, by their ratio, between the widest joints, 0.18 m, and the shortest
  /// leaks, 0.3 m.
  double min_part_width_m = 0.24;
  /// K, > 0: a part that is this much warmer than the pipe is a leak; nothing: rule not used.
  std::optional<double> leak_delta = 50.0;
  /// degC, a warmer part is a leak; nothing: rule not used.
  std::optional<double> maximum_temperature{};
  /// >= 0: a leak rises by at least so many standard deviations of the sound pipe along its length,
  /// and by this share of the contrast of the pipe to its surroundings. Larger values of the two
  /// replace `leak_delta`, and `split_delta` in proportion: so a leak is found though nobody knows
  /// how many degrees a change of the image means. 0: not used.
  double leak_spreads = 0.0;
  double leak_share = 0.0;
  /// In (0, 1): the temperature of the pipe is this quantile over its length.
  double reference_quantile = 0.25;

  static constexpr double kLeastSamples = 3.0;

  /// With the settings of the paper: equation (4) with 70 K, and labels by one temperature, which
  /// the paper does not give: 165 degC is in the gap of its Figure 7 between pipes that are sound
  /// (to 160.39 degC) and the stretches that leak (from 170.58 degC).
  [[nodiscard]] static ProfileParameters torresol();
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct PipePart {
  double from = 0;
  double to = 0;
  double mean = 0;       ///< degC, without the flanks next to edges; NaN when hidden
  double deviation = 0;  ///< K, of the samples about the mean
  double peak = 0;       ///< degC, the warmest sample
  PartKind kind = PartKind::kPipe;
};

/// Consecutive leaking parts, including short parts between them.
struct LeakStretch {
  double from = 0;  ///< position where the temperature is half-way between pipe and leak
  double to = 0;
  /// Position where the rise begins, at half of the leak threshold: unlike `from` and `to` it does
  /// not depend on the temperature of the visible part of the leak. NaN where it is not visible.
  double onset_from = 0;
  double onset_to = 0;
  double mean = 0;             ///< degC, of the leaking parts
  double deviation = 0;        ///< K, of their samples about the mean
  double peak = 0;             ///< degC
  bool open_at_start = false;  ///< the leak continues beyond the profile, or under a hidden part
  bool open_at_end = false;
};

/// Splits, filters and labels. Allocates only until the longest profile has occurred.
class ProfileAnalysis {
 public:
  /// Throws as `ProfileParameters::validate`.
  explicit ProfileAnalysis(const ProfileParameters& parameters);
  [[nodiscard]] const ProfileParameters& parameters() const noexcept { return parameters_; }

  struct Conditions {
    double metres_per_sample = 0;  ///< 0: unknown
    /// degC, of the sound pipe if known. It is used when most of the profile is warmer by half of
    /// `leak_delta` (without it, of `split_delta`): the whole profile may be a leak.
    std::optional<double> reference_temperature{};
    /// K, of the sound pipe along its length if known from other images; else from the profile.
    std::optional<double> spread{};
    double contrast = 0;  ///< K, of the pipe to its surroundings
  };

  /// `temperatures`: degC; NaN where the pipe is hidden. `pipe_shaped`: for each sample, whether it
  /// has the shape of the pipe; empty: all have.
  void analyse(std::span<const float> temperatures, std::span<const std::uint8_t> pipe_shaped,
               const Conditions& conditions);

  /// In order, without gaps or overlaps, from 0 to the number of samples.
  [[nodiscard]] std::span<const PipePart> parts() const noexcept { return parts_; }
  [[nodiscard]] std::span<const LeakStretch> leaks() const noexcept { return leaks_; }
  /// degC, of the sound pipe: estimated along it, or given; NaN when the pipe is not visible.
  [[nodiscard]] double reference_temperature() const noexcept { return reference_; }
  /// K, robust standard deviation of the sound pipe along its length; NaN when it is not visible.
  [[nodiscard]] double spread() const noexcept { return spread_; }

 private:
  using Temperatures = std::span<const float>;
  using Shapes = std::span<const std::uint8_t>;
  void divide(Temperatures t);
  void divide_at_edges(Temperatures t, int from, int to);
  void divide_creeping(Temperatures t);
  void measure(Temperatures t, PipePart& part) const;
  [[nodiscard]] double least_rise() const;
  void collect(Temperatures t, Shapes pipe_shaped);
  [[nodiscard]] double quantile(double share);
  void choose_rise(const Conditions& conditions);
  [[nodiscard]] bool is_warm(const PipePart& part) const;
  void label(Temperatures t, Shapes pipe_shaped);
  void label_warm(Temperatures t, Shapes pipe_shaped, std::size_t first, std::size_t last);
  void join_leaks(Temperatures t);

  ProfileParameters parameters_;
  double least_width_ = 0;
  double reference_ = 0;
  double spread_ = 0;
  double rise_ = 0;   // K, from which a part is a leak
  double split_ = 0;  // K, that splits
  std::vector<PipePart> parts_;
  std::vector<PipePart> scratch_;
  std::vector<float> shown_;
  std::vector<LeakStretch> leaks_;
};

/// Equation (4): |T_{i+d} - T_i|, K, d values less than temperatures. For plots; NaN where a
/// temperature is NaN.
void absolute_change(std::span<const float> temperatures, int distance, std::vector<float>& change);

}  // namespace pipescout::thermal
