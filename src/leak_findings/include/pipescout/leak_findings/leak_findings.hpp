// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/thermal/leak_detector.hpp"

/// From detections in single frames to findings. Units and frames as in finding.hpp; `base` is the
/// body of the robot, `camera` optical: x right, y down, z forward.
namespace pipescout::leak_findings {

/// Source of the range of the pipes. Motion between frames adds information in every case. A
/// reflection in a tube, which moves with the camera, is distinguished from a leak because it
/// appears farther away than the tube: the more accurate the range, the better.
enum class RangeSource : std::uint8_t {
  kNone,      ///< none: a leak has no position until the robot's motion determines the range to
              ///< `max_range_deviation`
  kDistance,  ///< the distance of the pipes before the camera, along its axis
  kDiameter,  ///< the diameter of the pipes and their width in the image; pipes cut lengthwise by
              ///< the image border are not used
  kLine,      ///< position of the pipes in the map; detections on none of them are ignored
};
inline constexpr std::array kRangeSources{RangeSource::kNone, RangeSource::kDistance,
                                          RangeSource::kDiameter, RangeSource::kLine};
/// "none", "distance", "diameter", "lines"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(RangeSource source) noexcept;
/// Nothing for an unknown name.
[[nodiscard]] std::optional<RangeSource> range_source(std::string_view name) noexcept;

/// The axis of a straight pipe in the map.
struct PipeLine {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::UnitX();
  /// m, >= 0. Above 0, the pipe is one of a rack: a leak is where the ray meets its surface, and
  /// else on its axis; and how warm a sound pipe is in other images, it says of no other pipe, so
  /// that a pipe that leaks over its whole visible length is not detected.
  double radius = 0;
};

struct LeakFindingsParameters {
  geometry::SE3 T_base_camera{};  ///< for frames without their own

  /// rad per axis and m, >= 0: standard deviations of the constant error of `T_base_camera`.
  double mounting_attitude_deviation = 0.005;
  double mounting_position_deviation = 0.02;

  RangeSource range_source = RangeSource::kNone;
  double distance = 10.0;           ///< m, > 0, of `kDistance`
  double distance_deviation = 1.0;  ///< m, > 0: standard
  double pipe_diameter = 0.12;      ///< m, > 0, of `kDiameter`
  /// share of the diameter, (0, 1): standard deviation of the width between visible edges; 1.4
  /// pixels more where they are not visible
  double width_deviation = 0.05;
  std::vector<PipeLine> lines{};     ///< of `kLine`, at least one
  double line_deviation = 0.05;      ///< m, > 0: standard deviation across
  double max_range_deviation = 1.0;  ///< m, > 0, of `kNone`

  /// Pixels, > 0: standard deviation of the middle of a leak that is completely visible.
  double pixel_deviation = 1.5;
  /// rad and m, >= 0: standard deviations of the white noise of orientation and position, in
  /// addition to the slowly varying error in the covariance of the pose.
  double attitude_jitter = 0.002;
  double position_jitter = 0.02;
  /// s, > 0: correlation time of the errors of the pose, which do not average out within it.
  double pose_correlation_time = 30.0;
  /// m, >= 0: standard deviation of the middle of the warm section relative to the leak.
  double extent_deviation = 0.03;
  /// m, > 0: standard deviation of the middle of a leak relative to its visible part while one end
  /// has not been in view.
  double hidden_length_deviation = 1.0;
  /// K, >= 0: standard deviation of the common error of temperature differences, for detections
  /// without `delta_deviation`.
  double delta_deviation = 3.0;

  double prior_probability = 0.02;     ///< in (0, 1): of a leak before any observation
  double detection_probability = 0.9;  ///< in (0, 1): of detecting a leak in view
  /// in (0, detection_probability): of a repeated false detection at the same position
  double clutter_probability = 0.1;
  double raise_probability = 0.9;   ///< in (prior_probability, 1)
  double clear_probability = 0.1;   ///< in (0, raise_probability)
  double gate = 3.5;                ///< > 0, standard deviations: gate of the data association
  double extent_slack = 0.3;        ///< m, >= 0: largest distance between parts of one leak
  double pass_gap = 20.0;           ///< s, > 0, without detection, after which another pass begins
  double update_interval = 1.0;     ///< s, >= 0: between updates of one finding
  std::size_t max_candidates = 64;  ///< >= 1; the least probable ones are dropped
  std::size_t max_findings = 4096;  ///< >= 1; further ones are not raised, but counted
  std::size_t max_passes = 64;      ///< >= 2, that a finding keeps

