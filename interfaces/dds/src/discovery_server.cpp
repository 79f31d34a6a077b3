// SPDX-License-Identifier: Apache-2.0
#include "pipescout/dds/discovery_server.hpp"

#include <arpa/inet.h>
#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>

#include <cerrno>
#include <system_error>

#include "discovery.hpp"
#include "event_thread.hpp"
#include "network_profile.hpp"
#include "rtps_conversions.hpp"

namespace pipescout {
namespace dds {
namespace {

// After this time without an announcement participants know that the server is gone.
const eprosima::fastrtps::Duration_t kLease{3, 0};
const eprosima::fastrtps::Duration_t kServerAnnouncements{0, 700'000'000};

rtps::GuidPrefix_t prefix_of_server(std::uint8_t id) {
  rtps::GuidPrefix_t prefix;
  rtps::get_server_client_default_guidPrefix(id, prefix);
  return prefix;
}

/// Fast DDS itself goes on without a port that it does not get.
void check_port(const DiscoveryServerOptions& options) {
  const std::string place = options.address + ":" + std::to_string(options.port);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  if (inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1) {
    throw TransportError("discovery server: '" + options.address + "' is no IPv4 address");
  }
  const int socket_descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const bool is_free =
      socket_descriptor >= 0 &&
      bind(socket_descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int error = errno;
  if (socket_descriptor >= 0) {
    close(socket_descriptor);
  }
  if (!is_free) {
    throw TransportError("discovery server: cannot listen on " + place + ": " +
                         std::generic_category().message(error));
  }
}

class FastDdsServer final : public DiscoveryServer {
 public:
  explicit FastDdsServer(const DiscoveryServerOptions& options) {
    check_port(options);
    fastdds::DomainParticipantQos qos;
    qos.name("pipescout discovery server " + std::to_string(options.id));
    qos.wire_protocol().prefix = prefix_of_server(options.id);
    qos.transport().use_builtin_transports = false;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    apply(options.network, 0, *udp);
    apply_to_server(options.network, qos);
    qos.transport().user_transports.push_back(udp);
    auto& builtin = qos.wire_protocol().builtin;
    builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    builtin.writerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    builtin.discovery_config.discoveryProtocol = rtps::DiscoveryProtocol_t::SERVER;
    builtin.discovery_config.leaseDuration = kLease;
    builtin.discovery_config.leaseDuration_announcementperiod = kServerAnnouncements;
    rtps::Locator_t listener;
    rtps::IPLocator::createLocator(LOCATOR_KIND_UDPv4, options.address, options.port, listener);
    builtin.metatrafficUnicastLocatorList.push_back(listener);
    participant_ = fastdds::DomainParticipantFactory::get_instance()->create_participant(
        options.domain_id, qos, &discovery_, fastdds::StatusMask::none());
    if (participant_ == nullptr) {
      throw TransportError("discovery server: cannot create a participant");
    }
  }
  FastDdsServer(const FastDdsServer&) = delete;
  FastDdsServer& operator=(const FastDdsServer&) = delete;
  ~FastDdsServer() override {
    participant_->set_listener(nullptr);
    fastdds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  std::vector<DiscoveredParticipant> participants() const override {
    return discovery_.participants();
  }

 private:
  EventThread events_;
  Discovery discovery_{events_};
  fastdds::DomainParticipant* participant_ = nullptr;
};

}  // namespace
}  // namespace dds

std::unique_ptr<DiscoveryServer> start_discovery_server(const DiscoveryServerOptions& options) {
  return std::make_unique<dds::FastDdsServer>(options);
}

Gid discovery_server_identity(std::uint8_t id) {
  return dds::to_gid(
      dds::rtps::GUID_t(dds::prefix_of_server(id), dds::rtps::c_EntityId_RTPSParticipant));
}

}  // namespace pipescout
