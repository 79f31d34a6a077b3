// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/readings_checks.hpp"

#include <pipescout/odometry/consensus_fusion.hpp>
#include <set>
#include <string_view>

namespace pipescout {

std::optional<ReadingsFault> find_fault(const pipescout_msgs::msg::OdometerReadings& message,
                                        std::size_t fewest) {
  const std::size_t odometers = message.name.size();
  if (odometers < fewest || odometers > odometry::kMaxOdometers) {
    return ReadingsFault{"readings.name.wrong_count",
                         "readings of " + std::to_string(odometers) + " odometers; " +
                             std::to_string(fewest) + " to " +
                             std::to_string(odometry::kMaxOdometers) + " can be fused"};
  }
  if (std::set<std::string_view>(message.name.begin(), message.name.end()).size() != odometers) {
    return ReadingsFault{"readings.name.not_unique",
                         "two odometers of the readings have the same name"};
  }
  if (auto fault = find_size_fault("distance", message.distance.size(), odometers)) {
    return fault;
  }
  return find_size_fault("valid", message.valid.size(), odometers);
}

std::optional<ReadingsFault> find_size_fault(const std::string& field, std::size_t size,
                                             std::size_t odometers) {
  if (size == odometers) {
    return std::nullopt;
  }
  return ReadingsFault{"readings." + field + ".wrong_size",
                       "readings with " + std::to_string(size) + " values of '" + field + "' for " +
                           std::to_string(odometers) + " odometers"};
}

}  // namespace pipescout