  thermal::SeverityScale severity{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct FramePose {
  geometry::SE3 T_map_base{};
  /// [translation; rotation], both about the axes of the map (left), as nav_msgs/Odometry.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

struct Frame {
  double time = 0;           ///< s
  std::uint64_t number = 0;  ///< given by the caller, for `BestView`
  std::optional<FramePose> pose{};
  std::optional<geometry::SE3> T_base_camera{};  ///< of a camera on an arm
};

/// Faults of a frame.
enum class InputFault : std::uint8_t {
  kNone,
  kBadTime,        ///< NaN, or not after the previous frame: the frame is ignored
  kNoDetections,   ///< `Detections::fault`: the frame is ignored
  kBadSize,        ///< the image size differs from the camera's: the frame is ignored
  kNoPose,         ///< leaks are tracked in the image only
  kBadPose,        ///< NaN or infinity in the pose or its covariance: treated as no pose
  kBadCovariance,  ///< not symmetric or not positive: treated as no pose
};
inline constexpr std::size_t kInputFaults = 7;
/// "none", "bad_time", ...; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(InputFault fault) noexcept;

struct Event {
  EventKind kind = EventKind::kRaised;
  std::uint64_t finding = 0;  ///< id
};

struct FrameResult {
  InputFault fault = InputFault::kNone;
  std::vector<Event> events;
  /// For each leak detection of the frame, the id of its finding; 0: none yet.
  std::vector<std::uint64_t> finding_of;
};

/// Tracks leaks from frame to frame, in the image and, with poses, in the map. The log-odds of a
/// leak accumulate: an expected detection increases them, a missed detection decreases them, and a
/// leak that is hidden or out of view keeps them. A detection that is not fixed in the map, such as
/// a reflection in a tube, is not associated with the leak. A leak detected only in frames without
/// a pose, between others with one, waits up to a second for a position before it is raised,
/// because it may be a known one. Not thread-safe. Allocates when a leak is new or raised; not
/// while it is tracked.
class LeakFindings {
 public:
  /// Throws as LeakFindingsParameters::validate.
  LeakFindings(const LeakFindingsParameters& parameters, const geometry::Camera& camera);
  ~LeakFindings();
  LeakFindings(LeakFindings&& other) noexcept;
  LeakFindings& operator=(LeakFindings&& other) noexcept;

  /// Loads findings of other days, except candidates. Returns the number of loaded findings: those
  /// with a known id, id 0, or values that are not finite are refused.
  std::size_t restore(std::span<const Finding> findings);

  /// The pipes of `kLine` from now on, in the same order. Throws std::invalid_argument when they
  /// are not as many as before, and as LeakFindingsParameters::validate.
  void set_lines(std::span<const PipeLine> lines);

  /// The result stays valid until the next call.
  const FrameResult& update(const Frame& frame, const thermal::Detections& detections);

  /// Raised and cleared findings, by id.
  [[nodiscard]] std::span<const Finding> findings() const noexcept;
  /// Nothing for an unknown id.
  [[nodiscard]] const Finding* find(std::uint64_t id) const noexcept;
  /// The candidates with their estimates; their ids are 0.
  [[nodiscard]] std::vector<Finding> candidates() const;

  /// Input of the detector for a frame, before `update` with its detections: the size of a pixel at
  /// the pipes, if `range_source` gives it (with a diameter the detector computes it per pipe:
  /// `thermal::LeakDetectorParameters::pipe_diameter`), and the temperature of the sound pipes of
  /// this pass, with which a leak over the whole visible length is detected. In a rack, that is
  /// when all lines have a radius, and with a pose: where each pipe is in the image. Only the pose
  /// and the time of `frame` are used.
  [[nodiscard]] thermal::FrameConditions conditions(const Frame& frame) const;

  struct Counters {
    std::size_t frames = 0;
    std::array<std::size_t, kInputFaults> faults{};  ///< by `InputFault`
    std::size_t off_lines = 0;                       ///< detections on none of the known pipes
    std::size_t candidates_dropped = 0;              ///< for lack of evidence, or of space
    std::size_t findings_refused = 0;                ///< for lack of space
  };
  [[nodiscard]] const Counters& counters() const noexcept;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::leak_findings
