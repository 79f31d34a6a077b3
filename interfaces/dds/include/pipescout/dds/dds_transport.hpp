// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "pipescout/runtime/transport.hpp"

/// The transport over Fast DDS, which connects a context's nodes to other processes and to ROS 2.
namespace pipescout {

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

  /// Reads `ROS_DOMAIN_ID` and `ROS_LOCALHOST_ONLY`. Throws std::invalid_argument naming the
  /// variable and its value. (`FASTRTPS_DEFAULT_PROFILES_FILE` is read by Fast DDS itself; a
  /// default participant profile in it replaces the transports chosen here.)
  [[nodiscard]] static DdsOptions from_environment();
};

/// Joins the DDS network with one participant. Throws TransportError.
[[nodiscard]] std::unique_ptr<Transport> create_dds_transport(const DdsOptions& options);

/// Of the Fast DDS that this was built with: "2.9.1".
[[nodiscard]] std::string fast_dds_version();

}  // namespace pipescout
