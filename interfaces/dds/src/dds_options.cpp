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

// What rcl takes silently for "off" or "permissive" is refused here: a misspelt word must not open
// the network.
bool chosen(const char* name, const char* yes, const char* no) {
  const std::string_view value = environment(name);
  if (!value.empty() && value != yes && value != no) {
    refuse(name, value, std::string(yes) + " or " + no);
  }
  return value == yes;
}

/// Hands the value of a variable that is set to `parse`; names the variable in what that throws.
template <class Parse>
void read_variable(const char* name, const Parse& parse) {
  if (const std::string_view value = environment(name); !value.empty()) {
    try {
      parse(value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string(name) + ": " + error.what());
    }
  }
}

// Fast DDS 2.9 does not know this variable of later versions.
bool parse_super_client(std::string_view value) {
  const bool is_true = value == "TRUE" || value == "true" || value == "1";
  if (!is_true && value != "FALSE" && value != "false" && value != "0") {
    refuse("ROS_SUPER_CLIENT", value, "TRUE or FALSE");
  }
  return is_true;
}

void read_network(DdsOptions& options) {
  read_variable("ROS_DISCOVERY_SERVER", [&](std::string_view value) {
    options.discovery_servers = parse_discovery_servers(value);
  });
  if (const std::string_view value = environment("ROS_SUPER_CLIENT"); !value.empty()) {
    options.super_client = parse_super_client(value);
  }
  read_variable("ROS_STATIC_PEERS",
                [&](std::string_view value) { options.static_peers = parse_static_peers(value); });
  read_variable("PIPESCOUT_NETWORK",
                [&](std::string_view value) { options.network = parse_network_profile(value); });
}

SecurityOptions security_from_environment() {
  SecurityOptions security;
  security.enabled = chosen("ROS_SECURITY_ENABLE", "true", "false");
  security.enforce = chosen("ROS_SECURITY_STRATEGY", "Enforce", "Permissive");
  security.strict_keys = chosen("PIPESCOUT_STRICT_KEYS", "true", "false");
  security.keystore = environment("ROS_SECURITY_KEYSTORE");
  security.enclave_override = environment("ROS_SECURITY_ENCLAVE_OVERRIDE");
  return security;
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
  read_network(options);
  options.security = security_from_environment();
  return options;
}

}  // namespace pipescout
