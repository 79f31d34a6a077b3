// SPDX-License-Identifier: Apache-2.0
#include "imu_timeline.hpp"

namespace pipescout::estimation {

void ImuTimeline::push(const ImuSample& sample) noexcept {
  if (count_ == samples_.size()) {
    first_ = (first_ + 1) % samples_.size();
    --count_;
  }
  samples_[(first_ + count_) % samples_.size()] = sample;
  ++count_;
}

std::size_t ImuTimeline::first_ending_after(double time) const noexcept {
  std::size_t low = 0;
  std::size_t high = count_;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (end_of(at(middle)) > time) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

}  // namespace pipescout::estimation
