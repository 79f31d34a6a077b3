// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/runtime/qos.hpp"

/// QoS as rosbag2 writes it down, in bags and in files of overrides.
namespace pipescout {

/// A text is no QoS of rosbag2; what() says where and why.
class QosProfileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// For `bags::BagTopic::offered_qos_profiles`: a YAML sequence, policies as the numbers of Humble's
/// rmw. A depth of 0 is written as an unknown history, as discovery has it.
[[nodiscard]] std::string qos_profiles_to_yaml(std::span<const QoS> profiles);

/// Reads that; policies may be names too, as newer versions write them. What is left out, unknown
/// or the system's default has the value of `QoS{}`. Empty text: none. Throws QosProfileError.
[[nodiscard]] std::vector<QoS> qos_profiles_from_yaml(const std::string& text);

/// A file for `--qos-profile-overrides-path`: a map from topics to profiles, of which each says
/// what is to differ from ROS 2's default (reliable, volatile, depth 10). Throws QosProfileError
/// naming file and line.
[[nodiscard]] std::map<std::string, QoS> read_qos_overrides(const std::string& path);

/// What a player offers on a topic, as rosbag2 chooses it: what the recorded publishers did if they
/// all offered the same, the history aside; else reliable and volatile. The depth is that of the
/// deepest, at least 10.
[[nodiscard]] QoS offer_for(std::span<const QoS> recorded);

}  // namespace pipescout
