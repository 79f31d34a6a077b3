// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/pipe_profile.hpp"
#include "pipescout/thermal/temperature_interval.hpp"

/// Pipes and leaks in one thermal picture: Ibarguren and others (2013), section 5. Lengths in
/// pixels, temperatures in degC.
namespace pipescout::thermal {

enum class ThresholdRule : std::uint8_t {
  kFixed,  ///< `threshold`
  kScene,  ///< between the two classes of temperatures that the picture divides into best (Otsu)
  kLocal,  ///< against the mean of the surroundings; it takes a few times as long. A pipe differs
           ///< from what is on either side of it; one that the border cuts lengthwise shows one
           ///< side only, and is none
};
enum class Polarity : std::uint8_t {
  kHot,   ///< pipes are warmer than what is behind them
  kCold,  ///< or colder
};

enum class Severity : std::uint8_t { kMinor, kModerate, kSevere, kCritical };
/// "minor", "moderate", "severe", "critical"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(Severity severity) noexcept;

/// How bad a leak is, by its Delta-T, the mean above the sound pipe: minor, moderate, severe; one
/// level more for a long one.
struct SeverityScale {
  double moderate_delta = 90.0;  ///< K, > 0: moderate from here on
  double severe_delta = 130.0;   ///< K, > moderate_delta: severe from here on
  double long_leak = 1.0;        ///< m, > 0: long from here on

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
  /// `length`: m; NaN: not known, which is not long.
  [[nodiscard]] Severity of(double delta, double length) const noexcept;
};

/// For what a detector is set up.
enum class DetectorPreset : std::uint8_t {
  kCollectors,  ///< tubes of a solar plant, above 100 degC
  kTorresol,    ///< the same to the letter of the paper
  kHotPipes,    ///< anything long that is warmer than what is around it
  kColdPipes,   ///< or colder
};
inline constexpr std::array kDetectorPresets{DetectorPreset::kCollectors, DetectorPreset::kTorresol,
                                             DetectorPreset::kHotPipes, DetectorPreset::kColdPipes};
/// "collectors", "torresol", "hot_pipes", "cold_pipes"; "unknown" for a value that is no
/// enumerator.
[[nodiscard]] std::string_view to_string(DetectorPreset preset) noexcept;
/// Nothing for a name that none has.
[[nodiscard]] std::optional<DetectorPreset> detector_preset(std::string_view name) noexcept;

struct LeakDetectorParameters {
  ThresholdRule threshold_rule = ThresholdRule::kFixed;
  Polarity polarity = Polarity::kHot;
  double threshold = 100.0;  ///< degC, of `kFixed`; the paper's. A pipe is beyond it, not at it
  /// K, > 0: of `kScene`, how far the means of the two classes must lie apart, or there is no pipe;
  /// of `kLocal`, how far a pipe differs from the mean of its surroundings at least.
  double min_contrast = 2.0;
  /// Of the shorter side of the picture, in (0, 1]: of `kLocal`, half the side of the square of the
  /// surroundings.
  double local_radius = 0.1;

  double min_width = 3.0;       ///< pixels, >= 1: narrower is no pipe
  double max_width = 0.34;      ///< of the shorter side of the picture, in (0, 1]
  double min_length = 0.05;     ///< of the longer side, in (0, 1], of a straight section
  double min_elongation = 3.0;  ///< length over width, >= 1
  double min_visible = 0.5;     ///< of the length of a section, in [0, 1], seen as a pipe
  double straightness = 2.0;    ///< pixels, > 0, that the axis of a straight section may bend
  double max_gap = 0.25;        ///< of the longer side of the picture, >= 0, that is bridged
  double profile_width = 0.5;   ///< of the pipe's, in (0, 1], over which temperatures are averaged
  double pipe_diameter = 0.0;   ///< m, >= 0: gives a scale where none is told; 0: not known
  std::size_t max_pipes = 16;   ///< 1 to 64: the longest are kept

  ProfileParameters profile{};

  SeverityScale severity{};

  [[nodiscard]] static LeakDetectorParameters of(DetectorPreset preset);
  /// The settings of the paper: 100 degC, `ProfileParameters::torresol`.
  [[nodiscard]] static LeakDetectorParameters torresol();
  /// For scenes of which nothing is known: `kLocal`, and leaks of a few degrees.
  [[nodiscard]] static LeakDetectorParameters adaptive(Polarity polarity = Polarity::kHot);
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Why a frame has no detections; the next one is not affected.
enum class FrameFault : std::uint8_t {
  kNone,
  kBadShape,       ///< no pixels, or a stride below the width
  kBadTable,       ///< the table of temperatures does not rise, or lacks counts that occur
  kNoTemperature,  ///< all pixels NaN
  kSaturated,      ///< one and the same value at all pixels
  kCluttered,      ///< more fragments than pipes make; the threshold lies in the background
};
/// "none", "bad_shape", ...; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(FrameFault fault) noexcept;

/// A straight section of a pipe: its axis from `start` to `end`, those parts included that are
/// hidden in between.
struct PipeSection {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double half_width = 0;  ///< distance from the axis to the edge of what is above the threshold
  /// Between its edges: where the radiance is half-way to what is beside the pipe, which depends
  /// neither on the threshold nor on blur. NaN without a `pipe_diameter`, and where one of them is
  /// not seen: at the border, or where what is beside the pipe has no temperature or is as dark as
  /// greys go.
  double width = std::numeric_limits<double>::quiet_NaN();
  double deviation = 0;    ///< of the medial axis about the line, root mean square
  double visible = 0;      ///< share of the length where the pipe is seen as a pipe
  bool cut_along = false;  ///< the border of the picture cuts it lengthwise: the axis is that of
                           ///< what is left
  double metres_per_pixel = 0;       ///< 0: not known
  double reference_temperature = 0;  ///< degC, of the sound pipe; NaN: not known
  std::size_t first_sample = 0;      ///< in Detections::profile; one a pixel, from `start`
  std::size_t samples = 0;
  std::size_t first_part = 0;  ///< in Detections::parts, places from `start`
  std::size_t parts = 0;

