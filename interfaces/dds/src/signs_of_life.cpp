// SPDX-License-Identifier: Apache-2.0
#include "signs_of_life.hpp"

#include <fastdds/rtps/common/PortParameters.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace pipescout::dds {
namespace {

namespace fs = std::filesystem;
using eprosima::fastrtps::rtps::PortParameters;

// Of a domain on one machine, before its ports run into those of the next domain.
constexpr std::uint32_t kParticipantsOfADomain = 120;

/// The ports of a domain; those above 65535 there are not.
struct Ports {
  std::uint32_t multicast = 0;
  std::uint32_t first_unicast = 0;  ///< that of each further participant is higher by 2
  std::uint32_t last_unicast = 0;

  explicit Ports(std::uint32_t domain) {
    const PortParameters standard;
    const std::uint32_t base = standard.portBase + standard.domainIDGain * domain;
    multicast = base + standard.offsetd0;
    first_unicast = base + standard.offsetd1;
    last_unicast = first_unicast + standard.participantIDGain * (kParticipantsOfADomain - 1);
    constexpr std::uint32_t kLast = std::numeric_limits<std::uint16_t>::max();
    // The next one has to fit too: it is that for data.
    last_unicast = std::min(last_unicast, kLast - 1);
  }
};

template <class Number>
std::optional<Number> number(std::string_view text, int base = 10) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, value, base);
  return error == std::errc{} && parsed == end ? std::optional(value) : std::nullopt;
}

/// A line of /proc/net/udp: the second column is the address and port in hexadecimal digits, the
/// tenth the inode.
std::optional<BoundSocket> read_socket(const std::string& line) {
  std::istringstream words(line);
  const std::vector<std::string> columns{std::istream_iterator<std::string>(words), {}};
  constexpr std::size_t kAddress = 1;
  constexpr std::size_t kInode = 9;
  if (columns.size() <= kInode) {
    return std::nullopt;
  }
  const std::string_view address = columns[kAddress];
  const auto colon = address.find(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  const auto port = number<std::uint16_t>(address.substr(colon + 1), 16);
  const auto inode = number<std::uint64_t>(columns[kInode]);
  if (!port || !inode) {
    return std::nullopt;
  }
  return BoundSocket{*port, *inode};
}

/// "socket:[12345]", as the kernel names an open socket in /proc/PID/fd.
std::optional<std::uint64_t> socket_inode(std::string_view target) {
  constexpr std::string_view kBegin = "socket:[";
  if (!target.starts_with(kBegin) || !target.ends_with(']')) {
    return std::nullopt;
  }
  target.remove_prefix(kBegin.size());
  target.remove_suffix(1);
  return number<std::uint64_t>(target);
}

std::string program_of(const fs::path& process) {
  std::string name;
  std::ifstream file(process / "comm");
  std::getline(file, name);
  return name;
}

/// The ports at which a participant with these takes discovery messages, if it has those of the
/// standard.
std::vector<std::uint16_t> discovery_ports(const std::set<std::uint16_t>& held,
                                           const Ports& ports) {
  std::vector<std::uint16_t> found;
  for (std::uint32_t port = ports.first_unicast; port <= ports.last_unicast; port += 2) {
    if (held.contains(static_cast<std::uint16_t>(port)) &&
        held.contains(static_cast<std::uint16_t>(port + 1))) {
      found.push_back(static_cast<std::uint16_t>(port));
    }
  }
  return found;
}

/// Those whose ports nobody of `heard` has.
std::vector<UnheardParticipant> unheard_participants(const std::vector<BoundSocket>& sockets,
                                                     const SocketOwners& owners,
                                                     const std::set<std::uint16_t>& heard,
                                                     std::uint32_t domain) {
  constexpr int kOfOthers = 0;  // who do not say whose they are
  const Ports ports(domain);
  std::map<int, std::set<std::uint16_t>> held_by;
  std::map<int, std::string> programs;
  for (const BoundSocket& socket : sockets) {
    const auto owner = owners.find(socket.inode);
    const int process = owner == owners.end() ? kOfOthers : owner->second.process;
    held_by[process].insert(socket.port);
    if (owner != owners.end()) {
      programs[process] = owner->second.program;
    }
  }
  std::vector<UnheardParticipant> unheard;
  for (const auto& [process, held] : held_by) {
    const auto places = discovery_ports(held, ports);
    for (const std::uint16_t place : places) {
      if (!heard.contains(place)) {
        unheard.push_back({process, programs[process], place});
      }
    }
    const bool speaks = std::any_of(held.begin(), held.end(),
                                    [&](std::uint16_t port) { return heard.contains(port); });
    if (places.empty() && process != kOfOthers && !speaks &&
        held.contains(static_cast<std::uint16_t>(ports.multicast))) {
      unheard.push_back({process, programs[process], 0});
    }
  }
  return unheard;
}

/// Of the ports that a participant announces, those that its process holds. Fast DDS announces the
/// port that it tried first, too, where another process has it; the GUIDs that it gives (vendor
/// 1.15) have the lower half of the process id in bytes 4 and 5. All where that tells nothing.
std::set<std::uint16_t> held_ports(const Gid& participant, const std::set<std::uint16_t>& announced,
                                   const std::vector<BoundSocket>& sockets,
                                   const SocketOwners& owners) {
  const auto& bytes = participant.bytes;
  if (bytes[0] != 1 || bytes[1] != 15) {
    return announced;
  }
  const int process = bytes[4] | bytes[5] << 8;
  std::set<std::uint16_t> held;
  for (const BoundSocket& socket : sockets) {
    const auto owner = owners.find(socket.inode);
    if (announced.contains(socket.port) && owner != owners.end() &&
        (owner->second.process & 0xFFFF) == process) {
      held.insert(socket.port);
    }
  }
  return held.empty() ? announced : held;
}

bool has_reader(const fs::path& lock_of_port) {
  const int lock = open(lock_of_port.c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) {
    return false;
  }
  const bool locked = is_locked(lock);
  close(lock);
  return locked;
}

}  // namespace

