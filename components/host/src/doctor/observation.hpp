// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/parameters.hpp"

/// What `pipescout doctor` has seen of a system, as plain values: its checks need no network.
namespace pipescout::host::doctor {

using Vector = std::array<double, 3>;

/// Messages of one topic with an IMU's readings, in a moment of a second or two.
struct ImuSample {
  std::string frame;
  std::vector<Vector> specific_force;    ///< m/s^2, `linear_acceleration`
  std::vector<Vector> angular_velocity;  ///< rad/s
};

struct GpsSample {
  bool has_fix = false;
  double latitude = 0.0;   ///< deg
  double longitude = 0.0;  ///< deg
  std::array<double, 9> covariance{};
  std::uint8_t covariance_type = 0;  ///< NavSatFix::COVARIANCE_TYPE_*
};

struct CameraSample {
  double focal_length = 0.0;  ///< px, k[0]; 0: not calibrated
  std::uint32_t width = 0;    ///< px
  std::uint32_t height = 0;   ///< px
};

/// A network interface of this machine that is up.
struct Interface {
  std::string name;
  int mtu = 0;  ///< bytes
  bool loopback = false;
  bool multicast = false;
};

struct Machine {
  std::uintmax_t shared_memory_total = 0;  ///< bytes
  std::uintmax_t shared_memory_free = 0;   ///< bytes
  std::vector<Interface> interfaces;
  bool localhost_only = false;  ///< ROS_LOCALHOST_ONLY
  std::string recording_folder;
  std::uintmax_t recording_free = 0;  ///< bytes

  /// Whether an interface to other machines is up.
  [[nodiscard]] bool has_network() const {
    return std::any_of(interfaces.begin(), interfaces.end(),
                       [](const Interface& each) { return !each.loopback; });
  }
};

/// A component of the composition that is looked at, made and configured on trial.
struct Trial {
  std::string location;  ///< "file:line:column"
  NodeName node;
  std::string failure;  ///< why it cannot be made or configured; empty when it can
  std::vector<UnusedOverride> unused_parameters;
};

struct Observation {
  std::string unreachable_network;  ///< why there was no joining it; empty: it was joined
  /// What is known to be missing of nodes and endpoints, a sentence each.
  std::vector<std::string> undiscovered;
  /// Nodes by what their processes speak to: this machine alone (ROS_LOCALHOST_ONLY), or others
  /// too.
  std::set<NodeName> nodes_on_loopback_alone;
  std::set<NodeName> nodes_beyond_loopback;
  std::vector<NodeName> nodes;
  std::vector<GraphEndpoint> endpoints;
  /// How much later than stamped a message came, s; the median of a topic.
  std::map<std::string, double> stamp_age;
  bool simulated_time = false;  ///< somebody publishes /clock
  std::map<std::string, ImuSample> imus;
  std::map<std::string, GpsSample> fixes;
  std::map<std::string, CameraSample> cameras;
  std::map<NodeName, std::vector<double>> datums;  ///< of nodes with a parameter `datum`
  std::optional<Machine> machine;
  std::vector<Trial> trials;
};

}  // namespace pipescout::host::doctor
