// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <pipescout/odometry/consensus_fusion.hpp>
#include <pipescout/odometry/odometer_stream.hpp>
#include <pipescout_msgs/msg/bend_detection.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <span>
#include <string>
#include <vector>

namespace pipescout {

/// The readings of one message, without allocation.
class ReadingsBuffer {
 public:
  /// `message` has 2 to 16 odometers and lists of one length. `standard_deviations`, of that length
  /// too, stands in when the message brings none. Not checked.
  ReadingsBuffer(const pipescout_msgs::msg::OdometerReadings& message,
                 std::span<const double> standard_deviations);

  [[nodiscard]] std::span<const odometry::OdometerReading> readings() const noexcept {
    return {readings_.data(), size_};
  }

 private:
  std::array<odometry::OdometerReading, odometry::kMaxOdometers> readings_{};
  std::size_t size_ = 0;
};

/// The message that says what came of `readings`; header and names are theirs.
[[nodiscard]] pipescout_msgs::msg::FusedOdometer to_message(
    const odometry::ConsensusFusionResult& result,
    const pipescout_msgs::msg::OdometerReadings& readings);

/// The message that says how a stream of these odometers stands; the header is left empty.
[[nodiscard]] pipescout_msgs::msg::FusedOdometer to_message(const odometry::FusedStream& state,
                                                            const std::vector<std::string>& names);

/// The header is left empty.
[[nodiscard]] pipescout_msgs::msg::BendDetection to_message(const odometry::FoundBend& bend);

}  // namespace pipescout
