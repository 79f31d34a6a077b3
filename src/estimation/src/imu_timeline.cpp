// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/imu_timeline.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

constexpr double kMissing = 1.5;  // times the usual duration of a sample: some are missing

}  // namespace

void ImuTimeline::push(const ImuSample& sample) noexcept {
  constexpr double kRising = 1e-3;  // of the usual duration, for each sample that is longer
  usual_ = std::min(sample.duration, (1 + kRising) * usual_);
  if (count_ > 0 && sample.duration < kMissing * usual_ && newest().duration < kMissing * usual_) {
    constexpr double kLearning = 0.01;
    const Eigen::Vector3d rate = sample.angular_rate - newest().angular_rate;
    const Eigen::Vector3d force = sample.specific_force - newest().specific_force;
    rate_steps_ += kLearning * (rate.cwiseAbs2() - rate_steps_);
    force_steps_ += kLearning * (force.cwiseAbs2() - force_steps_);
  }
  if (count_ == samples_.size()) {
    first_ = (first_ + 1) % samples_.size();
    --count_;
  }
  samples_[(first_ + count_) % samples_.size()] = sample;
  ++count_;
}

ImuNoise ImuTimeline::noise_of(const ImuSample& sample, const ImuNoise& usual) const noexcept {
  if (!(sample.duration > kMissing * usual_)) {
    return usual;
  }
  // White noise of one reading lasts as long as the reading is used. The motion meanwhile is taken
  // for a straight line between both ends; as a random walk, which goes on by twice the square of
  // the steps of means of two readings, it is off by an integral of variance q d^3 / 12.
  const double longer = sample.duration / usual_;
  const double bridged = sample.duration * longer / 6;
  ImuNoise noise = usual;
  noise.gyro = std::sqrt(longer * usual.gyro * usual.gyro + bridged * rate_steps_.maxCoeff());
  noise.accelerometer = std::sqrt(longer * usual.accelerometer * usual.accelerometer +
                                  bridged * force_steps_.maxCoeff());
  return noise;
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
  double time = begin;
  walk(begin, end, how.max_held, [&](const ImuSample* sample, double duration) {
    const double middle = time + 0.5 * duration;
    time += duration;
    if (sample != nullptr) {
      const ImuNoise noise = noise_of(*sample, how.noise);
      if (how.map_rate.isZero(0)) {
        sum.integrate(sample->angular_rate, sample->specific_force, duration, noise);
      } else {
        // The gyro turns with the map too.
        const Eigen::Vector3d of_map =
            (R_map_body * sum.motion().rotation()).inverse() * how.map_rate;
        sum.integrate(sample->angular_rate - of_map, sample->specific_force, duration, noise);
      }
      return;
    }
    // As an IMU would measure a body that keeps its velocity and turns as before.
    const ImuMotion& motion = sum.motion();
    const Eigen::Vector3d up =
        (R_map_body * motion.rotation()).inverse() * Eigen::Vector3d::UnitZ();
    const double turning =
        how.turning * std::exp(-std::max(middle - how.turning_time, 0.0) / how.turning_ends);
    sum.integrate(motion.gyro_bias() + turning * up, motion.accelerometer_bias() + how.gravity * up,
                  duration, how.coasting);
    if (how.coasting_turn > 0) {
      sum.add_turn_noise(up, how.coasting_turn, duration);
    }
    coasted += duration;
  });
  return coasted;
}

}  // namespace pipescout::estimation
