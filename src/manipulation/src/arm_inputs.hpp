// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "pipe_plane.hpp"
#include "pipescout/manipulation/arm_controller.hpp"
#include "rotation_history.hpp"

namespace pipescout::manipulation::internal {

/// What has come in and was taken, and the pipe that follows from it. `rest`: the map when the
/// motion of the vehicle is made up for, otherwise the base.
class ArmInputs {
 public:
  explicit ArmInputs(const ArmControllerParameters& parameters);

  void set_camera(const geometry::Camera& camera);
  InputVerdict observe(const ArmModel& model, const JointReadings& readings, double now);
  InputVerdict observe(const PipeSection& section, double now);
  InputVerdict observe(const VehicleMotion& motion, double now);
  void forget() noexcept;  ///< all but camera and counts
  void forget_pipe() noexcept;

  [[nodiscard]] const std::optional<geometry::Camera>& camera() const noexcept { return camera_; }
  [[nodiscard]] bool joints_known() const noexcept { return joints_time_.has_value(); }
  [[nodiscard]] const JointVector& joints() const noexcept { return joints_; }
  /// s, of `joints`; only when known.
  [[nodiscard]] double joints_time() const noexcept { return joints_time_.value_or(0); }
  /// Whether a joint, by its index in the arm, was in any message.
  [[nodiscard]] bool joint_seen(std::size_t joint) const { return latest_.at(joint).has_value(); }
  [[nodiscard]] bool joints_fresh(double now) const noexcept;
  [[nodiscard]] bool motion_fresh(double now) const noexcept;
  [[nodiscard]] bool section_fresh(double now) const noexcept;
  [[nodiscard]] TrackState track() const noexcept { return track_; }
  [[nodiscard]] const VehicleMotion& motion() const noexcept { return motion_; }
  /// At a time, s; nothing when it is not known.
  [[nodiscard]] std::optional<geometry::SO3> R_rest_base(double time) const;
  [[nodiscard]] PipePlane& plane() noexcept { return plane_; }
  [[nodiscard]] const PipePlane& plane() const noexcept { return plane_; }
  /// Of the last image in which the pipe was seen.
  [[nodiscard]] const SectionView& view() const noexcept { return view_; }

  ArmController::Counts joint_counts{};
  ArmController::Counts section_counts{};
  ArmController::Counts motion_counts{};

 private:
  InputVerdict take(const ArmModel& model, const JointReadings& readings, double now);
  InputVerdict take(const PipeSection& section, double now);
  InputVerdict take(const VehicleMotion& motion, double now);
  void add_reading(std::size_t joint, double time, double position, bool is_continuous);
  /// All joints at the time up to which all are known, each between its last two readings.
  InputVerdict merge(const ArmModel& model);
  /// Of a stamp, by the age that is stale and the last one that was taken.
  [[nodiscard]] InputVerdict judge_time(double time, double now, double stale_after,
                                        const std::optional<double>& last) const noexcept;

  ArmControllerParameters parameters_;
  std::optional<geometry::Camera> camera_;
  struct JointReading {
    double time;      // s
    double position;  // rad
  };
  std::array<std::optional<JointReading>, kMostJoints> before_;
  std::array<std::optional<JointReading>, kMostJoints> latest_;
  std::optional<double> joints_time_;
  JointVector joints_{};
  RotationHistory R_base_camera_;
  std::optional<double> motion_time_;
  VehicleMotion motion_;
  RotationHistory R_map_base_;
  std::optional<double> section_time_;
  TrackState track_ = TrackState::kNone;
  // s, of the last image in which it was seen.
  double seen_ = -std::numeric_limits<double>::infinity();
  SectionView view_;
  PipePlane plane_;
};

}  // namespace pipescout::manipulation::internal
