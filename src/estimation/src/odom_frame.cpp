// SPDX-License-Identifier: Apache-2.0
#include "odom_frame.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {

using geometry::SE3;
using geometry::SO3;

void OdomFrame::correct(const NavState& from, const NavState& to) noexcept {
  const Eigen::Vector3d in_odom = plain(from).translation();
  const Eigen::Matrix3d turn = (to.R_map_body * from.R_map_body.inverse()).matrix();
  // The rotation about z that is nearest to it.
  yaw_ += std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
  offset_ = to.position - SO3::about_z(yaw_) * in_odom;
}

SE3 OdomFrame::plain(const NavState& state) const noexcept {
  const SO3 turn = SO3::about_z(-yaw_);
  return {turn * state.R_map_body, turn * (state.position - offset_)};
}

SE3 OdomFrame::smooth(double time, const NavState& state) const noexcept {
  constexpr double kSettling = 0.3;  // s
  const SE3 there = plain(state);
  const double left = std::exp(-std::max(time - debt_time_, 0.0) / kSettling);
  return {there.rotation() * SO3::exp(left * rotation_debt_),
          there.translation() + left * position_debt_};
}

void OdomFrame::make_up(double time, const NavState& state, const SE3& pose) noexcept {
  const SE3 there = plain(state);
  debt_time_ = time;
  position_debt_ = pose.translation() - there.translation();
  rotation_debt_ = (there.rotation().inverse() * pose.rotation()).log();
}

void OdomFrame::record(double time, const NavState& state, bool standing_still) noexcept {
  const SE3 pose = plain(state);
  if (count_ > 0 && !standing_still) {
    way_ += (pose.translation() - newest().T_odom_body.translation()).norm();
  }
  if (count_ == records_.size()) {
    first_ = (first_ + 1) % records_.size();
    --count_;
  }
  records_[(first_ + count_) % records_.size()] = {time, pose, SO3::about_z(-yaw_) * state.velocity,
                                                   way_};
  ++count_;
}

OdomFrame::Place OdomFrame::at(double time) const noexcept {
  if (time >= newest().time) {
    const Record& last = newest();
    const Eigen::Vector3d moved = (time - last.time) * last.velocity;
    return {SE3(last.T_odom_body.rotation(), last.T_odom_body.translation() + moved),
            last.way + moved.norm()};
  }
  std::size_t after = count_ - 1;
  while (after > 1 && record_at(after - 1).time > time) {
    --after;
  }
  if (after == 0) {
    return {newest().T_odom_body, newest().way};
  }
  const Record& a = record_at(after - 1);
  const Record& b = record_at(after);
  const double part = std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
  const SO3 turn =
      SO3::exp(part * (a.T_odom_body.rotation().inverse() * b.T_odom_body.rotation()).log());
  return {SE3(a.T_odom_body.rotation() * turn,
              (1 - part) * a.T_odom_body.translation() + part * b.T_odom_body.translation()),
          (1 - part) * a.way + part * b.way};
}

}  // namespace pipescout::estimation
