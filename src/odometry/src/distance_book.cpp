// SPDX-License-Identifier: Apache-2.0
#include "distance_book.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::internal {
namespace {

double squared(double value) {
  return value * value;
}

}  // namespace

DistanceBook::DistanceBook(const OdometerStreamParameters& parameters)
    : count_(parameters.odometers.size()),
      common_variance_(squared(parameters.common_sigma_per_sqrt_metre)),
      common_scale_variance_(squared(parameters.common_scale_sigma)) {
  for (std::size_t i = 0; i < count_; ++i) {
    accounts_[i] = {.correction = parameters.odometers[i].correction,
                    .counting_variance = squared(parameters.odometers[i].resolution) / 12.0};
  }
}

double DistanceBook::correction_deviation(const Account& account, double measured) {
  const auto& covariance = account.correction.covariance;
  const double variance = squared(measured) * covariance(0, 0) +
                          2.0 * measured * account.offsets * covariance(0, 1) +
                          squared(account.offsets) * covariance(1, 1);
  return std::copysign(std::sqrt(std::max(0.0, variance)), measured);
}

double DistanceBook::path_variance(const WindowSum& window) const {
  double variance = window.gap_variance;
  for (std::size_t i = 0; i < count_; ++i) {
    variance += squared(window.weight[i]) * window.random[i] +
                common_variance_ * window.weight[i] * window.path[i];
  }
  return variance;
}

double DistanceBook::distance(const WindowSum& window) const {
  return distance_ + window.distance;
}

double DistanceBook::random_variance(const WindowSum& window) const {
  double variance =
      path_variance_ + path_variance(window) + counting_variance_ + squared(bias_ + window.bias);
  for (std::size_t i = 0; i < count_; ++i) {
    const Account& account = accounts_[i];
    const double weight = window.weight[i];
    variance += account.counting_variance * (squared(weight - account.weight) + squared(weight));
  }
  return variance;
}

double DistanceBook::variance(const WindowSum& window) const {
  double variance = random_variance(window) + common_scale_variance_ * squared(distance(window));
  for (std::size_t i = 0; i < count_; ++i) {
    const Account& account = accounts_[i];
    const double raw = window.weight[i] * window.increment[i] / account.correction.scale;
    variance += squared(account.former + correction_deviation(account, account.measured + raw));
  }
  return variance;
}

void DistanceBook::commit(const WindowSum& window) {
  distance_ += window.distance;
  path_variance_ += path_variance(window);
  if (window.agreed && window.bias == 0.0) {
    path_variance_ += squared(bias_);
    bias_ = 0.0;
  } else {
    bias_ += window.bias;
  }
  for (std::size_t i = 0; i < count_; ++i) {
    Account& account = accounts_[i];
    const double weight = window.weight[i];
    counting_variance_ += account.counting_variance * squared(weight - account.weight);
    account.weight = weight;
    account.measured += weight * window.increment[i] / account.correction.scale;
    account.segment += weight * window.path[i];
  }
}

void DistanceBook::set_correction(std::size_t odometer, const OdometerCorrection& correction) {
  Account& account = accounts_[odometer];
  account.former += correction_deviation(account, account.measured);
  account.correction = correction;
  account.measured = 0.0;
  account.offsets = 0.0;
}

void DistanceBook::end_segment() {
  double total = 0.0;
  for (const auto& account : accounts()) {
    total += account.segment;
  }
  if (total == 0.0) {
    return;
  }
  for (auto& account : accounts()) {
    const double share = account.segment / total;
    distance_ += share * account.correction.offset;
    account.offsets += share;
    account.segment = 0.0;
  }
}

}  // namespace pipescout::odometry::internal
