// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/consensus_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;

void check_count(const char* field, std::size_t count) {
  if (count < kMinOdometers || count > kMaxOdometers) {
    refuse(field, ": ", count, " odometers are outside [", kMinOdometers, ", ", kMaxOdometers, "]");
  }
}

template <typename Matrix>
void check_square(const char* field, const Matrix& matrix) {
  if (matrix.rows() != matrix.cols()) {
    refuse(field, ": ", matrix.rows(), " x ", matrix.cols(), " is not square");
  }
  check_count(field, static_cast<std::size_t>(matrix.rows()));
}

void check_epsilon(double epsilon) {
  if (!(epsilon > 0.0 && epsilon < 1.0)) {
    refuse("epsilon: ", epsilon, " is outside (0, 1)");
  }
}

void check_weighting(Weighting weighting) {
  if (weighting != Weighting::kMaximumLikelihood && weighting != Weighting::kPaperEquation13) {
    refuse("weighting: ", static_cast<int>(weighting), " is outside {0, 1}");
  }
}

void check_support_rule(const char* field, SupportRule rule) {
  if (rule != SupportRule::kMajority && rule != SupportRule::kMutualMajority) {
    refuse(field, ": ", static_cast<int>(rule), " is outside {0, 1}");
  }
}

void check_offset_count(std::size_t offsets, std::size_t readings) {
  if (offsets != 0 && offsets != readings) {
    refuse("offsets: ", offsets, " values for ", readings, " odometers, must be as many or none");
  }
}

double offset_of(std::span<const double> offsets, std::size_t odometer) {
  return offsets.empty() ? 0.0 : offsets[odometer];
}

/// Why a reading cannot be used, or kNone.
RejectionReason find_fault(const OdometerReading& reading, double offset) {
  if (!reading.valid) {
    return RejectionReason::kMarkedInvalid;
  }
  if (!std::isfinite(reading.distance) || !std::isfinite(reading.distance + offset)) {
    return RejectionReason::kNotANumber;
  }
  if (!std::isfinite(reading.standard_deviation) || reading.standard_deviation <= 0.0) {
    return RejectionReason::kBadSigma;
  }
  return RejectionReason::kNone;
}

using Faults = std::array<RejectionReason, kMaxOdometers>;

Faults find_faults(std::span<const OdometerReading> readings, std::span<const double> offsets) {
  Faults faults{};
  for (std::size_t i = 0; i < readings.size(); ++i) {
    faults[i] = find_fault(readings[i], offset_of(offsets, i));
  }
  return faults;
}

ConfidenceDistanceMatrix distances_of_usable(std::span<const OdometerReading> readings,
                                             const Faults& faults) {
  const auto m = static_cast<Eigen::Index>(readings.size());
  ConfidenceDistanceMatrix distances = ConfidenceDistanceMatrix::Ones(m, m);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    for (std::size_t j = 0; j < readings.size(); ++j) {
      if (faults[i] == RejectionReason::kNone && faults[j] == RejectionReason::kNone) {
        distances(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = confidence_distance(
            readings[i].distance, readings[j].distance, readings[i].standard_deviation);
      }
    }
  }
  return distances;
}

}  // namespace

void ConsensusFusionParameters::validate() const {
  check_epsilon(epsilon);
  check_weighting(weighting);
  check_support_rule("support_rule", support_rule);
  if (!offsets.empty()) {
    check_count("offsets", offsets.size());
  }
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (!std::isfinite(offsets[i])) {
      refuse("offsets[", i, "]: ", offsets[i], " is outside (-inf, inf)");
    }
  }
}

double confidence_distance(double x_i, double x_j, double sigma_i) noexcept {
  // Two divisions: sqrt(2) * sigma_i could overflow, a quotient that does means distance 1.
  return std::erf(std::abs(x_i - x_j) / sigma_i / std::numbers::sqrt2);
}

ConfidenceDistanceMatrix confidence_distance_matrix(std::span<const OdometerReading> readings) {
  check_count("readings", readings.size());
  return distances_of_usable(readings, find_faults(readings, {}));
}

RelationMatrix relation_matrix(const ConfidenceDistanceMatrix& confidence_distance,
                               double epsilon) {
  check_square("confidence_distance", confidence_distance);
  check_epsilon(epsilon);
  return (confidence_distance.array() <= epsilon).cast<std::uint8_t>();
}

