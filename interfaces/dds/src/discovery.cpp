// SPDX-License-Identifier: Apache-2.0
#include "discovery.hpp"

#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>

#include <algorithm>
#include <string_view>
#include <utility>

#include "contain.hpp"
#include "discovery_choice.hpp"

namespace pipescout::dds {
namespace {

// As ROS 2 sends it: "enclave=/some/name;", alone or among other "key=value;" pairs.
constexpr std::string_view kEnclaveKey = "enclave=";

// The value of a key, which ends with '='; empty when it is not there.
std::string value_in(const std::vector<rtps::octet>& user_data, std::string_view key) {
  const std::string_view text(reinterpret_cast<const char*>(user_data.data()), user_data.size());
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(';', begin), text.size());
    const std::string_view pair = text.substr(begin, end - begin);
    if (pair.starts_with(key)) {
      return std::string(pair.substr(key.size()));
    }
    begin = end + 1;
  }
  return {};
}

std::string announced_scope(const eprosima::fastrtps::ParameterPropertyList_t& properties) {
  for (const auto& property : properties) {
    if (property.first() == kPayloadScopeProperty) {
      return property.second();
    }
  }
  return {};
}

/// The UDP ports of an address of this machine at which a participant takes discovery messages.
std::set<std::uint16_t> ports_of_this_machine(const rtps::ParticipantProxyData& data) {
  std::set<std::uint16_t> ports;
  for (const rtps::Locator_t& locator : data.metatraffic_locators.unicast) {
    if (is_of_this_machine(locator)) {
      ports.insert(rtps::IPLocator::getPhysicalPort(locator));
    }
  }
  return ports;
}

bool is_on_loopback_alone(const rtps::ParticipantProxyData& data) {
  const auto& places = data.metatraffic_locators.unicast;
  return !places.empty() &&
         std::all_of(places.begin(), places.end(), [](const rtps::Locator_t& locator) {
           return locator.kind == LOCATOR_KIND_UDPv4 && rtps::IPLocator::isLocal(locator);
         });
}

template <class ProxyData>
DiscoveredEndpoint describe(const ProxyData& data, bool is_writer) {
  DiscoveredEndpoint endpoint;
  endpoint.gid = to_gid(data.guid());
  endpoint.participant =
      to_gid(rtps::GUID_t(data.guid().guidPrefix, rtps::c_EntityId_RTPSParticipant));
  endpoint.is_writer = is_writer;
  endpoint.topic = data.topicName().to_string();
  endpoint.type = data.typeName().to_string();
  endpoint.qos = announced_qos(data);
  return endpoint;
}

}  // namespace

bool Discovery::take_payloads(const std::set<Gid>& endpoints) const {
  const std::lock_guard lock(mutex_);
  return std::all_of(endpoints.begin(), endpoints.end(), [this](const Gid& endpoint) {
    return payload_takers_.contains(prefix_of(endpoint));
  });
}

bool Discovery::knows(const Gid& participant) const {
  const std::lock_guard lock(mutex_);
  return participants_.contains(participant);
}

std::vector<DiscoveredParticipant> Discovery::participants() const {
  const std::lock_guard lock(mutex_);
  std::vector<DiscoveredParticipant> result;
  result.reserve(participants_.size());
  for (const auto& [gid, participant] : participants_) {
    result.push_back(participant);
  }
  return result;
}

std::vector<DiscoveredEndpoint> Discovery::endpoints() const {
  const std::lock_guard lock(mutex_);
  std::vector<DiscoveredEndpoint> result;
  result.reserve(endpoints_.size());
  for (const auto& [gid, endpoint] : endpoints_) {
    // Fast DDS may tell of an endpoint shortly before its participant.
    if (participants_.contains(endpoint.participant)) {
      result.push_back(endpoint);
    }
  }
  return result;
}

PortsByParticipant Discovery::ports_of_this_machine() const {
  const std::lock_guard lock(mutex_);
  return ports_of_this_machine_;
}

void Discovery::forget(const Gid& participant) {
  const std::lock_guard lock(mutex_);
  erase(participant);
  graph_changed();
}

void Discovery::erase(const Gid& participant) {
  const GuidPrefix prefix = prefix_of(participant);
  participants_.erase(participant);
  ports_of_this_machine_.erase(participant);
  payload_takers_.erase(prefix);
  payloads_.forget(prefix);
  std::erase_if(endpoints_,
                [&](const auto& entry) { return same_participant(entry.first, participant); });
}

void Discovery::on_graph_changed(GraphChanged callback) {
  {
    const std::lock_guard lock(mutex_);
    callback_ = nullptr;
  }
  events_.dismiss(this);
  if (!callback) {
    return;
  }
  events_.admit(this);
  const std::lock_guard lock(mutex_);
  callback_ = std::move(callback);
  event_pending_ = false;
  graph_changed();  // it may have, unheard
}

