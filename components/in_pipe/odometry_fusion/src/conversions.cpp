// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/conversions.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace pipescout {

namespace {

using odometry::FusionStatus;
using odometry::OdometerHealth;
using odometry::OdometerUse;
using odometry::RejectionReason;
using odometry::StreamStatus;
using pipescout_msgs::msg::FusedOdometer;

// The numbers of the algorithm go over the wire as they are.
constexpr auto kNumber = [](auto enumerator) { return static_cast<std::uint8_t>(enumerator); };
static_assert(kNumber(RejectionReason::kNone) == FusedOdometer::REJECTED_NONE);
static_assert(kNumber(RejectionReason::kUnsupported) == FusedOdometer::REJECTED_UNSUPPORTED);
static_assert(kNumber(RejectionReason::kMarkedInvalid) == FusedOdometer::REJECTED_INVALID);
static_assert(kNumber(RejectionReason::kNotANumber) == FusedOdometer::REJECTED_NOT_A_NUMBER);
static_assert(kNumber(RejectionReason::kBadSigma) == FusedOdometer::REJECTED_BAD_SIGMA);
static_assert(kNumber(OdometerHealth::kOk) == FusedOdometer::HEALTH_OK);
static_assert(kNumber(OdometerHealth::kWorn) == FusedOdometer::HEALTH_WORN);
static_assert(kNumber(OdometerHealth::kSlipping) == FusedOdometer::HEALTH_SLIPPING);
static_assert(kNumber(OdometerHealth::kStuck) == FusedOdometer::HEALTH_STUCK);
static_assert(kNumber(OdometerHealth::kBadValues) == FusedOdometer::HEALTH_BAD_VALUES);
static_assert(kNumber(OdometerHealth::kSilent) == FusedOdometer::HEALTH_SILENT);
static_assert(kNumber(FusionStatus::kOk) == FusedOdometer::STATUS_OK);
static_assert(kNumber(FusionStatus::kNoConsensus) == FusedOdometer::STATUS_NO_CONSENSUS);

std::uint8_t rejection(OdometerUse use) {
  switch (use) {
    case OdometerUse::kFused:
      return FusedOdometer::REJECTED_NONE;
    case OdometerUse::kAbsent:
      return FusedOdometer::REJECTED_ABSENT;
    case OdometerUse::kIncomplete:
      return FusedOdometer::REJECTED_INCOMPLETE;
    case OdometerUse::kStuck:
      return FusedOdometer::REJECTED_STUCK;
    case OdometerUse::kDrifted:
      return FusedOdometer::REJECTED_DRIFTED;
    case OdometerUse::kUnsupported:
    case OdometerUse::kFallback:
      break;
  }
  return FusedOdometer::REJECTED_UNSUPPORTED;
}

std::uint8_t status(StreamStatus status) {
  switch (status) {
    case StreamStatus::kOk:
      return FusedOdometer::STATUS_OK;
    case StreamStatus::kNoConsensus:
      return FusedOdometer::STATUS_NO_CONSENSUS;
    case StreamStatus::kWaiting:
    case StreamStatus::kNoData:
      break;
  }
  return FusedOdometer::STATUS_NO_DATA;
}

void set_matrices(const odometry::ConsensusFusionResult& consensus,
                  pipescout_msgs::msg::FusedOdometer& message) {
  // Both are row-major, as the message wants them.
  const auto& relation = consensus.relation;
  message.support.assign(relation.data(), relation.data() + relation.size());
  const auto& distance = consensus.confidence_distance;
  message.confidence_distance.assign(distance.data(), distance.data() + distance.size());
}

}  // namespace

ReadingsBuffer::ReadingsBuffer(const pipescout_msgs::msg::OdometerReadings& message,
                               std::span<const double> standard_deviations)
    : size_(message.distance.size()) {
  for (std::size_t i = 0; i < size_; ++i) {
    readings_[i] = {.distance = message.distance[i],
                    .standard_deviation = message.standard_deviation.empty()
                                              ? standard_deviations[i]
                                              : message.standard_deviation[i],
                    .valid = message.valid[i]};
  }
}

pipescout_msgs::msg::FusedOdometer to_message(
    const odometry::ConsensusFusionResult& result,
    const pipescout_msgs::msg::OdometerReadings& readings) {
  const std::size_t odometers = readings.distance.size();
  pipescout_msgs::msg::FusedOdometer message;
  message.header = readings.header;
  message.name = readings.name;
  message.distance = result.fused.distance;
  message.variance = result.fused.standard_deviation * result.fused.standard_deviation;
  message.status = kNumber(result.status);
  message.in_fusion_set.reserve(odometers);
  message.rejection_reason.reserve(odometers);
  for (std::size_t i = 0; i < odometers; ++i) {
    message.in_fusion_set.push_back(result.fusion_set[i]);
    message.rejection_reason.push_back(kNumber(result.rejections[i]));
  }
  message.speed = std::numeric_limits<double>::quiet_NaN();
  message.independent_variance = std::numeric_limits<double>::quiet_NaN();
  set_matrices(result, message);
  return message;
}

pipescout_msgs::msg::FusedOdometer to_message(const odometry::FusedStream& state,
                                              const std::vector<std::string>& names) {
  pipescout_msgs::msg::FusedOdometer message;
  message.distance = state.distance;
  message.variance = state.variance;
  message.speed = state.speed;
  message.independent_variance = state.random_variance;
  message.name = names;
  message.status = status(state.status);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const odometry::OdometerState& odometer = state.odometers[i];
    message.in_fusion_set.push_back(odometer.use == OdometerUse::kFused);
    message.rejection_reason.push_back(rejection(odometer.use));
    message.health.push_back(kNumber(odometer.health));
    message.scale.push_back(odometer.correction.scale);
    message.scale_standard_deviation.push_back(std::sqrt(odometer.correction.covariance(0, 0)));
  }
  set_matrices(state.consensus, message);
  return message;
}

pipescout_msgs::msg::BendDetection to_message(const odometry::FoundBend& bend) {
  pipescout_msgs::msg::BendDetection message;
  message.distance = bend.middle;
  message.standard_deviation = bend.middle_standard_deviation;
  message.length = bend.length;
  message.angle = bend.angle;
  message.angle_standard_deviation = bend.angle_standard_deviation;
  message.direction = bend.direction;
  message.probability = bend.probability;
  return message;
}

}  // namespace pipescout
