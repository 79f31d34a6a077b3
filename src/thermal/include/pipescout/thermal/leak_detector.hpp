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
#include "pipescout/thermal/radiometry_posterior.hpp"
#include "pipescout/thermal/temperature_interval.hpp"

/// Detection of pipes and leaks in one thermal image: Ibarguren and others (2013), section 5.
/// Lengths in pixels, temperatures in degC.
namespace pipescout::thermal {

enum class ThresholdRule : std::uint8_t {
  kFixed,  ///< `threshold`
  kScene,  ///< between the two classes of temperatures (Otsu's method)
  kLocal,  ///< relative to the mean of the surroundings; takes a few times as long. A pipe differs
           ///< from both of its sides; one cut lengthwise by the border has one side only and is
           ///< not detected
  /// Relative to the longest straight ridge of the image: of one tube, without degrees
  kContrast,
};
enum class Polarity : std::uint8_t {
  kHot,   ///< pipes are warmer than the background
  kCold,  ///< or colder
};

enum class Severity : std::uint8_t { kMinor, kModerate, kSevere, kCritical };
/// "minor", "moderate", "severe", "critical"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(Severity severity) noexcept;

/// Severity of a leak by its Delta-T, the mean above the sound pipe: minor, moderate, severe; one
/// level higher for a long one.
struct SeverityScale {
  double moderate_delta = 90.0;  ///< K, > 0: lower bound of moderate
  double severe_delta = 130.0;   ///< K, > moderate_delta: lower bound of severe
  double long_leak = 1.0;        ///< m, > 0: lower bound of long

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
  /// `length`: m; NaN: unknown, treated as not long.
  [[nodiscard]] Severity of(double delta, double length) const noexcept;
};

/// Preset of a detector.
enum class DetectorPreset : std::uint8_t {
  kCollectors,  ///< tubes of a solar plant, above 100 degC
  kTorresol,    ///< the same, exactly as in the paper
  kHotPipes,    ///< anything long that is warmer than its surroundings
  kColdPipes,   ///< or colder
  kContrast,    ///< tubes of a solar plant, in images of which nobody knows the degrees
};
inline constexpr std::array kDetectorPresets{DetectorPreset::kCollectors, DetectorPreset::kTorresol,
                                             DetectorPreset::kHotPipes, DetectorPreset::kColdPipes,
                                             DetectorPreset::kContrast};
/// Where none is told, of components and commands alike: it looks for nothing colder than 100 degC,
/// so that what is merely warm is no leak. PresetTrial finds others that would have found pipes.
inline constexpr DetectorPreset kDefaultPreset = DetectorPreset::kCollectors;
/// "collectors", "torresol", "hot_pipes", "cold_pipes", "contrast"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(DetectorPreset preset) noexcept;
/// Nothing for an unknown name.
[[nodiscard]] std::optional<DetectorPreset> detector_preset(std::string_view name) noexcept;

struct LeakDetectorParameters {
  ThresholdRule threshold_rule = ThresholdRule::kFixed;
  Polarity polarity = Polarity::kHot;
  double threshold = 100.0;  ///< degC, of `kFixed`, as in the paper; exclusive
  /// K, > 0: of `kScene`, smallest difference between the means of the two classes; of `kLocal`,
  /// of `kContrast`, smallest difference of a pipe from the mean of its surroundings.
  double min_contrast = 2.0;
  /// Of the shorter side of the picture, in (0, 1]: of `kLocal`, half the side of the square of the
  /// surroundings.
  double local_radius = 0.1;

  double min_width = 3.0;       ///< pixels, >= 1
  double max_width = 0.34;      ///< of the shorter side of the picture, in (0, 1]
  double min_length = 0.05;     ///< of the longer side, in (0, 1], of a straight section
  double min_elongation = 3.0;  ///< length over width, >= 1
  /// share of the length of a section, in [0, 1], that is visible as a pipe
  double min_visible = 0.5;
  /// pixels, > 0: largest deviation of the axis of a straight section from a line
  double straightness = 2.0;
  double max_gap = 0.25;  ///< of the longer side of the image, >= 0, that is bridged
  /// of the pipe's width, in (0, 1], over which temperatures are averaged
  double profile_width = 0.5;
  double pipe_diameter = 0.0;  ///< m, >= 0: gives the scale if none is given; 0: unknown
  std::size_t max_pipes = 16;  ///< 1 to 64: the longest are kept

  ProfileParameters profile{};

  SeverityScale severity{};