  [[nodiscard]] double length() const { return (end - start).norm(); }
  /// `width` where it is known, else that of what is above the threshold.
  [[nodiscard]] double best_width() const { return width > 0 ? width : 2 * half_width; }
  /// On the axis, `along` pixels from `start`.
  [[nodiscard]] Eigen::Vector2d at(double along) const {
    return start + along * (end - start).normalized();
  }
};

struct LeakDetection {
  std::size_t pipe = 0;  ///< in Detections::pipes
  LeakStretch stretch{};
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double delta = 0;       ///< K, mean of the stretch above the sound pipe
  double peak_delta = 0;  ///< K
  /// K, standard, that `delta` and `peak_delta` may be off with all that is of one picture, by
  /// `FrameConditions::errors`; NaN: not known.
  double delta_deviation = std::numeric_limits<double>::quiet_NaN();
  double peak_delta_deviation = std::numeric_limits<double>::quiet_NaN();
  double length = 0;  ///< m; NaN: scale not known
  Severity severity = Severity::kMinor;

  [[nodiscard]] Eigen::Vector2d centre() const { return 0.5 * (start + end); }
};

/// What one frame shows. `pipes` empty and `fault` none: there is no pipe in it.
struct Detections {
  FrameFault fault = FrameFault::kNone;
  int width = 0;
  int height = 0;
  double threshold = 0;              ///< degC, that was used; NaN for `kLocal`
  std::vector<PipeSection> pipes;    ///< longest first
  std::vector<LeakDetection> leaks;  ///< by pipe, from its start
  std::vector<float> profile;        ///< degC, averaged across; NaN where hidden
  std::vector<PipePart> parts;

  [[nodiscard]] std::span<const float> profile_of(const PipeSection& pipe) const {
    return std::span(profile).subspan(pipe.first_sample, pipe.samples);
  }
  [[nodiscard]] std::span<const PipePart> parts_of(const PipeSection& pipe) const {
    return std::span(parts).subspan(pipe.first_part, pipe.parts);
  }
};

/// A pipe that was seen in other pictures, where it is sound.
struct SoundPipe {
  double temperature = 0;                                ///< degC
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< in the picture, unit

  /// Whether one of that direction, unit, may be the same pipe. What runs across it, a post before
  /// it or a pipe that feeds it, is as warm as it is, and that is not known.
  [[nodiscard]] bool may_be(const Eigen::Vector2d& other) const {
    constexpr double kParallel = 0.94;  // cosine of 20 degrees
    return std::abs(direction.dot(other)) >= kParallel;
  }
};

struct FrameConditions {
  double metres_per_pixel = 0;  ///< across the line of sight, where the pipes are; 0: not known
  /// With it a pipe is noticed too that leaks as far as it is seen. See
  /// `ProfileAnalysis::Conditions`.
  std::optional<SoundPipe> sound{};
  /// What temperatures were computed by, and how far that may be off; nothing: not known.
  std::optional<TemperatureErrors> errors{};
};

/// Finds the pipes and their leaks in one frame after the other; frames do not depend on each
/// other.
///
/// The axis: the middles of the chords of what is above the threshold, of its columns or its rows,
/// whichever are shorter. On a strip with parallel edges, of any direction, these are the points
/// farthest from the edges, which is its medial axis, at a cost that grows with the length of the
/// edges and not with the area. Not thread-safe. No allocation after a few frames of one size.
class LeakDetector {
 public:
  /// Throws as LeakDetectorParameters::validate.
  explicit LeakDetector(const LeakDetectorParameters& parameters);
  ~LeakDetector();
  LeakDetector(LeakDetector&& other) noexcept;
  LeakDetector& operator=(LeakDetector&& other) noexcept;

  [[nodiscard]] const LeakDetectorParameters& parameters() const noexcept;

  /// The result stays valid until the next call. Never throws for what is in the picture.
  const Detections& detect(const TemperatureView& image, const FrameConditions& conditions = {});
  /// `celsius`: degC of each count from 0 on, never falling; NaN where a count has none. Counts
  /// beyond its end have none.
  const Detections& detect(const CountView& image, std::span<const float> celsius,
                           const FrameConditions& conditions = {});
  const Detections& detect(const GreyView& image, std::span<const float> celsius,
                           const FrameConditions& conditions = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::thermal