std::vector<BoundSocket> bound_sockets(const fs::path& proc) {
  std::set<BoundSocket> sockets;
  // The kernel hands the list out page by page and counts where it was: a socket that is closed
  // meanwhile makes it pass over another one. Not over the same one twice.
  for (int reading = 0; reading < 2; ++reading) {
    std::ifstream file(proc / "self/net/udp");
    std::string line;
    std::getline(file, line);  // the names of the columns
    while (std::getline(file, line)) {
      if (const auto socket = read_socket(line)) {
        sockets.insert(*socket);
      }
    }
  }
  return {sockets.begin(), sockets.end()};
}

SocketOwners owners_of(const std::vector<BoundSocket>& sockets, const fs::path& proc) {
  std::set<std::uint64_t> wanted;
  for (const BoundSocket& socket : sockets) {
    wanted.insert(socket.inode);
  }
  SocketOwners owners;
  std::error_code error;
  for (fs::directory_iterator process(proc, error), end; !error && process != end;
       process.increment(error)) {
    const auto id = number<int>(process->path().filename().string());
    if (!id) {
      continue;
    }
    std::error_code unseen;  // a process of another user, or one that has ended
    for (fs::directory_iterator file(process->path() / "fd", unseen); !unseen && file != end;
         file.increment(unseen)) {
      std::error_code closed;
      const auto inode = socket_inode(fs::read_symlink(file->path(), closed).string());
      if (inode && wanted.contains(*inode)) {
        owners[*inode] = {*id, program_of(process->path())};
      }
    }
  }
  return owners;
}

Census::Result Census::count(const std::vector<BoundSocket>& sockets, const SocketOwners& owners,
                             const PortsByParticipant& discovered) {
  Result result;
  std::erase_if(inodes_, [&](const auto& entry) { return !discovered.contains(entry.first); });
  std::set<std::uint16_t> heard;
  for (const auto& [participant, announced] : discovered) {
    const auto ports = held_ports(participant, announced, sockets, owners);
    std::set<std::uint64_t> present;
    for (const BoundSocket& socket : sockets) {
      if (ports.contains(socket.port)) {
        present.insert(socket.inode);
      }
    }
    const auto& counted = inodes_.try_emplace(participant, present).first->second;
    const bool is_here = std::any_of(counted.begin(), counted.end(),
                                     [&](std::uint64_t inode) { return present.contains(inode); });
    if (is_here) {
      heard.insert(ports.begin(), ports.end());
    } else if (!ports.empty()) {
      result.departed.push_back(participant);
    }
  }
  result.unheard = unheard_participants(sockets, owners, heard, domain_);
  return result;
}

std::vector<std::uint16_t> ports_of_shared_memory_alone(const std::vector<BoundSocket>& sockets,
                                                        std::uint32_t domain,
                                                        const fs::path& folder) {
  std::set<std::uint16_t> over_udp;
  for (const BoundSocket& socket : sockets) {
    over_udp.insert(socket.port);
  }
  std::vector<std::uint16_t> alone;
  const Ports ports(domain);
  for (std::uint32_t port = ports.first_unicast; port <= ports.last_unicast; port += 2) {
    const auto place = static_cast<std::uint16_t>(port);
    if (!over_udp.contains(place) &&
        has_reader(folder / ("fastrtps_port" + std::to_string(place) + "_el"))) {
      alone.push_back(place);
    }
  }
  return alone;
}

}  // namespace pipescout::dds
