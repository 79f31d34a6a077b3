// SPDX-License-Identifier: Apache-2.0
#include "discovery_choice.hpp"

#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastrtps/utils/IPFinder.h>
#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <optional>
#include <string>

namespace pipescout::dds {
namespace {

using eprosima::fastrtps::rtps::IPLocator;

// Of the standard, for discovery by multicast.
constexpr const char* kDiscoveryGroup = "239.255.0.1";

// A participant tells this often that it is there, and so is found again after a link was down. The
// default of Fast DDS is 3 s.
const eprosima::fastrtps::Duration_t kAnnouncementPeriod{1, 0};

// Participants of a peer that are spoken to at their ports: those of a composition and of some of
// its isolated components. The others make themselves known once they hear of this one.
constexpr std::uint32_t kParticipantsOfAPeer = 8;

std::optional<std::string> ipv4_address(const std::string& host) {
  if (IPLocator::isIPv4(host)) {
    return host;
  }
  const auto [ipv4, ipv6] = IPLocator::resolveNameDNS(host);
  return ipv4.empty() ? std::nullopt : std::optional(*ipv4.begin());
}

/// Port 0: Fast DDS takes those that the standard gives to the first participants of the domain on
/// a host, also where the address is that of a group: one datagram more for each of them.
rtps::Locator_t udp_locator(const std::string& address, std::uint32_t port) {
  rtps::Locator_t locator;
  IPLocator::createLocator(LOCATOR_KIND_UDPv4, address, port, locator);
  return locator;
}

/// A server of this machine is spoken to on the loopback address. Fast DDS 2.9 does so by itself
/// with the address of another interface, but forgets it when the participant's user data change,
/// and the statistics of Debian's build end the process then.
std::string reachable_address(const std::string& address) {
  constexpr const char* kLoopback = "127.0.0.1";
  return is_of_this_machine(udp_locator(address, 0)) ? kLoopback : address;
}

void ask_servers(const DdsOptions& options, Warnings& warnings, rtps::DiscoverySettings& settings) {
  settings.discoveryProtocol = options.super_client ? rtps::DiscoveryProtocol_t::SUPER_CLIENT
                                                    : rtps::DiscoveryProtocol_t::CLIENT;
  for (const auto& server : options.discovery_servers) {
    const auto address = ipv4_address(server.host);
    if (!address) {
      warnings.add("discovery server " + to_string(server) +
                   ": the name of this host cannot be resolved; only a new start tries again");
      continue;
    }
    rtps::RemoteServerAttributes remote;
    rtps::get_server_client_default_guidPrefix(server.id, remote.guidPrefix);
    remote.metatrafficUnicastLocatorList.push_back(
        udp_locator(reachable_address(*address), server.port));
    settings.m_DiscoveryServers.push_back(remote);
  }
}

/// By multicast, and by unicast to the processes of this machine (a loopback interface often has
/// no multicast, and a participant of another vendor that is not spoken to tells of itself only
/// every 8 s or so) and to the peers.
void seek(const DdsOptions& options, Warnings& warnings, rtps::BuiltinAttributes& builtin) {
  const rtps::PortParameters ports;
  builtin.initialPeersList.push_back(
      udp_locator(kDiscoveryGroup, ports.getMulticastPort(options.domain_id)));
  builtin.initialPeersList.push_back(udp_locator("127.0.0.1", 0));
  for (const std::string& host : options.static_peers) {
    const auto address = ipv4_address(host);
    if (!address) {
      warnings.add("peer " + host +
                   ": the name of this host cannot be resolved; only a new start tries again");
      continue;
    }
    for (std::uint32_t participant = 0; participant < kParticipantsOfAPeer; ++participant) {
      builtin.initialPeersList.push_back(
          udp_locator(*address, ports.getUnicastPort(options.domain_id, participant)));
    }
  }
}

}  // namespace

bool is_of_this_machine(const rtps::Locator_t& locator) {
  if (locator.kind != LOCATOR_KIND_UDPv4) {
    return false;
  }
  rtps::LocatorList_t addresses;
  rtps::IPFinder::getAllIPAddress(&addresses);
  return IPLocator::isLocal(locator) ||
         std::any_of(addresses.begin(), addresses.end(), [&](const auto& address) {
           return IPLocator::compareAddress(address, locator);
         });
}

void choose_discovery(const DdsOptions& options, Warnings& warnings,
                      fastdds::DomainParticipantQos& qos) {
  auto& builtin = qos.wire_protocol().builtin;
  auto& settings = builtin.discovery_config;
  if (settings.discoveryProtocol != rtps::DiscoveryProtocol_t::SIMPLE ||
      !builtin.initialPeersList.empty()) {
    return;
  }
  settings.leaseDuration_announcementperiod = kAnnouncementPeriod;
  if (options.discovery_servers.empty()) {
    seek(options, warnings, builtin);
  } else {
    ask_servers(options, warnings, settings);
  }
}

}  // namespace pipescout::dds
