// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/row_motion.hpp"

#include "pose_belief.hpp"

namespace pipescout::rack_vision {

geometry::SE3 RowMotion::pose_at(const geometry::SE3& T_rack_camera, double row) const {
  return moved_pose(T_rack_camera, instant(row) * velocity);
}

}  // namespace pipescout::rack_vision