void Discovery::add(LocalEndpoint endpoint) {
  const std::lock_guard lock(mutex_);
  local_.push_back(std::move(endpoint));
  for (const auto& [gid, remote] : endpoints_) {
    compare(local_.back(), remote);
  }
}

void Discovery::remove(const void* owner) {
  const std::lock_guard lock(mutex_);
  std::erase_if(local_, [owner](const LocalEndpoint& local) { return local.owner == owner; });
}

void Discovery::on_participant_discovery(fastdds::DomainParticipant* participant,
                                         rtps::ParticipantDiscoveryInfo&& info) {
  contain("participant discovery", [&] {
    const Gid gid = to_gid(info.info.m_guid);
    if (same_participant(gid, to_gid(participant->guid()))) {
      return;
    }
    const bool is_gone = info.status == rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT ||
                         info.status == rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT;
    if (announcements_) {
      announcements_->hear(
          gid, is_gone ? std::string() : value_in(info.info.m_userData, kAnnouncementKey));
    }
    auto ports = dds::ports_of_this_machine(info.info);
    const std::lock_guard lock(mutex_);
    switch (info.status) {
      case rtps::ParticipantDiscoveryInfo::DISCOVERED_PARTICIPANT:
      case rtps::ParticipantDiscoveryInfo::CHANGED_QOS_PARTICIPANT:
        participants_[gid] = {.gid = gid,
                              .name = info.info.m_participantName.to_string(),
                              .enclave = value_in(info.info.m_userData, kEnclaveKey),
                              .is_on_loopback_alone = is_on_loopback_alone(info.info)};
        ports_of_this_machine_[gid] = std::move(ports);
        if (!payload_scope_.empty() && announced_scope(info.info.m_properties) == payload_scope_) {
          payload_takers_.insert(prefix_of(gid));
        }
        break;
      case rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT:
      case rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT:
        erase(gid);
        break;
    }
    graph_changed();
  });
}

void Discovery::on_subscriber_discovery(fastdds::DomainParticipant* participant,
                                        rtps::ReaderDiscoveryInfo&& info) {
  contain("reader discovery", [&] {
    const Gid gid = to_gid(info.info.guid());
    if (same_participant(gid, to_gid(participant->guid()))) {
      return;
    }
    if (info.status == rtps::ReaderDiscoveryInfo::REMOVED_READER) {
      endpoint_removed(gid);
    } else {
      endpoint_discovered(describe(info.info, false));
    }
  });
}

void Discovery::on_publisher_discovery(fastdds::DomainParticipant* participant,
                                       rtps::WriterDiscoveryInfo&& info) {
  contain("writer discovery", [&] {
    const Gid gid = to_gid(info.info.guid());
    if (same_participant(gid, to_gid(participant->guid()))) {
      return;
    }
    if (info.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER) {
      endpoint_removed(gid);
    } else {
      endpoint_discovered(describe(info.info, true));
    }
  });
}

void Discovery::endpoint_discovered(DiscoveredEndpoint endpoint) {
  const std::lock_guard lock(mutex_);
  const auto known = endpoints_.find(endpoint.gid);
  if (known != endpoints_.end() && known->second.qos == endpoint.qos) {
    return;
  }
  for (const LocalEndpoint& local : local_) {
    compare(local, endpoint);
  }
  endpoints_[endpoint.gid] = std::move(endpoint);
  graph_changed();
}

void Discovery::endpoint_removed(const Gid& gid) {
  const std::lock_guard lock(mutex_);
  if (endpoints_.erase(gid) > 0) {
    graph_changed();
  }
}

void Discovery::compare(const LocalEndpoint& local, const DiscoveredEndpoint& remote) {
  if (local.is_writer == remote.is_writer || local.topic != remote.topic ||
      local.type != remote.type) {
    return;
  }
  const auto policy = local.is_writer ? incompatibility(local.qos, remote.qos)
                                      : incompatibility(remote.qos, local.qos);
  if (policy) {
    events_.post(local.owner,
                 [report = local.on_incompatible, policy = *policy] { report(policy); });
  }
}

// Under mutex_. Many changes at once become one call.
void Discovery::graph_changed() {
  if (!callback_ || event_pending_) {
    return;
  }
  event_pending_ = true;
  events_.post(this, [this] {
    GraphChanged callback;
    {
      const std::lock_guard lock(mutex_);
      event_pending_ = false;
      callback = callback_;
    }
    if (callback) {
      callback();
    }
  });
}

}  // namespace pipescout::dds
