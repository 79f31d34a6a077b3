// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {

/// The pipe as it is expected to be: welds 0..joints(), joint j between welds j and j + 1.
class JointChain {
 public:
  /// Throws std::invalid_argument naming the joint and its field.
  explicit JointChain(std::span<const TallyJoint> tally);
  JointChain(const TallyJoint& standard, std::size_t count);

  [[nodiscard]] int joints() const { return static_cast<int>(weld_.size()) - 1; }
  /// m, from weld 0.
  [[nodiscard]] double weld(int index) const { return weld_[static_cast<std::size_t>(index)]; }
  /// m^2, of the distance between two welds.
  [[nodiscard]] double variance_between(int a, int b) const;
  [[nodiscard]] double mean_length() const { return mean_length_; }
  /// m^2, how much the lengths differ.
  [[nodiscard]] double length_variance() const { return length_variance_; }
  /// The joint that holds a place given from weld `anchor`; the first or last for one beyond.
  /// Looks from the anchor on: takes as many steps as there are welds between.
  [[nodiscard]] int joint_at(int anchor, double offset) const;

 private:
  std::vector<double> weld_;
  std::vector<double> variance_;  // of weld_ to weld 0
  double mean_length_ = 0.0;
  double length_variance_ = 0.0;
};

}  // namespace pipescout::odometry
