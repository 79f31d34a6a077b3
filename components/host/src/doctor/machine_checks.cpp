// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "doctor/checks.hpp"

namespace pipescout::host::doctor {
namespace {

constexpr std::uintmax_t kMegabyte = std::uintmax_t{1} << 20U;
// A process takes 32 MB, or an eighth of what is free, and images a block for each publisher.
constexpr std::uintmax_t kAmpleSharedMemory = 256 * kMegabyte;
constexpr std::uintmax_t kLeastSharedMemory = 16 * kMegabyte;
// Less than a minute, and less than a quarter of an hour, of a thermal and a colour camera.
constexpr std::uintmax_t kLeastDisk = 1024 * kMegabyte;
constexpr std::uintmax_t kAmpleDisk = 20 * 1024 * kMegabyte;
constexpr int kEthernetMtu = 1500;  // bytes

std::string megabytes(std::uintmax_t bytes) {
  return std::to_string(bytes / kMegabyte) + " MB";
}

}  // namespace

std::vector<Finding> check_shared_memory(const Observation& seen) {
  if (!seen.machine || seen.machine->shared_memory_free >= kAmpleSharedMemory) {
    return {};
  }
  const auto free = seen.machine->shared_memory_free;
  return {{free < kLeastSharedMemory ? Severity::kError : Severity::kWarning,
           "/dev/shm has " + megabytes(free) + " free of " +
               megabytes(seen.machine->shared_memory_total) +
               ": messages to other processes go over UDP, or have to be sent again.",
           "Make it larger: docker run --shm-size=512m, or mount -o remount,size=512m /dev/shm."}};
}

std::vector<Finding> check_network(const Observation& seen) {
  std::vector<Finding> findings;
  if (!seen.unreachable_network.empty()) {
    findings.push_back({Severity::kError,
                        "There is no joining the network: " + seen.unreachable_network + ".",
                        "Mend what is named here or below; the running system was not looked at."});
  }
  if (!seen.machine) {
    return findings;
  }
  const auto& interfaces = seen.machine->interfaces;
  if (std::none_of(interfaces.begin(), interfaces.end(),
                   [](const Interface& each) { return each.loopback; })) {
    findings.push_back({Severity::kError,
                        "The loopback interface is missing or down: processes of this machine do "
                        "not find each other.",
                        "Bring it up: ip link set lo up."});
  }
  if (seen.machine->localhost_only) {
    return findings;
  }
  for (const auto& interface : interfaces) {
    if (interface.loopback) {
      continue;
    }
    if (interface.mtu < kEthernetMtu) {
      findings.push_back({Severity::kWarning,
                          "The MTU of " + interface.name + " is " + std::to_string(interface.mtu) +
                              " bytes: large messages are cut into many datagrams.",
                          "Set it to 1500 on all machines (ip link set " + interface.name +
                              " mtu 1500), unless a tunnel needs less."});
    }
    if (!interface.multicast) {
      findings.push_back({Severity::kWarning,
                          "The interface " + interface.name +
                              " has no multicast: other machines are not found through it.",
                          "Turn it on (ip link set " + interface.name +
                              " multicast on), or use a discovery server."});
    }
  }
  if (!seen.machine->has_network()) {
    findings.push_back({Severity::kWarning, "No network interface but the loopback is up.",
                        "Connect the network, or set ROS_LOCALHOST_ONLY=1 if that is meant."});
  }
  return findings;
}

std::vector<Finding> check_disk(const Observation& seen) {
  if (!seen.machine || seen.machine->recording_free >= kAmpleDisk) {
    return {};
  }
  const auto free = seen.machine->recording_free;
  return {{free < kLeastDisk ? Severity::kError : Severity::kWarning,
           seen.machine->recording_folder + " has " + megabytes(free) +
               " free for a recording, which images fill within minutes.",
           "Free some space, or record to another disk (--out)."}};
}

}  // namespace pipescout::host::doctor
