// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/odometer_text.hpp"

#include <pipescout_msgs/msg/fused_odometer.hpp>

namespace pipescout {

using pipescout_msgs::msg::FusedOdometer;

const char* fusion_status_text(std::uint8_t status) noexcept {
  switch (status) {
    case FusedOdometer::STATUS_OK:
      return "ok";
    case FusedOdometer::STATUS_NO_CONSENSUS:
      return "no consensus";
    case FusedOdometer::STATUS_NO_DATA:
      return "no data";
    default:
      return "unknown";
  }
}

const char* rejection_text(std::uint8_t reason) noexcept {
  switch (reason) {
    case FusedOdometer::REJECTED_NONE:
      return "none";
    case FusedOdometer::REJECTED_UNSUPPORTED:
      return "unsupported";
    case FusedOdometer::REJECTED_INVALID:
      return "marked invalid";
    case FusedOdometer::REJECTED_NOT_A_NUMBER:
      return "not a number";
    case FusedOdometer::REJECTED_BAD_SIGMA:
      return "bad sigma";
    case FusedOdometer::REJECTED_ABSENT:
      return "absent";
    case FusedOdometer::REJECTED_INCOMPLETE:
      return "incomplete";
    case FusedOdometer::REJECTED_STUCK:
      return "stuck";
    case FusedOdometer::REJECTED_DRIFTED:
      return "drifted";
    default:
      return "unknown";
  }
}

const char* health_text(std::uint8_t health) noexcept {
  switch (health) {
    case FusedOdometer::HEALTH_OK:
      return "ok";
    case FusedOdometer::HEALTH_WORN:
      return "worn";
    case FusedOdometer::HEALTH_SLIPPING:
      return "slipping";
    case FusedOdometer::HEALTH_STUCK:
      return "stuck";
    case FusedOdometer::HEALTH_BAD_VALUES:
      return "bad values";
    case FusedOdometer::HEALTH_SILENT:
      return "silent";
    default:
      return "unknown";
  }
}

}  // namespace pipescout
