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

/// What tells how far away the pipes are. Motion between frames adds to it, whatever it is. What is
/// mirrored in a tube and moves along with the camera is told from a leak by seeming to be farther
/// away than the tube: the better the range is known, the better.
enum class RangeSource : std::uint8_t {
  kNone,      ///< nothing: a leak has no position until the robot has moved enough, which is when
              ///< the range is known to `max_range_deviation`
  kDistance,  ///< the distance of the pipes before the camera, along its axis
  kDiameter,  ///< the diameter of the pipes, by how wide they look; what the border of the picture
              ///< cuts lengthwise counts for nothing
  kLine,      ///< where the pipes are in the map; what is on none of them is left out
};
inline constexpr std::array kRangeSources{RangeSource::kNone, RangeSource::kDistance,
                                          RangeSource::kDiameter, RangeSource::kLine};
/// "none", "distance", "diameter", "lines"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(RangeSource source) noexcept;
/// Nothing for a name that none has.
[[nodiscard]] std::optional<RangeSource> range_source(std::string_view name) noexcept;

/// The axis of a straight pipe in the map.
struct PipeLine {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::UnitX();
};

struct LeakFindingsParameters {
  geometry::SE3 T_base_camera{};  ///< where a frame does not tell its own

  /// rad per axis and m, >= 0, standard: how far `T_base_camera` may be off, the same all the time.
  double mounting_attitude_deviation = 0.005;
  double mounting_position_deviation = 0.02;

  RangeSource range_source = RangeSource::kNone;
  double distance = 10.0;            ///< m, > 0, of `kDistance`
  double distance_deviation = 1.0;   ///< m, > 0: standard
  double pipe_diameter = 0.12;       ///< m, > 0, of `kDiameter`
  double width_deviation = 0.05;     ///< share, (0, 1): how far the width between the edges that
                                     ///< are seen, over the diameter, may be off, standard; where
                                     ///< they are not, 1.4 pixels come to it
  std::vector<PipeLine> lines{};     ///< of `kLine`, at least one
  double line_deviation = 0.05;      ///< m, > 0: across, standard
  double max_range_deviation = 1.0;  ///< m, > 0, of `kNone`

  /// Pixels, > 0: how far the middle of a leak that is seen whole may be off, standard.
  double pixel_deviation = 1.5;
  /// rad and m, >= 0: how far orientation and position may be off from frame to frame, beside
  /// what changes slowly, which is what the covariance of the pose tells.
  double attitude_jitter = 0.002;
  double position_jitter = 0.02;
  /// s, > 0: of the errors of the pose; within it they do not average out.
  double pose_correlation_time = 30.0;
  /// m, >= 0: how far the middle of what is warm may be from the leak's, standard.
  double extent_deviation = 0.03;
  /// m, > 0: how far the middle of a leak may be from the middle of what was seen of it while an
  /// end has not been, standard.
  double hidden_length_deviation = 1.0;
  /// K, >= 0: how far differences of temperature may be off all alike, standard, where a detection
  /// does not tell: its `delta_deviation`.
  double delta_deviation = 3.0;

  double prior_probability = 0.02;     ///< in (0, 1): that it leaks where nothing was seen yet
  double detection_probability = 0.9;  ///< in (0, 1): of a leak that is in view
  double clutter_probability = 0.1;    ///< in (0, detection_probability): that what was warm and no
                                       ///< leak is so again, at its place
  double raise_probability = 0.9;      ///< in (prior_probability, 1)
  double clear_probability = 0.1;      ///< in (0, raise_probability)
  double gate = 3.5;                   ///< > 0, standard deviations, of what belongs together
  double extent_slack = 0.3;           ///< m, >= 0: of what parts of one leak may lie apart
  double pass_gap = 20.0;              ///< s, > 0, without being seen: then it is another pass
  double update_interval = 1.0;        ///< s, >= 0: between updates of one finding
  std::size_t max_candidates = 64;     ///< >= 1; the least probable give way
  std::size_t max_findings = 4096;     ///< >= 1; no further ones are raised: counted
  std::size_t max_passes = 64;         ///< >= 2, that a finding keeps

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
  std::uint64_t number = 0;  ///< of the caller's, for `BestView`
  std::optional<FramePose> pose{};
  std::optional<geometry::SE3> T_base_camera{};  ///< of a camera on an arm
};

/// What is wrong with a frame.
enum class InputFault : std::uint8_t {
  kNone,
  kBadTime,        ///< NaN, or not after the frame before: the frame is left out
  kNoDetections,   ///< `Detections::fault`: the frame is left out
  kBadSize,        ///< the picture has another size than the camera: the frame is left out
  kNoPose,         ///< leaks are followed in the picture only
  kBadPose,        ///< NaN or infinity in the pose or its covariance: as without
  kBadCovariance,  ///< not symmetric, or not positive: as without a pose
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
  /// Of each leak detection of the frame, the id of the finding that it belongs to; 0: of none yet.
  std::vector<std::uint64_t> finding_of;
};

/// Follows leaks from frame to frame, in the picture and, with poses, in the map. Evidence is
/// summed as the logarithm of odds: a detection where one was expected adds to them, a sound pipe
/// where a leak was expected takes off, one that is hidden or out of view changes nothing. A
/// detection that does not stay at one place of the map, as what a tube mirrors, is none of the
/// same leak. What is only seen in pictures without a pose, between others with one, waits up to a
/// second for its place before it is raised: it may be a leak that is known. Not thread-safe.
/// Allocates when something new is seen, or raised; not while it is followed.
class LeakFindings {
 public:
  /// Throws as LeakFindingsParameters::validate.
  LeakFindings(const LeakFindingsParameters& parameters, const geometry::Camera& camera);
  ~LeakFindings();
  LeakFindings(LeakFindings&& other) noexcept;
  LeakFindings& operator=(LeakFindings&& other) noexcept;

  /// Takes findings of other days in; those of state candidate are left out. Returns how many were
  /// taken: not those with an id that is known, or 0, or with numbers that are not finite.
  std::size_t restore(std::span<const Finding> findings);

  /// The result stays valid until the next call.
  const FrameResult& update(const Frame& frame, const thermal::Detections& detections);

  /// Raised ones and those that were, by id.
  [[nodiscard]] std::span<const Finding> findings() const noexcept;
  /// Nothing for an id that is not among them.
  [[nodiscard]] const Finding* find(std::uint64_t id) const noexcept;
  /// What there is evidence for, with what is known of it; the ids are 0.
  [[nodiscard]] std::vector<Finding> candidates() const;

  /// For the detector, before `update` with what it finds in that frame: how large a pixel is at
  /// the pipes, where `range_source` tells (by a diameter each pipe tells itself:
  /// `thermal::LeakDetectorParameters::pipe_diameter`), and how warm sound pipes of this pass were:
  /// so what leaks as far as one sees is noticed. Only the pose and the time of `frame` count.
  [[nodiscard]] thermal::FrameConditions conditions(const Frame& frame) const;

  struct Counters {
    std::size_t frames = 0;
    std::array<std::size_t, kInputFaults> faults{};  ///< by `InputFault`
    std::size_t off_lines = 0;                       ///< detections on none of the known pipes
    std::size_t candidates_dropped = 0;              ///< for lack of evidence, or of room
    std::size_t findings_refused = 0;                ///< for lack of room
  };
  [[nodiscard]] const Counters& counters() const noexcept;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::leak_findings
