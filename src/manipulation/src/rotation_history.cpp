// SPDX-License-Identifier: Apache-2.0
#include "rotation_history.hpp"

#include <algorithm>

namespace pipescout::manipulation::internal {

void RotationHistory::add(double time, const geometry::SO3& rotation, const Eigen::Vector3d& rate,
                          double spacing) {
  // The last one is always there, the ones before it are `spacing` apart.
  if (size_ >= 2 && back(0).time - back(1).time < spacing) {
    next_ = (next_ + kMost - 1) % kMost;
    --size_;
  }
  samples_[next_] = {.time = time, .rotation = rotation, .rate = rate};
  next_ = (next_ + 1) % kMost;
  size_ = std::min(size_ + 1, kMost);
}

std::optional<geometry::SO3> RotationHistory::at(double time) const {
  if (size_ == 0) {
    return std::nullopt;
  }
  const Sample& last = back(0);
  if (time >= last.time) {
    return last.rotation * geometry::SO3::exp((time - last.time) * last.rate);
  }
  for (std::size_t age = 1; age < size_; ++age) {
    const Sample& before = back(age);
    if (before.time <= time) {
      const Sample& after = back(age - 1);
      const double share = (time - before.time) / (after.time - before.time);
      return before.rotation *
             geometry::SO3::exp(share * (before.rotation.inverse() * after.rotation).log());
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::manipulation::internal
