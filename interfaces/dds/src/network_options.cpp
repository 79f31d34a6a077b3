// SPDX-License-Identifier: Apache-2.0
#include "pipescout/dds/network_options.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace pipescout {
namespace {

constexpr std::size_t kMostServers = std::numeric_limits<std::uint8_t>::max() + std::size_t{1};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

void for_each_entry(std::string_view list, const std::function<void(std::string_view)>& call) {
  for (;;) {
    const auto end = list.find(';');
    call(trimmed(list.substr(0, end)));
    if (end == std::string_view::npos) {
      return;
    }
    list.remove_prefix(end + 1);
  }
}

[[noreturn]] void refuse_entry(std::string_view entry, const std::string& expected) {
  throw std::invalid_argument("'" + std::string(entry) + "': must be " + expected);
}

/// Of letters, digits, '-' and '.', as RFC 1123 has them; '_' is seen in practice.
bool is_host(std::string_view text) {
  return !text.empty() && text.front() != '-' && text.front() != '.' &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '_';
         });
}

std::uint16_t parse_port(std::string_view entry, std::string_view text) {
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, port);
  if (error != std::errc{} || parsed != end || port == 0) {
    refuse_entry(entry, "HOST or HOST:PORT with a port in 1..65535");
  }
  return port;
}

void add_peer(std::vector<std::string>& peers, std::string_view host) {
  if (std::find(peers.begin(), peers.end(), host) == peers.end()) {
    peers.emplace_back(host);
  }
}

void read_peers(const std::string& path, std::vector<std::string>& peers) {
  std::ifstream file(path);
  if (!file) {
    throw std::invalid_argument(path + ": cannot read this file of peers");
  }
  std::string text;
  for (int line = 1; std::getline(file, text); ++line) {
    const auto host = trimmed(std::string_view(text).substr(0, text.find('#')));
    if (host.empty()) {
      continue;
    }
    if (!is_host(host)) {
      throw std::invalid_argument(path + ":" + std::to_string(line) + ": '" + std::string(host) +
                                  "': must be an IPv4 address or the name of a host");
    }
    add_peer(peers, host);
  }
  if (file.bad()) {
    throw std::invalid_argument(path + ": cannot read this file of peers");
  }
}

}  // namespace

std::string to_string(const DiscoveryServerAddress& server) {
  return server.host + ":" + std::to_string(server.port);
}

std::vector<DiscoveryServerAddress> parse_discovery_servers(std::string_view text) {
  std::vector<DiscoveryServerAddress> servers;
  std::size_t id = 0;
  for_each_entry(text, [&](std::string_view entry) {
    if (!entry.empty()) {
      if (id >= kMostServers) {
        refuse_entry(entry, "one of the first 256 servers of the list");
      }
      DiscoveryServerAddress server;
      server.id = static_cast<std::uint8_t>(id);
      const auto colon = entry.find(':');
      server.host = entry.substr(0, colon);
      if (!is_host(server.host)) {
        refuse_entry(entry,
                     "HOST or HOST:PORT, with an IPv4 address or the name of a host (IPv6 and TCP "
                     "need a profile of Fast DDS)");
      }
      if (colon != std::string_view::npos) {
        server.port = parse_port(entry, entry.substr(colon + 1));
      }
      servers.push_back(std::move(server));
    }
    ++id;
  });
  return servers;
}

std::vector<std::string> parse_static_peers(std::string_view text) {
  std::vector<std::string> peers;
  for_each_entry(text, [&](std::string_view entry) {
    if (entry.starts_with('/')) {
      read_peers(std::string(entry), peers);
    } else if (is_host(entry)) {
      add_peer(peers, entry);
    } else if (!entry.empty()) {
      refuse_entry(entry,
                   "an IPv4 address, the name of a host, or the absolute path of a file of them");
    }
  });
  return peers;
}

NetworkProfile parse_network_profile(std::string_view text) {
  constexpr std::string_view kWifi = "wifi";
  NetworkProfile profile;
  if (text == "wire") {
    return profile;
  }
  profile.kind = NetworkProfile::Kind::kWifi;
  if (text == kWifi) {
    return profile;
  }
  if (text.starts_with("wifi:")) {
    const auto rate = text.substr(kWifi.size() + 1);
    const char* end = rate.data() + rate.size();
    const auto [parsed, error] = std::from_chars(rate.data(), end, profile.rate);
    if (error == std::errc{} && parsed == end && profile.rate >= NetworkProfile::kLowestRate &&
        profile.rate <= NetworkProfile::kHighestRate) {
      return profile;
    }
  }
  refuse_entry(text, "wire, wifi, or wifi:RATE with a rate in 0.1..1000 (Mbit/s)");
}

}  // namespace pipescout
