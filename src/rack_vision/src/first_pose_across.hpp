// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "first_pose_evidence.hpp"
#include "first_pose_profile.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/so3.hpp"
#include "pipescout/rack_vision/first_pose.hpp"

/// Place and roll of a camera seen along the pipes: in that plane pipes are
/// circles and contours their tangents, and the image is a profile of evidence
/// over bearings.
namespace pipescout::rack_vision::internal {

/// A section of a pipe along the flow, cut across.
struct PipeCircle {
  Eigen::Vector2d centre;  ///< rack x and z, m
  double radius = 0;       ///< m
  std::size_t rank = 0;    ///< of its pipe from left to right
};

/// Circles of the pipes along the flow, by rank; a reducer as what it is
/// halfway. Throws std::invalid_argument when there are fewer than two such
/// pipes.
[[nodiscard]] std::vector<PipeCircle> pipe_circles(const RackOutline& rack);

/// Where the camera may be, rack frame, m and rad.
struct AcrossLimits {
  double x_low = 0, x_high = 0, z_low = 0, z_high = 0;
  double largest_roll = 0;  ///< about the flow, against the camera looking straight down
  double typical_roll = 1;  ///< standard deviation
};

struct AcrossPose {
  double x = 0, z = 0;  ///< of the camera, rack frame, m
  double roll = 0;      ///< R_camera_rack = R_nominal about_y(roll)
  double value = 0;     ///< nats of evidence, with what the hint says
};

/// R_camera_rack of a camera that sees the flow in this direction (camera
/// frame, unit) and has no roll about it.
[[nodiscard]] geometry::SO3 nominal_rotation(const Eigen::Vector3d& flow);

/// Logarithm of the hint's density at a place, nats; 0 at its middle, and for
/// parts that are missing.
[[nodiscard]] double log_prior(const std::optional<FirstPoseHint::Value>& hint, double value);

/// What the image between the contours of the pipes says for a pose, nats.
[[nodiscard]] double evidence_on_pipes(const LineProfile& profile,
                                       std::span<const PipeCircle> circles, const AcrossPose& pose);

/// The poses within the limits that explain the profile best, at most `most`
/// that differ, best first: a grid over place and roll, whose best cells are
/// divided three times.
[[nodiscard]] std::vector<AcrossPose> search_across(const LineProfile& profile,
                                                    std::span<const PipeCircle> circles,
                                                    const geometry::Camera& camera,
                                                    const AcrossLimits& limits,
                                                    const FirstPoseHint& hint, std::size_t most);

}  // namespace pipescout::rack_vision::internal
