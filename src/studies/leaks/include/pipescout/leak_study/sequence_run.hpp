// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_study/campaign.hpp"
#include "pipescout/thermal/leak_detector.hpp"

/// Score of the leak inspection on a patrol. Units and frames as in campaign.hpp.
namespace pipescout::leak_study {

/// Errors of the robot's pose. Varying errors are first-order Gauss-Markov processes; all
/// deviations are standard deviations per axis. The paper's robot has a position error of 0.20 m.
struct PoseErrors {
  double level_deviation = 0.12;           ///< m, [0, 10]
  double height_deviation = 0.1;           ///< m, [0, 10]
  double position_time = 20;               ///< s, [0.1, 1e5]
  double heading_deviation = 0.005;        ///< rad, [0, 1]
  double heading_time = 20;                ///< s, [0.1, 1e5]
  double tilt_deviation = 0.003;           ///< rad, [0, 1]: roll and pitch
  double tilt_time = 5;                    ///< s, [0.1, 1e5]
  double mounting_deviation = 0.0035;      ///< rad, [0, 1]: of the camera on the robot; constant
  double mounting_shift_deviation = 0.01;  ///< m, [0, 10]: likewise
  double line_deviation = 0.05;  ///< m, [0, 10]: of the row as surveyed, across it; constant

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct InspectionSettings {
  double frame_rate = 25;  ///< Hz, [1, 200]
  PoseErrors pose{};
  thermal::LeakDetectorParameters detector{};
  /// Detection by contrast in apparent temperatures, and in images with automatic gain in grey
  /// levels; the detector is then that of DetectorPreset::kContrast.
  bool by_contrast = false;
  /// With it: how sure is what the camera is told (thermal::ibarguren2013_object), and which
  /// temperatures its tubes may have. Of cameras without calibration error.
  thermal::ParameterDeviations deviations{.calibration = 0,
                                          .emissivity = 0.02,
                                          .reflected_temperature = 6,
                                          .distance = 1.7,
                                          .atmospheric_temperature = 6,
                                          .relative_humidity = 0.1};
  thermal::PipeTemperatureRange pipe_temperature = thermal::collector_temperatures();
  /// Mounting of the camera, lines and diameter of pipes are set by the run.
  leak_findings::LeakFindingsParameters findings{.range_source = leak_findings::RangeSource::kLine};
};

/// A finding that was raised, at the end of its sequence.
struct FindingScore {
  std::optional<std::size_t> leak{};  ///< of the scene, that it is of
  bool first = true;                  ///< of that leak
  double place = 0;                   ///< m, along the row; NaN without a position
  double mean_delta = 0;              ///< K
  leak_findings::Interval delta_interval{};
  /// K, of the leak, the mean over its length; NaN where it saturates the camera.
  double true_delta = std::numeric_limits<double>::quiet_NaN();
  double length = 0;                                                 ///< m
  double position_error = std::numeric_limits<double>::quiet_NaN();  ///< m
  /// error^T covariance^-1 error, of the level position and of all three axes.
  double level_square = std::numeric_limits<double>::quiet_NaN();
  double square = std::numeric_limits<double>::quiet_NaN();
  std::size_t frames_to_raise = 0;  ///< with a detection of it, the one in which it was raised too
};

struct SequenceScore {
  std::size_t frames = 0;
  double metres = 0;          ///< of tube that was passed
  double metres_seen = 0;     ///< of that, in an image with its whole width
  std::vector<bool> found{};  ///< of each leak of the scene
  std::vector<FindingScore> findings{};
  /// degC, of the sound tube, with `by_contrast` and counts; NaN: unknown.
  thermal::TemperatureInterval tube{.mean = std::numeric_limits<double>::quiet_NaN(),
                                    .low = std::numeric_limits<double>::quiet_NaN(),
                                    .high = std::numeric_limits<double>::quiet_NaN()};
  double true_tube = 0;              ///< degC, mean
  std::size_t frame_faults = 0;      ///< frames without detections, for a reason
  std::size_t false_detections = 0;  ///< in single frames, where there is no leak

  /// Findings without a leak, and duplicates.
  [[nodiscard]] std::size_t false_findings() const;
};

/// Moves a camera that is not fixed to the robot. Called by `run_sequence` in its thread.
class CameraCarrier {
 public:
  virtual ~CameraCarrier() = default;

  /// After each step of the robot; moves the camera of the patrol.
  virtual void step(simulation::ThermalPatrol& patrol) = 0;
  /// The robot's current estimate of the camera's pose on it.
  [[nodiscard]] virtual geometry::SE3 T_base_camera() const = 0;
  /// An image, with the robot's estimate of its pose, and its detections.
  virtual void see(const leak_findings::Frame& frame, const thermal::Detections& detections) = 0;
};

/// A finding is matched to a leak when its position is within its length and 1 m of it. Renders and
/// processes all frames from the beginning to the end of the tube. `carrier`: null for a camera
/// that is fixed to the robot. The same arguments give the same bits. Throws as the `validate` of
/// its arguments.
[[nodiscard]] SequenceScore run_sequence(const SequencePlan& plan,
                                         const InspectionSettings& settings, std::uint64_t seed,
                                         CameraCarrier* carrier = nullptr);

/// Of many sequences.
struct CampaignScore {
  std::size_t sequences = 0;
  std::size_t leaks = 0;
  std::size_t found = 0;
  std::size_t faint_leaks = 0;
  std::size_t faint_found = 0;
  std::size_t near_leaks = 0;
  std::size_t near_found = 0;
  std::size_t false_findings = 0;
  double metres = 0;
  double metres_seen = 0;
  std::vector<double> position_errors{};  ///< m, of found leaks
  std::vector<double> level_squares{};    ///< as FindingScore::level_square
  std::vector<double> squares{};
  std::vector<std::size_t> frames_to_raise{};
  std::size_t intervals = 0;              ///< of found leaks that do not saturate, and of tubes
  std::size_t covering = 0;               ///< of them, with the truth inside
  std::vector<double> relative_widths{};  ///< of those of leaks: half the interval over the truth

  void add(const SequencePlan& plan, const SequenceScore& score);
  CampaignScore& operator+=(const CampaignScore& other);
  [[nodiscard]] double found_percent() const;
  /// Share of the tube that was in an image with its whole width.
  [[nodiscard]] double seen_percent() const;
  /// Share of the findings with the truth within the 95 % ellipse in the plane, and within the
  /// ellipsoid in space.
  [[nodiscard]] double level_coverage_percent() const;
  [[nodiscard]] double coverage_percent() const;
  /// Share of the leaks beside joints and posts that were found.
  [[nodiscard]] double near_percent() const;
  [[nodiscard]] double false_per_km() const;
  /// Share of the 95 % intervals of temperatures with the truth inside.
  [[nodiscard]] double temperature_coverage_percent() const;

 private:
  void add_interval(double low, double high, double truth);
};

}  // namespace pipescout::leak_study
