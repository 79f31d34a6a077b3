// SPDX-License-Identifier: Apache-2.0
#include "view_change.hpp"

#include <algorithm>
#include <cmath>

#include "pose_belief.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kWay = 0.1;     // of the height: a camera that has gone so far has another view
constexpr double kTurn = 0.1;    // rad
constexpr double kSeconds = 20;  // light and shadows move
constexpr double kLeastHeight = 0.5;  // m

}  // namespace

void ViewChange::begin(const geometry::SE3& T_rack_camera, double stamp) {
  views_ = 0;
  take(T_rack_camera, stamp);
}

double ViewChange::see(const geometry::SE3& T_rack_camera, double stamp) {
  const geometry::Vector6d moved = pose_difference(from_, T_rack_camera);
  const double height = std::max(kLeastHeight, std::abs(T_rack_camera.translation().z()));
  const double unlike = moved.head<3>().norm() / (kWay * height) + moved.tail<3>().norm() / kTurn +
                        (stamp - since_) / kSeconds;
  const double share = std::max(0.0, std::min(1.0, unlike) - told_);
  told_ += share;
  views_ += share;
  if (told_ >= 1) {
    take(T_rack_camera, stamp);
  }
  return share;
}

void ViewChange::take(const geometry::SE3& T_rack_camera, double stamp) {
  from_ = T_rack_camera;
  since_ = stamp;
  told_ = 0;
}

}  // namespace pipescout::rack_vision
