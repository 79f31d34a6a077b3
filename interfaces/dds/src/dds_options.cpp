// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "pipescout/dds/dds_transport.hpp"

namespace pipescout {
namespace {

constexpr std::uint32_t kHighestDomain = 232;  // of which the ports fit into 16 bits

// Set but empty counts as not set, as in ROS 2.
std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view{} : std::string_view{value};
}

[[noreturn]] void refuse(const char* name, std::string_view value, std::string_view expected) {
  throw std::invalid_argument(std::string(name) + "='" + std::string(value) + "': must be " +
                              std::string(expected));
}

}  // namespace

DdsOptions DdsOptions::from_environment() {
  DdsOptions options;
  constexpr const char* kDomain = "ROS_DOMAIN_ID";
  if (const std::string_view value = environment(kDomain); !value.empty()) {
    const char* end = value.data() + value.size();
    const auto [parsed, error] = std::from_chars(value.data(), end, options.domain_id);
    if (error != std::errc{} || parsed != end || options.domain_id > kHighestDomain) {
      refuse(kDomain, value, "a whole number in 0.." + std::to_string(kHighestDomain));
    }
  }
  constexpr const char* kLocalhost = "ROS_LOCALHOST_ONLY";
  if (const std::string_view value = environment(kLocalhost); !value.empty()) {
    if (value != "0" && value != "1") {
      refuse(kLocalhost, value, "0 or 1");
    }
    options.localhost_only = value == "1";
  }
  return options;
}

}  // namespace pipescout
