// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipescout/runtime/transport.hpp"
#include "shared_memory.hpp"

/// Participants by the sockets that processes of this machine hold, which are there before
/// discovery has shown who they belong to. They tell when a list of what was discovered is complete
/// (docs/decisions/lists-complete-by-signs-of-life.md).
namespace pipescout::dds {

/// A socket of this network namespace that is bound to a UDP port of IPv4.
struct BoundSocket {
  std::uint16_t port = 0;
  std::uint64_t inode = 0;
  auto operator<=>(const BoundSocket&) const = default;
};

struct SocketOwner {
  int process = 0;
  std::string program;  ///< its name as the kernel has it
};

/// Owners by the inode of the socket.
using SocketOwners = std::map<std::uint64_t, SocketOwner>;

/// All of the network namespace, of all users. Empty where the kernel does not list them.
[[nodiscard]] std::vector<BoundSocket> bound_sockets(const std::filesystem::path& proc = "/proc");

/// Of those that this user may see: processes of other users keep their sockets to themselves,
/// except from root.
[[nodiscard]] SocketOwners owners_of(const std::vector<BoundSocket>& sockets,
                                     const std::filesystem::path& proc = "/proc");

/// The UDP ports of this machine at which participants that discovery has shown take discovery
/// messages; those of other machines have none.
using PortsByParticipant = std::map<Gid, std::set<std::uint16_t>>;

/// Counts the participants of a domain that are on this machine. Not thread-safe.
class Census {
 public:
  explicit Census(std::uint32_t domain) : domain_(domain) {}

  struct Result {
    std::vector<UnheardParticipant> unheard;
    /// Discovery has shown them, but the sockets that they had when they were first counted are
    /// closed: they were killed, which discovery finds out after their lease alone.
    std::vector<Gid> departed;
  };

  /// A participant that takes its ports as RTPS 2.2 (9.6.1.1) gives them holds one for discovery
  /// and the next one for data; both are asked for, since in domains from 102 on a port alone may
  /// be that of any program that sends (Linux gives these from 32768 on). One that takes others
  /// (Cyclone DDS by default) still listens on the multicast port of the domain; it counts as heard
  /// when any port of its process is. Processes of other users show their ports alone.
  [[nodiscard]] Result count(const std::vector<BoundSocket>& sockets, const SocketOwners& owners,
                             const PortsByParticipant& discovered);

 private:
  const std::uint32_t domain_;
  std::map<Gid, std::set<std::uint64_t>> inodes_;  // of the sockets of those that were counted
};

/// Ports of the domain on which a living process takes discovery messages from the shared memory of
/// Fast DDS, and nobody of this network namespace from UDP: a participant that has no UDP, or one
/// of another namespace.
[[nodiscard]] std::vector<std::uint16_t> ports_of_shared_memory_alone(
    const std::vector<BoundSocket>& sockets, std::uint32_t domain,
    const std::filesystem::path& folder = kSharedMemoryFolder);

}  // namespace pipescout::dds
