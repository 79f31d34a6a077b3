// SPDX-License-Identifier: Apache-2.0
#include "joint_chain.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {

using validation::refuse;

JointChain::JointChain(std::span<const TallyJoint> tally) {
  weld_.reserve(tally.size() + 1);
  variance_.reserve(tally.size() + 1);
  weld_.push_back(0.0);
  variance_.push_back(0.0);
  for (std::size_t j = 0; j < tally.size(); ++j) {
    const auto& [length, sigma] = tally[j];
    if (!std::isfinite(length) || length <= 0.0) {
      refuse("tally[", j, "].length: ", length, " is outside (0, inf)");
    }
    if (!std::isfinite(sigma) || sigma < 0.0) {
      refuse("tally[", j, "].standard_deviation: ", sigma, " is outside [0, inf)");
    }
    weld_.push_back(weld_.back() + length);
    variance_.push_back(variance_.back() + sigma * sigma);
  }
  const auto count = static_cast<double>(tally.size());
  mean_length_ = weld_.back() / count;
  for (const auto& [length, sigma] : tally) {
    length_variance_ += ((length - mean_length_) * (length - mean_length_) + sigma * sigma) / count;
  }
}

JointChain::JointChain(const TallyJoint& standard, std::size_t count)
    : JointChain(std::vector<TallyJoint>(count, standard)) {}

double JointChain::variance_between(int a, int b) const {
  return std::abs(variance_[static_cast<std::size_t>(a)] - variance_[static_cast<std::size_t>(b)]);
}

int JointChain::joint_at(int anchor, double offset) const {
  const double place = weld(anchor) + offset;
  int joint = std::min(anchor, joints() - 1);
  while (joint + 1 < joints() && place >= weld(joint + 1)) {
    ++joint;
  }
  while (joint > 0 && place < weld(joint)) {
    --joint;
  }
  return joint;
}

}  // namespace pipescout::odometry
