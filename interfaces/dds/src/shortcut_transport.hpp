// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "shared_memory.hpp"
#include "warnings.hpp"

namespace pipescout::dds {

/// UDP over IPv4 to everybody, with a shortcut through shared memory to the Pipescout processes of
/// this machine. Nobody is told of the shared memory: other participants see UDP locators alone, so
/// nothing depends on whether their shared memory has the layout of ours
/// (docs/decisions/shared-memory-of-our-own.md). A process that listens on UDP port p also listens
/// on a shared memory port that follows from p; a sender finds out by the lock that Fast DDS keeps
/// for each shared memory port that has a reader. Where there is no such lock, UDP serves.
struct ShortcutTransportDescriptor final
    : public eprosima::fastdds::rtps::UDPv4TransportDescriptor {
  eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

  /// After so many bytes a reliable writer of Fast DDS sends all its readers a heartbeat; those
  /// that have not yet read what is on its way ask for all of it again. With the size of the
  /// socket's buffer, which Fast DDS takes, a process that tells twenty others of its endpoints
  /// would not come to an end: the answers make more heartbeats than there were.
  [[nodiscard]] std::uint32_t min_send_buffer_size() const override;

  eprosima::fastdds::rtps::SharedMemTransportDescriptor shared_memory;
  bool has_shared_memory = true;  ///< false: there is no room for it
  std::shared_ptr<Warnings> warnings = std::make_shared<Warnings>();  ///< never null
};

/// The shared memory port behind a UDP port, above all ports that Fast DDS itself uses. Differs
/// between network namespaces (which have UDP ports of their own, but may share the memory), users
/// (who may not write into each other's memory) and versions of Fast DDS (whose layouts differ).
[[nodiscard]] std::uint32_t shared_memory_port(std::uint16_t udp_port);

/// Notes in the lock file of a port which memory its reader, this process, listens to: the inode.
/// False when it cannot be written; then nobody takes the shortcut.
[[nodiscard]] bool note_memory(std::uint32_t port,
                               const std::filesystem::path& folder = kSharedMemoryFolder);

/// Whether a message that is sent to a shared memory port reaches a living process. Keeps lock and
/// memory of the ports open that it was asked for. Not thread-safe.
///
/// When a process was killed, the next reader of its port makes the port's memory anew, but a Fast
/// DDS sender that knows the port writes into the old one until it notices, if it does. So a port
/// counts only as long as its memory is that of the first reader found. A reader that ended by
/// itself leaves the memory to the next one.
///
/// A Fast DDS sender that opens a port whose reader has stood still for a second, on a busy
/// machine, makes the memory anew although the reader lives, who never looks into the new one. So a
/// port counts only with the memory that its reader has noted.
class ReaderProbe {
 public:
  explicit ReaderProbe(std::filesystem::path folder = kSharedMemoryFolder);
  ReaderProbe(const ReaderProbe&) = delete;
  ReaderProbe& operator=(const ReaderProbe&) = delete;
  ~ReaderProbe();

  [[nodiscard]] bool has_reader(std::uint32_t port);

 private:
  struct Port {
    std::uint32_t number;
    int lock;
    int memory;
  };
  /// The descriptor of the memory; -1 unless it is the one that the reader listens to.
  [[nodiscard]] int open_memory(std::uint32_t port, int lock);

  std::filesystem::path folder_;
  std::vector<Port> open_;                               // those that had a reader when last asked
  std::map<std::uint32_t, std::uint64_t> first_memory_;  // inode of the memory, by port
};

}  // namespace pipescout::dds
