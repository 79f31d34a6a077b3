// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipescout/dds/announcements.hpp"
#include "pipescout/dds/network_options.hpp"
#include "pipescout/runtime/transport.hpp"

/// The transport over Fast DDS, which connects a context's nodes to other processes and to ROS 2.
namespace pipescout {

/// DDS Security with a keystore as SROS 2 lays it out (public/, private/, enclaves/).
struct SecurityOptions {
  bool enabled = false;
  bool enforce =
      false;  ///< an enclave without files is an error, and no participant without security
  bool strict_keys = false;  ///< a private key that others can read is an error, not a warning
  std::filesystem::path keystore;
  std::string enclave_override;  ///< counts before `DdsOptions::enclave`; empty: none
  /// Called in another thread once the revocation list of the enclave has changed: a participant
  /// keeps to the list that it was created with. Empty: the process gets a SIGTERM, ends in good
  /// order, and obeys the new list when its supervisor starts it again.
  std::function<void()> on_revocations_changed;
};

/// How the participant joins the network. Defaults are those of ROS 2.
struct DdsOptions {
  std::uint32_t domain_id = 0;
  bool localhost_only = false;  ///< loopback and shared memory only
  std::string enclave = "/";
  /// Participant name in discovery.
  std::string name = "pipescout";
  /// Bytes of the shared memory segment that carries data to other processes on this machine.
  /// Should hold several of the largest messages: what does not fit has to be retransmitted.
  /// Limited to an eighth of the free space in /dev/shm.
  std::size_t shared_memory_segment_bytes = std::size_t{32} * 1024 * 1024;

  /// Not empty: others are found through these alone, without multicast. Of several one is enough.
  std::vector<DiscoveryServerAddress> discovery_servers;
  /// The servers tell everything, not only of topics that this process has too: for lists.
  bool super_client = false;
  /// Hosts that are spoken to by unicast too, without a server.
  std::vector<std::string> static_peers;
  NetworkProfile network;
  /// Topics ("/robot_1/state") that may leave this machine: the others go to processes that hear
  /// unexported topics alone, and share its memory. Services, actions, `/diagnostics`, `/rosout`
  /// and `/parameter_events` always may. Nothing: all topics. With security the permissions of the
  /// enclave have to grant every partition, as those of `pipescout security` do: else
  /// TransportError.
  std::optional<std::set<std::string>> exported_topics;
  /// This process hears what does not leave the machine, too, where its permissions let it; one
  /// with `exported_topics` does.
  bool hears_unexported = false;

  /// What this process says with its announcements, and hears of others; null: nothing. Of one
  /// transport only.
  std::shared_ptr<Announcements> announcements;

  SecurityOptions security;

  /// Reads `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY`, `ROS_DISCOVERY_SERVER`, `ROS_SUPER_CLIENT`,
  /// `ROS_STATIC_PEERS`, `PIPESCOUT_NETWORK` and, as rcl does, `ROS_SECURITY_ENABLE`,
  /// `ROS_SECURITY_STRATEGY`, `ROS_SECURITY_KEYSTORE` and `ROS_SECURITY_ENCLAVE_OVERRIDE`; further
  /// `PIPESCOUT_STRICT_KEYS`. Throws std::invalid_argument naming the variable and its value.
  /// (`FASTRTPS_DEFAULT_PROFILES_FILE` is read by Fast DDS itself; a default participant profile in
  /// it replaces the transports chosen here, and one that chooses a discovery protocol or initial
  /// peers the discovery.)
  [[nodiscard]] static DdsOptions from_environment();
};

/// Joins the DDS network with one participant. Throws TransportError.
[[nodiscard]] std::unique_ptr<Transport> create_dds_transport(const DdsOptions& options);

/// Of the Fast DDS that this was built with: "2.9.1".
[[nodiscard]] std::string fast_dds_version();

}  // namespace pipescout
