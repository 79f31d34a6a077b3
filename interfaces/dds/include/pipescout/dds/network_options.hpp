// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// How a process finds others and what it asks of the network.
namespace pipescout {

/// A Fast DDS discovery server. Its identity follows from `id`, as with `fastdds discovery -i ID`.
struct DiscoveryServerAddress {
  static constexpr std::uint16_t kDefaultPort = 11811;

  std::uint8_t id = 0;
  std::string host;  ///< IPv4 address, or a name that is resolved once, at the start
  std::uint16_t port = kDefaultPort;

  bool operator==(const DiscoveryServerAddress&) const = default;
};

/// "10.0.0.1:11811"
[[nodiscard]] std::string to_string(const DiscoveryServerAddress& server);

/// `ROS_DISCOVERY_SERVER`: HOST or HOST:PORT, several separated by ';'. The place in the list is
/// the id of the server, so an empty place skips one. Throws std::invalid_argument naming the
/// entry.
[[nodiscard]] std::vector<DiscoveryServerAddress> parse_discovery_servers(std::string_view text);

/// `ROS_STATIC_PEERS`: addresses or names of hosts, separated by ';'. An entry that begins with '/'
/// is a file with one host a line; '#' begins a comment. Each host once, in order. Throws
/// std::invalid_argument naming the entry, or the file and line.
[[nodiscard]] std::vector<std::string> parse_static_peers(std::string_view text);

/// What is between the robots.
struct NetworkProfile {
  enum class Kind {
    kWire,  ///< loses nearly nothing: large datagrams, sent by who publishes
    kWifi,  ///< loses and delays: datagrams that no path splits, sent by a thread of their own,
            ///< best effort topics at a limited rate
  };
  /// Of a shared channel of 20 Mbit/s, so that state and events have room.
  static constexpr double kDefaultRate = 8.0;
  static constexpr double kLowestRate = 0.1;
  static constexpr double kHighestRate = 1000.0;

  Kind kind = Kind::kWire;
  double rate = kDefaultRate;  ///< kWifi: Mbit/s for the best effort topics of the process together

  bool operator==(const NetworkProfile&) const = default;
};

/// `PIPESCOUT_NETWORK`: "wire", "wifi", or "wifi:RATE" in Mbit/s. Throws std::invalid_argument.
[[nodiscard]] NetworkProfile parse_network_profile(std::string_view text);

}  // namespace pipescout
