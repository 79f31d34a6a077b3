// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Parameters of the integration of IMU samples. Not checked.
struct ImuIntegration {
  ImuNoise noise{};
  /// Process noise of velocity and rotation (random walks) while samples are missing.
  ImuNoise coasting{};
  double coasting_turn = 0;  ///< rad/s/sqrt(Hz), the same about the vertical, in addition
  double max_held = 0;       ///< s, for which a sample replaces missing ones after it
  double gravity = 9.81;     ///< m/s^2
  Eigen::Vector3d map_rate = Eigen::Vector3d::Zero();  ///< rad/s, see Earth::rate
  /// While samples are missing, a turn about the vertical goes on: at this rate (rad/s) at this
  /// time (s), then falling with this time constant (s, above 0).
  double turning = 0;
  double turning_time = 0;
  double turning_ends = 1;
};

/// Ring buffer of the newest samples of an IMU, in order and without overlap. Nothing allocates
/// after construction. Frames and units as in ImuSample.
class ImuTimeline {
 public:
  /// Capacity for `capacity` samples, at least 1; not checked.
  explicit ImuTimeline(std::size_t capacity) : samples_(capacity) {}

  void clear() noexcept {
    count_ = 0;
    usual_ = std::numeric_limits<double>::infinity();
    rate_steps_.setZero();
    force_steps_.setZero();
  }
  /// Not checked: begins at or after the end of the newest.
  void push(const ImuSample& sample) noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  /// s, of the newest sample, which must exist; not checked.
  [[nodiscard]] double end() const noexcept { return end_of(at(count_ - 1)); }
  [[nodiscard]] const ImuSample& newest() const noexcept { return at(count_ - 1); }

  /// Calls visit(sample or null, duration) for each interval from `begin` to `end`, in order. A
  /// sample is held for `hold` seconds if the next ones are missing; null: no sample.
  template <class Visit>
  void walk(double begin, double end, double hold, Visit&& visit) const;

  /// Integrates from `begin` to `end` onto `sum`, which began at the attitude `R_map_body`. Returns
  /// the time without IMU samples, s.
  double integrate(const ImuIntegration& how, const geometry::SO3& R_map_body, double begin,
                   double end, ImuPreintegration& sum) const;

 private:
  [[nodiscard]] static double end_of(const ImuSample& s) noexcept { return s.time + s.duration; }
  [[nodiscard]] const ImuSample& at(std::size_t i) const noexcept {
    return samples_[(first_ + i) % samples_.size()];
  }
  [[nodiscard]] std::size_t first_ending_after(double time) const noexcept;

  /// The noise during a sample, which may stand for others that are missing too.
  [[nodiscard]] ImuNoise noise_of(const ImuSample& sample, const ImuNoise& usual) const noexcept;

  std::vector<ImuSample> samples_;
  double usual_ = std::numeric_limits<double>::infinity();  // s, duration of a sample
  // Mean squares per axis of the steps from one sample of that duration to the next.
  Eigen::Vector3d rate_steps_ = Eigen::Vector3d::Zero();   // (rad/s)^2
  Eigen::Vector3d force_steps_ = Eigen::Vector3d::Zero();  // (m/s^2)^2
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

template <class Visit>
void ImuTimeline::walk(double begin, double end, double hold, Visit&& visit) const {
  constexpr double kNothing = 1e-6;  // s; seconds since 1970 are rounded to 2e-7
  const auto step = [&](const ImuSample* sample, double until) {
    if (until - begin > kNothing) {
      visit(sample, until - begin);
      begin = until;
    }
  };
  std::size_t i = first_ending_after(begin);
  const ImuSample* before = i > 0 ? &at(i - 1) : nullptr;
  for (; end - begin > kNothing; ++i) {
    const ImuSample* const sample = i < count_ ? &at(i) : nullptr;
    const double next = sample != nullptr ? std::min(sample->time, end) : end;
    if (before != nullptr) {
      step(before, std::min(next, end_of(*before) + hold));
    }
    step(nullptr, next);
    if (sample == nullptr) {
      break;
    }
    step(sample, std::min(end_of(*sample), end));
    before = sample;
  }
}

}  // namespace pipescout::estimation