  /// In (0, 1): of `kContrast`, the threshold lies at this share of the way from the surroundings
  /// to the tube: high, because the image of a tube in its mirror may be almost as warm.
  double contrast_level = 0.85;

  [[nodiscard]] static LeakDetectorParameters of(DetectorPreset preset);
  /// The settings of the paper: 100 degC, `ProfileParameters::torresol`.
  [[nodiscard]] static LeakDetectorParameters torresol();
  /// For unknown scenes: `kLocal`, and leaks of a few degrees.
  [[nodiscard]] static LeakDetectorParameters adaptive(Polarity polarity = Polarity::kHot);
  /// By contrast alone: `ThresholdRule::kContrast`, and leaks by the spread of the tube along its
  /// length. For apparent temperatures, of black bodies, and for grey levels of automatic gain.
  [[nodiscard]] static LeakDetectorParameters by_contrast();
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The reason why a frame has no detections; the next one is not affected.
enum class FrameFault : std::uint8_t {
  kNone,
  kBadShape,       ///< no pixels, or a stride below the width
  kBadTable,       ///< the table of temperatures is not increasing, or does not cover all counts
  kNoTemperature,  ///< all pixels NaN
  kSaturated,      ///< the same value at all pixels
  kCluttered,      ///< too many fragments; the threshold is within the background
};
/// "none", "bad_shape", ...; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(FrameFault fault) noexcept;

/// A straight section of a pipe: its axis from `start` to `end`, including hidden parts in between.
/// Of a known pipe, the axis and `half_width` are those of its strips, within the image.
struct PipeSection {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double half_width = 0;  ///< distance from the axis to the edge of the pixels above the threshold
  /// Width between its edges, where the radiance is half-way to the background; it depends neither
  /// on the threshold nor on blur. NaN without a `pipe_diameter`, and where an edge is not visible:
  /// at the border, or where the background has no temperature or is at the lower end of the grey
  /// levels.
  double width = std::numeric_limits<double>::quiet_NaN();
  double deviation = 0;  ///< of the medial axis about the line, root mean square
  /// Share of the length that is visible as a pipe; of a known pipe, of what no other one hides.
  double visible = 0;
  /// the border of the image cuts it lengthwise: the axis is that of the visible part
  bool cut_along = false;
  double metres_per_pixel = 0;       ///< 0: unknown
  double reference_temperature = 0;  ///< degC, of the sound pipe; NaN: unknown
  double spread = 0;    ///< K, robust standard deviation of the sound pipe along its length
  double contrast = 0;  ///< K, to the side that differs less; NaN: neither side is visible
  std::size_t first_sample = 0;  ///< in Detections::profile; one per pixel, from `start`
  std::size_t samples = 0;
  std::size_t first_part = 0;  ///< in Detections::parts, positions from `start`
  std::size_t parts = 0;

  [[nodiscard]] double length() const { return (end - start).norm(); }
  /// `width` if known, else that of the pixels above the threshold.
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
  /// K, standard deviation of `delta` and `peak_delta` due to errors common to one image, from
  /// `FrameConditions::errors`; NaN: unknown.
  double delta_deviation = std::numeric_limits<double>::quiet_NaN();
  double peak_delta_deviation = std::numeric_limits<double>::quiet_NaN();
  /// K, 95 % of `delta` and `peak_delta`, of `FrameConditions::posterior`; without it NaN.
  double delta_low = std::numeric_limits<double>::quiet_NaN();
  double delta_high = std::numeric_limits<double>::quiet_NaN();
  double peak_delta_low = std::numeric_limits<double>::quiet_NaN();
  double peak_delta_high = std::numeric_limits<double>::quiet_NaN();
  double length = 0;  ///< m; NaN: scale unknown
  /// Pixels, from the axis to the middle of the warmth across the pipe: positive to the right of
  /// the direction from `start` to `end`, as seen in the image.
  double across = 0;
  Severity severity = Severity::kMinor;

  [[nodiscard]] Eigen::Vector2d centre() const { return 0.5 * (start + end); }
};

/// Detections of one frame. `pipes` empty and `fault` none: no pipe in the image.
struct Detections {
  FrameFault fault = FrameFault::kNone;
  int width = 0;
  int height = 0;
  double threshold = 0;              ///< degC, used; NaN for `kLocal`
  std::vector<PipeSection> pipes;    ///< longest first
  std::vector<LeakDetection> leaks;  ///< by pipe, from its start
  std::vector<float> profile;        ///< degC, averaged across; NaN where hidden
  std::vector<PipePart> parts;

