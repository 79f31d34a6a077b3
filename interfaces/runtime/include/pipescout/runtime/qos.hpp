// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

enum class Reliability { kBestEffort, kReliable };
enum class Durability { kVolatile, kTransientLocal };
enum class Liveliness { kAutomatic, kManualByTopic };

/// Quality of service of one publisher (what it offers) or subscription (what it requests). The
/// semantics are those of ROS 2 and DDS, both in one process and across processes. History is
/// always "keep last": every queue is bounded.
struct QoS {
  std::size_t depth = 10;  ///< messages kept, at least 1
  Reliability reliability = Reliability::kReliable;
  Durability durability = Durability::kVolatile;
  std::optional<Duration> deadline =
      std::nullopt;  ///< longest time between two messages; none: unlimited
  Liveliness liveliness = Liveliness::kAutomatic;
  std::optional<Duration> liveliness_lease = std::nullopt;  ///< none: unlimited
  std::optional<Duration> lifespan =
      std::nullopt;  ///< older messages are not delivered; none: unlimited

  /// Default of ROS 2 topics: reliable, volatile, depth 10.
  [[nodiscard]] static constexpr QoS reliable(std::size_t depth = 10) { return {.depth = depth}; }
  /// `rmw_qos_profile_sensor_data`: best effort, volatile, depth 5.
  [[nodiscard]] static constexpr QoS sensor_data(std::size_t depth = 5) {
    return {.depth = depth, .reliability = Reliability::kBestEffort};
  }
  /// Reliable and transient local: late joiners get the last `depth` messages.
  [[nodiscard]] static constexpr QoS latched(std::size_t depth = 1) {
    return {.depth = depth, .durability = Durability::kTransientLocal};
  }
  /// `rmw_qos_profile_services_default`: reliable, volatile, depth 10.
  [[nodiscard]] static constexpr QoS services() { return {.depth = 10}; }
  /// `rmw_qos_profile_parameters`: reliable, volatile, depth 1000.
  [[nodiscard]] static constexpr QoS parameters() { return {.depth = 1000}; }

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;

  bool operator==(const QoS&) const = default;
};

/// The DDS policies that can be incompatible.
enum class QosPolicy { kReliability, kDurability, kDeadline, kLiveliness };

[[nodiscard]] const char* to_string(QosPolicy policy) noexcept;
[[nodiscard]] std::string to_string(const QoS& qos);

/// The first policy by which `offered` does not satisfy `requested` (DDS 1.4, section 2.2.3), or
/// nothing when the two match.
[[nodiscard]] std::optional<QosPolicy> incompatibility(const QoS& offered, const QoS& requested);

/// What a subscription asks for to hear all these publishers, as rosbag2 and `ros2 topic echo`
/// choose it: reliable if all offer it, transient local if all offer it, else the weaker. With no
/// publisher: reliable and volatile.
[[nodiscard]] QoS request_for(std::span<const QoS> offered, std::size_t depth);

}  // namespace pipescout
