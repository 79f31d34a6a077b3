// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "pipescout/estimation/state.hpp"

namespace pipescout::estimation {

/// The `odom` frame: level as the map, turned about its z axis and moved by what estimates have
/// been corrected by, so that a body in it moves by its own motion alone.
class OdomFrame {
 public:
  /// `records`: keyframes that are remembered, at least 2.
  explicit OdomFrame(std::size_t records) : records_(records) {}

  /// What was `from` in the map, at one time, turns out to be `to`.
  void correct(const NavState& from, const NavState& to) noexcept;

  /// Without what is still to be made up for.
  [[nodiscard]] geometry::SE3 plain(const NavState& state) const noexcept;
  /// Continuous.
  [[nodiscard]] geometry::SE3 smooth(double time, const NavState& state) const noexcept;
  /// From now on smooth(time, state) is `pose`, and becomes plain(state) within some tenths of a
  /// second.
  void make_up(double time, const NavState& state, const geometry::SE3& pose) noexcept;

  /// A keyframe, in order of time.
  void record(double time, const NavState& state, bool standing_still) noexcept;
  void forget_records() noexcept { count_ = 0; }
  /// As constructed.
  void forget() noexcept {
    count_ = 0;
    yaw_ = way_ = 0;
    offset_.setZero();
  }

  /// s, of the oldest record; infinite without one.
  [[nodiscard]] double begins() const noexcept {
    return count_ > 0 ? record_at(0).time : std::numeric_limits<double>::infinity();
  }

  struct Place {
    geometry::SE3 T_odom_body{};
    double way = 0;  // m travelled
  };
  /// Where the body was, between keyframes or shortly after the newest. There must be a record.
  [[nodiscard]] Place at(double time) const noexcept;
  /// Yaw and offset: map = Rz(yaw) odom + offset.
  [[nodiscard]] double yaw() const noexcept { return yaw_; }
  [[nodiscard]] const Eigen::Vector3d& offset() const noexcept { return offset_; }
  [[nodiscard]] double way() const noexcept { return way_; }

 private:
  struct Record {
    double time = 0;
    geometry::SE3 T_odom_body{};
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // in odom
    double way = 0;
  };
  [[nodiscard]] const Record& newest() const noexcept { return record_at(count_ - 1); }
  [[nodiscard]] const Record& record_at(std::size_t i) const noexcept {
    return records_[(first_ + i) % records_.size()];
  }

  double yaw_ = 0;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  double way_ = 0;
  double debt_time_ = 0;
  Eigen::Vector3d position_debt_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_debt_ = Eigen::Vector3d::Zero();
  std::vector<Record> records_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace pipescout::estimation