  /// Of the pipes at least half as long as the longest, the one that differs most from its
  /// surroundings: a tube, not its image in a mirror. Null without pipes.
  [[nodiscard]] const PipeSection* main_pipe() const noexcept;
  [[nodiscard]] std::span<const float> profile_of(const PipeSection& pipe) const {
    return std::span(profile).subspan(pipe.first_sample, pipe.samples);
  }
  [[nodiscard]] std::span<const PipePart> parts_of(const PipeSection& pipe) const {
    return std::span(parts).subspan(pipe.first_part, pipe.parts);
  }
};

/// The sound part of a pipe in other images.
struct SoundPipe {
  double temperature = 0;                                ///< degC
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< in the image, unit vector
  std::optional<double> spread{};                        ///< K, as PipeSection::spread

  /// Whether a section with this direction (unit vector) may be the same pipe. The temperature of
  /// an object across it, such as a post or a feed pipe, is unrelated.
  [[nodiscard]] bool may_be(const Eigen::Vector2d& other) const {
    constexpr double kParallel = 0.94;  // cosine of 20 degrees
    return std::abs(direction.dot(other)) >= kParallel;
  }
};

/// Where a straight section of a pipe is in the image, from the geometry of the pipes and the pose
/// of the camera. It need not be within the image.
struct PipeStrip {
  /// Which pipe. Strips of one pipe follow each other from its start, on one line.
  std::size_t pipe = 0;
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  ///< pixels, half-way between its two edges
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  std::array<double, 2> half_width{};  ///< pixels, > 0, at start and end
  std::array<double, 2> depth{};       ///< m, > 0, of its surface, at start and end
  double metres_per_pixel = 0;         ///< along it, mean
};

struct FrameConditions {
  /// Across the line of sight, at the pipes; 0: unknown. Those of `strips` have their own.
  double metres_per_pixel = 0;
  /// With it a pipe that leaks over its whole visible length is detected too. See
  /// `ProfileAnalysis::Conditions`.
  std::optional<SoundPipe> sound{};
  /// Conditions of the conversion to temperatures and their uncertainty; nothing: unknown.
  std::optional<TemperatureErrors> errors{};
  /// Of images of apparent temperatures: turns the rise of a leak, which was detected by contrast,
  /// to kelvins of the pipe with their uncertainty. Must outlive the call. Null: rises are those of
  /// the image.
  const RadiometryPosterior* posterior = nullptr;
  /// The values are grey levels of automatic gain. Another image's mean something else, so the
  /// temperature of `sound` is not used, and no rise is told in kelvins: `delta` and `peak_delta`
  /// are NaN.
  bool levels = false;
  /// All pipes in view, when they are known; empty: they are searched for. Each is compared with
  /// itself along these strips, whatever is connected to it above the threshold. What lies in two
  /// strips belongs to the pipe that is nearer to the camera: the other one is hidden there.
  std::vector<PipeStrip> strips{};
};

/// Detects pipes and their leaks in frames, independently of each other.
///
/// The axis consists of the middles of the chords of the pixels above the threshold, along columns
/// or rows, whichever are shorter. On a strip with parallel edges in any direction, these are the
/// points of the medial axis, computed in time proportional to the length of the edges and not to
/// the area. Pipes that are known by `FrameConditions::strips` have their axes from there; a pipe
/// that is not above the threshold where it should be is no pipe. Not thread-safe. No allocation
/// after a few frames of one size.
class LeakDetector {
 public:
  /// Throws as LeakDetectorParameters::validate.
  explicit LeakDetector(const LeakDetectorParameters& parameters);
  ~LeakDetector();
  LeakDetector(LeakDetector&& other) noexcept;
  LeakDetector& operator=(LeakDetector&& other) noexcept;

  [[nodiscard]] const LeakDetectorParameters& parameters() const noexcept;

  /// The result stays valid until the next call. Never throws for any image content.
  const Detections& detect(const TemperatureView& image, const FrameConditions& conditions = {});
  /// `celsius`: degC of each count from 0 on, non-decreasing; NaN where a count has no temperature.
  /// Counts beyond its end have none.
  const Detections& detect(const CountView& image, std::span<const float> celsius,
                           const FrameConditions& conditions = {});
  const Detections& detect(const GreyView& image, std::span<const float> celsius,
                           const FrameConditions& conditions = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::thermal