OdometerSet fusion_set(const RelationMatrix& relation, SupportRule rule) {
  check_square("relation", relation);
  check_support_rule("rule", rule);
  const Eigen::Index m = relation.rows();
  const Eigen::Index usable = (relation.diagonal().array() != 0).count();
  const Eigen::Index group = std::max<Eigen::Index>(2, usable / 2 + 1);
  OdometerSet members;
  for (Eigen::Index j = 0; j < m; ++j) {
    if (relation(j, j) == 0) {
      continue;
    }
    Eigen::Index supporters = 0;
    for (Eigen::Index i = 0; i < m; ++i) {
      const bool supports = relation(i, i) != 0 && relation(i, j) != 0;
      supporters += supports && (rule == SupportRule::kMajority || relation(j, i) != 0) ? 1 : 0;
    }
    members.set(static_cast<std::size_t>(j), supporters >= group);
  }
  return members;
}

FusedDistance fuse_members(std::span<const OdometerReading> readings,
                           std::span<const double> offsets, const OdometerSet& members,
                           Weighting weighting) {
  check_count("readings", readings.size());
  check_offset_count(offsets.size(), readings.size());
  check_weighting(weighting);
  if (members.none()) {
    refuse("members: 0 odometers are outside [1, ", readings.size(), "]");
  }
  double smallest_sigma = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kMaxOdometers; ++i) {
    if (!members[i]) {
      continue;
    }
    if (i >= readings.size()) {
      refuse("members: odometer ", i, " is outside [0, ", readings.size() - 1, "]");
    }
    if (const auto fault = find_fault(readings[i], offset_of(offsets, i));
        fault != RejectionReason::kNone) {
      refuse("members: odometer ", i, " is not usable (", to_string(fault), ")");
    }
    smallest_sigma = std::min(smallest_sigma, readings[i].standard_deviation);
  }

  // Weights relative to the largest, and divided by their sum before use: neither the square of a
  // sigma nor a sum of distances can overflow.
  std::array<double, kMaxOdometers> weights{};
  double sum = 0.0;
  double sum_of_squares = 0.0;  // of w_i sigma_i / smallest_sigma
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (members[i]) {
      const double ratio = smallest_sigma / readings[i].standard_deviation;
      const bool squared = weighting == Weighting::kMaximumLikelihood;
      weights[i] = squared ? ratio * ratio : ratio;
      sum += weights[i];
      sum_of_squares += squared ? ratio * ratio : 1.0;
    }
  }
  double mean = 0.0;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (members[i]) {
      const double distance = readings[i].distance + offset_of(offsets, i);
      mean += weights[i] / sum * distance;
      smallest = std::min(smallest, distance);
      largest = std::max(largest, distance);
    }
  }
  // Rounding alone could carry the mean of equal readings past them.
  return {.distance = std::clamp(mean, smallest, largest),
          .standard_deviation = smallest_sigma * std::sqrt(sum_of_squares) / sum};
}

ConsensusFusion::ConsensusFusion(ConsensusFusionParameters parameters)
    : parameters_(std::move(parameters)) {
  parameters_.validate();
}

ConsensusFusionResult ConsensusFusion::fuse(std::span<const OdometerReading> readings) const {
  check_count("readings", readings.size());
  check_offset_count(parameters_.offsets.size(), readings.size());
  const Faults faults = find_faults(readings, parameters_.offsets);

  ConsensusFusionResult result;
  result.confidence_distance = distances_of_usable(readings, faults);
  result.relation = relation_matrix(result.confidence_distance, parameters_.epsilon);
  result.fusion_set = fusion_set(result.relation, parameters_.support_rule);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const bool unsupported = faults[i] == RejectionReason::kNone && !result.fusion_set[i];
    result.rejections[i] = unsupported ? RejectionReason::kUnsupported : faults[i];
  }
  if (result.fusion_set.any()) {
    result.status = FusionStatus::kOk;
    result.fused =
        fuse_members(readings, parameters_.offsets, result.fusion_set, parameters_.weighting);
  }
  return result;
}

const char* to_string(RejectionReason reason) noexcept {
  switch (reason) {
    case RejectionReason::kNone:
      return "none";
    case RejectionReason::kUnsupported:
      return "unsupported";
    case RejectionReason::kMarkedInvalid:
      return "marked invalid";
    case RejectionReason::kNotANumber:
      return "not a number";
    case RejectionReason::kBadSigma:
      return "bad sigma";
  }
  return "unknown";
}

const char* to_string(FusionStatus status) noexcept {
  switch (status) {
    case FusionStatus::kOk:
      return "ok";
    case FusionStatus::kNoConsensus:
      return "no consensus";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
