// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

/// From temperatures along a pipe to the parts that leak: section 5 of Ibarguren, Molina,
/// Susperregi, Maurtua, "Thermal tracking in mobile robots for leak inspection activities", Sensors
/// 13 (2013), from equation (4) to the label. Temperatures in degC, their differences in K; places
/// along the pipe in samples from the first one, sample i reaching from i to i + 1.
namespace pipescout::thermal {

enum class PartKind : std::uint8_t {
  kPipe,
  kLeak,
  kShort,        ///< narrower than a leak can be: a joint, an edge, a defect of the picture
  kHidden,       ///< nothing is seen of the pipe there
  kNotThisPipe,  ///< what is hot there does not have the pipe's shape: another pipe, a body before
                 ///< it
};
/// "pipe", "leak", "short", "hidden", "not_this_pipe"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(PartKind kind) noexcept;

struct ProfileParameters {
  /// K, > 0: Delta-T, the least change that divides the pipe. The paper has 70, without blur.
  double split_delta = 35.0;
  /// Samples, 1 to 64: between which the change is taken, so that an edge that is blurred counts in
  /// full. 1 is equation (4).
  int split_distance = 5;
  /// Whether a part whose temperature creeps by more than `split_delta` is divided too, half-way
  /// up.
  bool split_creeping = true;
  /// Samples, >= 1: what is warm over less is a joint and no leak, and other parts below count as
  /// defects.
  double min_part_width = 8.0;
  /// m, >= 0: the same where the scale is known; it then takes the place of `min_part_width`, but
  /// never below `kLeastSamples`. Half-way, by their ratio, between the widest joints, 0.18 m, and
  /// the shortest leaks, 0.3 m.
  double min_part_width_m = 0.24;
  /// K, > 0: a part leaks that is warmer than the pipe by as much; nothing: such a part is none.
  std::optional<double> leak_delta = 50.0;
  /// degC, a part leaks that is warmer; nothing: such a part is none.
  std::optional<double> maximum_temperature{};
  /// In (0, 1): the temperature of the pipe is the one that this part of its length stays below.
  double reference_quantile = 0.25;

  static constexpr double kLeastSamples = 3.0;

  /// With the settings of the paper: equation (4) with 70 K, and labels by one temperature, which
  /// the paper does not tell: 165 degC lies in the gap of its Figure 7 between pipes that are sound
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

/// Parts that leak and follow each other, what is short among them included.
struct LeakStretch {
  double from = 0;  ///< where the temperature is half-way between pipe and leak
  double to = 0;
  /// Where the rise begins, by half of what makes a leak: unlike `from` and `to` it stays where it
  /// is however warm what is seen of the leak. NaN where that is not seen.
  double onset_from = 0;
  double onset_to = 0;
  double mean = 0;             ///< degC, of the leaking parts
  double deviation = 0;        ///< K, of their samples about the mean
  double peak = 0;             ///< degC
  bool open_at_start = false;  ///< the stretch goes on where the profile has ended, or is hidden
  bool open_at_end = false;
};

/// Splits, filters and labels. Keeps its memory: no allocation once it has seen a profile as long.
class ProfileAnalysis {
 public:
  /// Throws as `ProfileParameters::validate`.
  explicit ProfileAnalysis(const ProfileParameters& parameters);
  [[nodiscard]] const ProfileParameters& parameters() const noexcept { return parameters_; }

  struct Conditions {
    double metres_per_sample = 0;  ///< 0: not known
    /// degC, of the sound pipe where it is known. It counts when the pipe is warmer by half of
    /// `leak_delta` (without it, of `split_delta`) for most of the profile: all of that may leak.
    std::optional<double> reference_temperature{};
  };

  /// `temperatures`: degC; NaN where the pipe is hidden. `pipe_shaped`: of each sample, whether
  /// what is there has the shape of the pipe; empty: all have.
  void analyse(std::span<const float> temperatures, std::span<const std::uint8_t> pipe_shaped,
               const Conditions& conditions);

  /// In order, without gaps or overlaps, from 0 to the number of samples.
  [[nodiscard]] std::span<const PipePart> parts() const noexcept { return parts_; }
  [[nodiscard]] std::span<const LeakStretch> leaks() const noexcept { return leaks_; }
  /// degC, of the sound pipe: found along it, or given; NaN when nothing of the pipe is seen.
  [[nodiscard]] double reference_temperature() const noexcept { return reference_; }

 private:
  using Temperatures = std::span<const float>;
  using Shapes = std::span<const std::uint8_t>;
  void divide(Temperatures t);
  void divide_at_edges(Temperatures t, int from, int to);
  void divide_creeping(Temperatures t);
  void measure(Temperatures t, PipePart& part) const;
  [[nodiscard]] double least_rise() const;
  [[nodiscard]] double quantile(Temperatures t, Shapes pipe_shaped);
  [[nodiscard]] bool is_warm(const PipePart& part) const;
  void label(Temperatures t, Shapes pipe_shaped);
  void label_warm(Temperatures t, Shapes pipe_shaped, std::size_t first, std::size_t last);
  void join_leaks(Temperatures t);

  ProfileParameters parameters_;
  double least_width_ = 0;
  double reference_ = 0;
  std::vector<PipePart> parts_;
  std::vector<PipePart> scratch_;
  std::vector<float> sorted_;
  std::vector<LeakStretch> leaks_;
};

/// Equation (4): |T_{i+d} - T_i|, K, one value less than temperatures for each sample of d. For
/// plots; NaN where a temperature is.
void absolute_change(std::span<const float> temperatures, int distance, std::vector<float>& change);

}  // namespace pipescout::thermal
