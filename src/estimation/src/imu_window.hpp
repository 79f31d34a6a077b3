// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Sums over IMU samples: their means and how much they vary.
struct ImuSums {
  std::size_t count = 0;
  double duration = 0;  // s
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_squares = Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_squares = Eigen::Vector3d::Zero();

  void add(const ImuSample& sample) noexcept {
    ++count;
    duration += sample.duration;
    rate += sample.angular_rate;
    rate_squares += sample.angular_rate.cwiseAbs2();
    force += sample.specific_force;
    force_squares += sample.specific_force.cwiseAbs2();
  }
  void add(const ImuSums& other) noexcept {
    count += other.count;
    duration += other.duration;
    rate += other.rate;
    rate_squares += other.rate_squares;
    force += other.force;
    force_squares += other.force_squares;
  }
  // Of at least one sample; deviations are those of the worst axis.
  [[nodiscard]] Eigen::Vector3d mean_rate() const noexcept { return rate / number(); }
  [[nodiscard]] Eigen::Vector3d mean_force() const noexcept { return force / number(); }
  [[nodiscard]] double rate_deviation() const noexcept { return deviation(rate, rate_squares); }
  [[nodiscard]] double force_deviation() const noexcept { return deviation(force, force_squares); }

 private:
  [[nodiscard]] double number() const noexcept { return static_cast<double>(count); }
  [[nodiscard]] double deviation(const Eigen::Vector3d& sum,
                                 const Eigen::Vector3d& squares) const noexcept {
    const Eigen::Vector3d mean = sum / number();
    return std::sqrt(std::max((squares / number() - mean.cwiseAbs2()).maxCoeff(), 0.0));
  }
};

/// ImuSums over the last so many keyframe intervals.
class ImuWindow {
 public:
  explicit ImuWindow(std::size_t intervals) : ring_(intervals) {}

  void add(const ImuSample& sample) noexcept { ring_[newest_].add(sample); }
  void next_interval() noexcept {
    newest_ = (newest_ + 1) % ring_.size();
    ring_[newest_] = {};
  }
  void forget() noexcept { std::fill(ring_.begin(), ring_.end(), ImuSums{}); }
  [[nodiscard]] ImuSums sums() const noexcept {
    ImuSums all;
    for (const ImuSums& one : ring_) {
      all.add(one);
    }
    return all;
  }

 private:
  std::vector<ImuSums> ring_;
  std::size_t newest_ = 0;
};

}  // namespace pipescout::estimation
