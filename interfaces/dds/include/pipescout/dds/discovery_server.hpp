// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pipescout/dds/network_options.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// After so long participants know that a server of this kind is gone.
inline constexpr std::chrono::milliseconds kTimeToForgetAServer{3500};

struct DiscoveryServerOptions {
  std::uint32_t domain_id = 0;
  std::uint8_t id = 0;
  std::string address = "0.0.0.0";  ///< IPv4, of the interface; "0.0.0.0": all
  std::uint16_t port = DiscoveryServerAddress::kDefaultPort;
  NetworkProfile network;  ///< kWifi: all that it sends has this rate
};

/// A Fast DDS discovery server: participants that know it learn through it of those whose topics
/// they share, instead of by multicast. Several of one fleet need not know each other, since
/// participants report to all of them.
///
/// A server that ended without saying so and is there again before participants have noticed is
/// taken for the old one, which knew them already: wait for `kTimeToForgetAServer` before.
class DiscoveryServer {
 public:
  virtual ~DiscoveryServer() = default;
  /// Those that have reported to it, and other servers.
  [[nodiscard]] virtual std::vector<DiscoveredParticipant> participants() const = 0;
};

/// Throws TransportError when the address or port cannot be used.
[[nodiscard]] std::unique_ptr<DiscoveryServer> start_discovery_server(
    const DiscoveryServerOptions& options);

/// The participant that every server of that id is.
[[nodiscard]] Gid discovery_server_identity(std::uint8_t id);

}  // namespace pipescout
