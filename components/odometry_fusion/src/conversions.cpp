// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/conversions.hpp"

#include <vector>

namespace pipescout {

namespace {

using odometry::FusionStatus;
using odometry::RejectionReason;
namespace constants = pipescout_msgs::msg::FusedOdometer_Constants;

// The numbers of the algorithm go over the wire as they are.
constexpr auto kNumber = [](auto enumerator) { return static_cast<std::uint8_t>(enumerator); };
static_assert(kNumber(RejectionReason::kNone) == constants::REJECTED_NONE);
static_assert(kNumber(RejectionReason::kUnsupported) == constants::REJECTED_UNSUPPORTED);
static_assert(kNumber(RejectionReason::kMarkedInvalid) == constants::REJECTED_INVALID);
static_assert(kNumber(RejectionReason::kNotANumber) == constants::REJECTED_NOT_A_NUMBER);
static_assert(kNumber(RejectionReason::kBadSigma) == constants::REJECTED_BAD_SIGMA);
static_assert(kNumber(FusionStatus::kOk) == constants::STATUS_OK);
static_assert(kNumber(FusionStatus::kNoConsensus) == constants::STATUS_NO_CONSENSUS);

}  // namespace

ReadingsBuffer::ReadingsBuffer(const pipescout_msgs::msg::OdometerReadings& message,
                               std::span<const double> standard_deviations)
    : size_(message.distance().size()) {
  for (std::size_t i = 0; i < size_; ++i) {
    readings_[i] = {.distance = message.distance()[i],
                    .standard_deviation = message.standard_deviation().empty()
                                              ? standard_deviations[i]
                                              : message.standard_deviation()[i],
                    .valid = message.valid()[i]};
  }
}

pipescout_msgs::msg::FusedOdometer to_message(
    const odometry::ConsensusFusionResult& result,
    const pipescout_msgs::msg::OdometerReadings& readings) {
  const std::size_t odometers = readings.distance().size();
  pipescout_msgs::msg::FusedOdometer message;
  message.header(readings.header());
  message.name(readings.name());
  message.distance(result.fused.distance);
  message.variance(result.fused.standard_deviation * result.fused.standard_deviation);
  message.status(kNumber(result.status));
  message.in_fusion_set().reserve(odometers);
  message.rejection_reason().reserve(odometers);
  for (std::size_t i = 0; i < odometers; ++i) {
    message.in_fusion_set().push_back(result.fusion_set[i]);
    message.rejection_reason().push_back(kNumber(result.rejections[i]));
  }
  // Both are row-major, as the message wants them.
  const auto& relation = result.relation;
  message.support().assign(relation.data(), relation.data() + relation.size());
  const auto& distance = result.confidence_distance;
  message.confidence_distance().assign(distance.data(), distance.data() + distance.size());
  return message;
}

}  // namespace pipescout
