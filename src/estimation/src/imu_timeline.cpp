// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/imu_timeline.hpp"

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

double ImuTimeline::integrate(const ImuIntegration& how, const geometry::SO3& R_map_body,
                              double begin, double end, ImuPreintegration& sum) const {
  double coasted = 0;
  walk(begin, end, how.max_held, [&](const ImuSample* sample, double duration) {
    if (sample != nullptr) {
      sum.integrate(sample->angular_rate, sample->specific_force, duration, how.noise);
      return;
    }
    // As an IMU would measure a body that neither turns nor changes its velocity.
    const ImuMotion& motion = sum.motion();
    sum.integrate(motion.gyro_bias(),
                  motion.accelerometer_bias() + (R_map_body * motion.rotation()).inverse() *
                                                    Eigen::Vector3d(0, 0, how.gravity),
                  duration, how.coasting);
    coasted += duration;
  });
  return coasted;
}

}  // namespace pipescout::estimation
