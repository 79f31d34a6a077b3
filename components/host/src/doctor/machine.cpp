// SPDX-License-Identifier: Apache-2.0
#include "doctor/machine.hpp"

#include <ifaddrs.h>
#include <net/if.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>
#include <system_error>

namespace pipescout::host::doctor {
namespace {

namespace fs = std::filesystem;

std::vector<Interface> interfaces() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return {};
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, freeifaddrs);
  std::map<std::string, Interface> found;  // one has several addresses
  for (const ifaddrs* each = list; each != nullptr; each = each->ifa_next) {
    if ((each->ifa_flags & IFF_UP) == 0U) {
      continue;
    }
    Interface interface;
    interface.name = each->ifa_name;
    interface.loopback = (each->ifa_flags & IFF_LOOPBACK) != 0U;
    interface.multicast = (each->ifa_flags & IFF_MULTICAST) != 0U;
    std::ifstream("/sys/class/net/" + interface.name + "/mtu") >> interface.mtu;
    if (interface.mtu > 0) {
      found.emplace(interface.name, interface);
    }
  }
  std::vector<Interface> result;
  for (auto& [name, interface] : found) {
    result.push_back(std::move(interface));
  }
  return result;
}

/// The folder, or the nearest one above it that exists.
fs::path existing(fs::path folder) {
  std::error_code error;
  while (!fs::exists(folder, error) && folder.has_relative_path()) {
    folder = folder.parent_path();
  }
  return folder;
}

}  // namespace

Machine look_at_machine(const fs::path& folder) {
  Machine machine;
  std::error_code error;
  if (const auto space = fs::space("/dev/shm", error); !error) {
    machine.shared_memory_total = space.capacity;
    machine.shared_memory_free = space.available;
  }
  machine.recording_folder = existing(fs::absolute(folder)).string();
  if (const auto space = fs::space(machine.recording_folder, error); !error) {
    machine.recording_free = space.available;
  }
  machine.interfaces = interfaces();
  const char* const localhost = std::getenv("ROS_LOCALHOST_ONLY");
  machine.localhost_only = localhost != nullptr && std::string_view(localhost) == "1";
  return machine;
}

}  // namespace pipescout::host::doctor
