// SPDX-License-Identifier: Apache-2.0
#include "odometry_peers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pipescout/odometry/consensus_fusion.hpp"

namespace pipescout::benchmarks {

double fuse_each_round(const WheelInput& input) {
  const odometry::ConsensusFusion fusion({});
  const std::size_t wheels = input.parameters.odometers.size();
  constexpr double kSigma = 0.056;  // m, the paper's
  std::vector<odometry::OdometerReading> readings(wheels,
                                                  {.distance = 0.0, .standard_deviation = kSigma});
  double sum = 0.0;
  for (const auto& sample : input.samples) {
    readings[sample.odometer].distance = sample.value;
    if (sample.odometer + 1 == wheels) {
      sum += fusion.fuse(readings).fused.distance;
    }
  }
  return sum;
}

DirectConvolution::DirectConvolution() {
  constexpr double kStep = 0.3 / 200.0;                        // m
  constexpr std::array kDistances{0.025, 0.034, 0.045, 0.06};  // m, between the lobes
  for (std::size_t w = 0; w < kWidths; ++w) {
    const double deviation = kDistances[w] / 3.0;
    for (std::size_t i = 0; i < kTaps; ++i) {
      const double x = kStep * (static_cast<double>(i) - 0.5 * kTaps);
      const auto bell = [&](double middle) {
        return std::exp(-0.5 * std::pow((x - middle) / deviation, 2));
      };
      kernels_[w][i] = bell(-0.5 * kDistances[w]) - bell(0.5 * kDistances[w]);
    }
  }
}

double DirectConvolution::next(std::complex<double> value) {
  latest_[next_] = value;
  next_ = (next_ + 1) % kTaps;
  double largest = 0.0;
  for (const auto& kernel : kernels_) {
    std::complex<double> sum;
    // Oldest first, in two pieces of the ring.
    const std::size_t old = kTaps - next_;
    for (std::size_t i = 0; i < old; ++i) {
      sum += kernel[i] * latest_[next_ + i];
    }
    for (std::size_t i = old; i < kTaps; ++i) {
      sum += kernel[i] * latest_[i - old];
    }
    largest = std::max(largest, std::norm(sum));
  }
  return largest;
}

FingerprintSearch::FingerprintSearch(std::span<const odometry::TallyJoint> tally) {
  for (const auto& joint : tally) {
    lengths_.push_back(joint.length);
  }
  reversed_.assign(lengths_.rbegin(), lengths_.rend());
}

std::size_t FingerprintSearch::add_joint(double length) {
  if (latest_.size() == kLatest) {
    latest_.erase(latest_.begin());
  }
  latest_.push_back(length);
  double least = std::numeric_limits<double>::infinity();
  std::size_t place = 0;
  for (const auto* lengths : {&lengths_, &reversed_}) {
    for (std::size_t i = 0; i + latest_.size() <= lengths->size(); ++i) {
      double sum = 0.0;
      for (std::size_t k = 0; k < latest_.size(); ++k) {
        const double off = (*lengths)[i + k] - latest_[k];
        sum += off * off;
      }
      if (sum < least) {
        least = sum;
        place = i + latest_.size();
      }
    }
  }
  return place;
}

std::size_t align_full_matrix(std::span<const odometry::WeldPosition> a,
                              std::span<const odometry::WeldPosition> b) {
  constexpr double kGap = 8.0;        // of half squared standard deviations
  constexpr double kVariance = 0.01;  // m^2, of the difference of two lengths
  enum class Step : std::uint8_t { kBoth, kOnlyA, kOnlyB };
  const auto joints = [](std::span<const odometry::WeldPosition> welds) {
    std::vector<double> lengths;
    for (std::size_t i = 1; i < welds.size(); ++i) {
      lengths.push_back(welds[i].chainage - welds[i - 1].chainage);
    }
    return lengths;
  };
  const auto lengths_a = joints(a);
  const auto lengths_b = joints(b);
  const std::size_t columns = lengths_b.size() + 1;
  std::vector<double> above(columns);
  std::vector<double> row(columns);
  std::vector<Step> steps((lengths_a.size() + 1) * columns, Step::kOnlyA);
  for (std::size_t j = 1; j < columns; ++j) {
    above[j] = kGap * static_cast<double>(j);
    steps[j] = Step::kOnlyB;
  }
  for (std::size_t i = 1; i <= lengths_a.size(); ++i) {
    row[0] = kGap * static_cast<double>(i);
    for (std::size_t j = 1; j < columns; ++j) {
      const double off = lengths_a[i - 1] - lengths_b[j - 1];
      const double both = above[j - 1] + 0.5 * off * off / kVariance;
      const double only_a = above[j] + kGap;
      const double only_b = row[j - 1] + kGap;
      row[j] = std::min({both, only_a, only_b});
      steps[i * columns + j] = row[j] == both     ? Step::kBoth
                               : row[j] == only_a ? Step::kOnlyA
                                                  : Step::kOnlyB;
    }
    std::swap(above, row);
  }
  std::size_t matched = 0;
  std::size_t i = lengths_a.size();
  std::size_t j = lengths_b.size();
  while (i > 0 || j > 0) {
    const Step step = steps[i * columns + j];
    matched += step == Step::kBoth ? 1 : 0;
    i -= step == Step::kOnlyB ? 0 : 1;
    j -= step == Step::kOnlyA ? 0 : 1;
  }
  return matched;
}

}  // namespace pipescout::benchmarks
