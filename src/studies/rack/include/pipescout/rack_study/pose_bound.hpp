// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/simulation/rack_features.hpp"

namespace pipescout::rack_study {

/// Cramer-Rao bound: the smallest covariance that an unbiased estimate of the camera's pose from
/// these features can have when the pipes' places are known. Each edge sample counts across its
/// edge (where along the edge it lies says nothing), each point in u and v, with the sigmas that
/// the features state; `prior` is added information. Form of the result as that of PoseSolution:
/// place, rotation, rack axes.
///
/// Its derivatives are central differences of where the true edges and points are seen: nothing is
/// shared with the solver but where a contour is.
[[nodiscard]] geometry::Matrix6d pose_bound(const rack_vision::RackModel& model,
                                            const geometry::Camera& camera,
                                            const geometry::SE3& T_camera_rack,
                                            const simulation::RackFeatures& features,
                                            const geometry::Matrix6d& prior);

}  // namespace pipescout::rack_study
