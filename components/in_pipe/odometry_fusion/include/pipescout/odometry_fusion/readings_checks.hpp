// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <string>

namespace pipescout {

/// A fault of a message, for `Component::report_fault`.
struct ReadingsFault {
  std::string counter;
  std::string text;
};

/// The reason why readings are inconsistent: not `fewest` to 16 odometers, two of one name, or
/// `distance` or `valid` not as long as `name`.
[[nodiscard]] std::optional<ReadingsFault> find_fault(
    const pipescout_msgs::msg::OdometerReadings& message, std::size_t fewest);

/// That a list of `size` values of `field` does not fit `odometers`.
[[nodiscard]] std::optional<ReadingsFault> find_size_fault(const std::string& field,
                                                           std::size_t size, std::size_t odometers);

}  // namespace pipescout
