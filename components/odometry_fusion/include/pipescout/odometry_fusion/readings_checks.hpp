// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <string>

#include "pipescout/interfaces/time.hpp"

namespace pipescout {

/// What is wrong with a message, as `Component::report_fault` takes it.
struct ReadingsFault {
  std::string counter;
  std::string text;
};

/// Why readings make no sense as a whole: not `fewest` to 16 odometers, two of one name, or
/// `distance` or `valid` not as long as `name`.
[[nodiscard]] std::optional<ReadingsFault> find_fault(
    const pipescout_msgs::msg::OdometerReadings& message, std::size_t fewest);

/// That a list of `size` values of `field` does not fit `odometers`.
[[nodiscard]] std::optional<ReadingsFault> find_size_fault(const std::string& field,
                                                           std::size_t size, std::size_t odometers);

/// Why a stamp is strange: older than `maximum_age` s (0: any age is right), or further ahead of
/// the clock than `maximum_lead` s.
[[nodiscard]] std::optional<ReadingsFault> find_stamp_fault(Time stamp, Time now,
                                                            double maximum_age,
                                                            double maximum_lead);

}  // namespace pipescout
