// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/odometer_text.hpp"

#include <pipescout_msgs/msg/fused_odometer.hpp>

namespace pipescout {

namespace constants = pipescout_msgs::msg::FusedOdometer_Constants;

const char* fusion_status_text(std::uint8_t status) noexcept {
  switch (status) {
    case constants::STATUS_OK:
      return "ok";
    case constants::STATUS_NO_CONSENSUS:
      return "no consensus";
    case constants::STATUS_NO_DATA:
      return "no data";
    default:
      return "unknown";
  }
}

const char* rejection_text(std::uint8_t reason) noexcept {
  switch (reason) {
    case constants::REJECTED_NONE:
      return "none";
    case constants::REJECTED_UNSUPPORTED:
      return "unsupported";
    case constants::REJECTED_INVALID:
      return "marked invalid";
    case constants::REJECTED_NOT_A_NUMBER:
      return "not a number";
    case constants::REJECTED_BAD_SIGMA:
      return "bad sigma";
    case constants::REJECTED_ABSENT:
      return "absent";
    case constants::REJECTED_INCOMPLETE:
      return "incomplete";
    case constants::REJECTED_STUCK:
      return "stuck";
    case constants::REJECTED_DRIFTED:
      return "drifted";
    default:
      return "unknown";
  }
}

const char* health_text(std::uint8_t health) noexcept {
  switch (health) {
    case constants::HEALTH_OK:
      return "ok";
    case constants::HEALTH_WORN:
      return "worn";
    case constants::HEALTH_SLIPPING:
      return "slipping";
    case constants::HEALTH_STUCK:
      return "stuck";
    case constants::HEALTH_BAD_VALUES:
      return "bad values";
    case constants::HEALTH_SILENT:
      return "silent";
    default:
      return "unknown";
  }
}

}  // namespace pipescout
