// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/simulation/rack_features.hpp"

/// Runs of the pose solver on features, frame by frame.
namespace pipescout::rack_study {

struct PoseRunSettings {
  rack_vision::PoseSolverParameters solver{};
  simulation::RackFeatureParameters camera{};
  std::size_t points = 0;  ///< texture points over the whole rack
  /// They lie at most so far from the uppermost line of their pipe, rad: a camera above the rack
  /// has found them before.
  double points_within = 1.5707963267948966;
  /// Of a measurement of the camera's place along the pipes, m, drawn anew for each frame with this
  /// standard deviation and given to the solver and to the bound alike. 0: there is none. Frames in
  /// which no point is seen have nothing else to tell them where along the pipes they are.
  double along_deviation = 0;
  bool with_bound = false;  ///< computes the Cramer-Rao bound too
};

/// Root mean squares and means of the norms of the errors over frames.
struct PoseErrors {
  std::size_t frames = 0;
  double position_square = 0;     ///< m^2, summed
  double orientation_square = 0;  ///< rad^2, summed
  double position_norm = 0;       ///< m, summed
  double orientation_norm = 0;    ///< rad, summed
  double position_bound = 0;      ///< m^2, summed traces of the bound
  double orientation_bound = 0;   ///< rad^2
  double consistency = 0;  ///< sum of error^T covariance^-1 error: 6 per frame when it is true
  std::size_t not_ok = 0;  ///< frames whose status is neither kOk nor kUnobserved
  std::size_t without_points = 0;  ///< frames in which no texture point was seen

  PoseErrors& operator+=(const PoseErrors& other) noexcept;
  [[nodiscard]] double position_rms() const noexcept;  ///< m
  [[nodiscard]] double orientation_rms_degrees() const noexcept;
  [[nodiscard]] double position_mean() const noexcept;  ///< m
  [[nodiscard]] double orientation_mean_degrees() const noexcept;
  /// Root mean square error over that of the bound.
  [[nodiscard]] double position_ratio() const noexcept;
  [[nodiscard]] double orientation_ratio() const noexcept;
};

/// Place and rotation error, rack axes, in the form of the solver's covariance.
[[nodiscard]] geometry::Vector6d pose_error(const geometry::SE3& T_camera_rack,
                                            const geometry::SE3& truth);

/// One pose per frame from that frame's features alone. The estimate of the frame before (the truth
/// for the first) is where the search begins and has no other part. Pipes are where the model has
/// them. No frame is left out: one without a solution counts with the pose that it began with.
[[nodiscard]] PoseErrors run_poses(const rack_vision::RackModel& model,
                                   std::span<const geometry::SE3> flight,
                                   const PoseRunSettings& settings, std::uint64_t seed);

}  // namespace pipescout::rack_study
