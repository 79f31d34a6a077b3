// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <unistd.h>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "discovery_choice.hpp"
#include "network_profile.hpp"
#include "security.hpp"
#include "shared_memory.hpp"
#include "shortcut_transport.hpp"
#include "wire_type.hpp"

namespace pipescout::dds {
namespace {

using eprosima::fastrtps::types::ReturnCode_t;

// Ports are 7400 + 250 * domain + ..., and Fast DDS ends the process when one exceeds 65535.
constexpr std::uint32_t kHighestDomain = 232;

// To which a participant announces itself by unicast: as many as ROS 2 takes from Iron on.
constexpr std::uint32_t kParticipantsOfAMachine = 32;

std::string in_megabytes(std::uintmax_t bytes) {
  constexpr std::uintmax_t kMegabyte = std::uintmax_t{1} << 20U;
  return bytes < kMegabyte ? "less than 1 MB" : std::to_string(bytes / kMegabyte) + " MB";
}

constexpr const char* kMakeRoom = "; make it larger (docker run --shm-size=...)";

void choose_transports(const DdsOptions& options, const std::shared_ptr<Warnings>& warnings,
                       std::uint32_t handshake_bytes, fastdds::DomainParticipantQos& qos) {
  auto& transport = qos.transport();
  transport.use_builtin_transports = false;
  auto udp = std::make_shared<ShortcutTransportDescriptor>();
  udp->maxInitialPeersRange = kParticipantsOfAMachine;
  udp->sendBufferSize = transport.send_socket_buffer_size;
  udp->receiveBufferSize = transport.listen_socket_buffer_size;
  udp->warnings = warnings;
  apply(options.network, handshake_bytes, *udp);
  if (options.localhost_only) {
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
  }
  transport.user_transports.push_back(udp);
  remove_abandoned_segments();
  const auto segment = fitting_segment_bytes(options.shared_memory_segment_bytes);
  if (!segment) {
    warnings->add("no space in " + std::string(kSharedMemoryFolder) +
                  ": messages to other processes of this machine go over UDP" + kMakeRoom);
    udp->has_shared_memory = false;
    return;
  }
  if (*segment < options.shared_memory_segment_bytes) {
    warnings->add("little space in " + std::string(kSharedMemoryFolder) + ": the segment for " +
                  "messages to other processes of this machine has " + in_megabytes(*segment) +
                  " instead of " + in_megabytes(options.shared_memory_segment_bytes) + kMakeRoom);
  }
  udp->shared_memory.segment_size(*segment);
}

/// As ROS 2 sends it, with a key of ours behind that of ROS 2.
fastdds::UserDataQosPolicy user_data(const std::string& enclave, const std::string& announced) {
  std::string text = "enclave=" + enclave + ";";
  if (!announced.empty()) {
    text += std::string(kAnnouncementKey) + announced + ";";
  }
  fastdds::UserDataQosPolicy policy;
  policy.setValue({text.begin(), text.end()});
  return policy;
}

/// `announced_scope` gets the payload scope, if large messages may go through shared memory.
fastdds::DomainParticipantQos participant_qos(const DdsOptions& options,
                                              const std::shared_ptr<Warnings>& warnings,
                                              std::string& announced_scope,
                                              AppliedSecurity& security) {
  auto* factory = fastdds::DomainParticipantFactory::get_instance();
  factory->load_profiles();
  fastdds::DomainParticipantQos qos = factory->get_default_participant_qos();
  qos.name(options.name);
  qos.user_data() =
      user_data(effective_enclave(options),
                options.announcements ? options.announcements->text() : std::string());
  security = apply_security(options, *warnings, qos);
  // Discovery messages with long names outgrow the default of 5000 bytes.
  auto& builtin = qos.wire_protocol().builtin;
  builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  builtin.writerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  apply(options.network, security.handshake_bytes, qos);
  if (!qos.transport().use_builtin_transports || !qos.transport().user_transports.empty()) {
    return qos;  // the user's profile has chosen
  }
  choose_transports(options, warnings, security.handshake_bytes, qos);
  choose_discovery(options, *warnings, qos);
  // The blocks are readable by their user alone, who could read the private key as well.
  if (const auto scope = payload_scope()) {
    announced_scope = *scope;
    qos.properties().properties().emplace_back(kPayloadScopeProperty, *scope, true);
  }
  return qos;
}

/// That of the processes that share the memory of this machine, or of this one alone.
std::string machine_partition() {
  const auto scope = payload_scope();
  return "pipescout machine " + (scope ? *scope : "of process " + std::to_string(getpid()));
}

// Asks for the profiles that rmw_fastrtps asks for, the last one counts: those of a topic by its
// ROS 2 name, those of a service by "service" or "client" and by the name on the wire.
template <class Load>
void load_profiles(const std::string& wire_name, const char* of_request, const char* of_reply,
                   const Load& load) {
  if (wire_name.starts_with("rt/")) {
    load(wire_name.substr(2));
    return;
  }
  if (wire_name.starts_with("rq/")) {
    load(of_request);
  } else if (wire_name.starts_with("rr/")) {
    load(of_reply);
  }
  load(wire_name);
}

}  // namespace

Participant::Participant(const DdsOptions& options)
    : domain_(options.domain_id),
      network_(options.network),
      is_found_by_server_(!options.discovery_servers.empty()),
      exported_topics_(options.exported_topics),
      announcements_(options.announcements),
      discovery_(events_, options.announcements),
      census_(options.domain_id) {
  const std::string domain = "DDS domain " + std::to_string(options.domain_id);
  if (options.domain_id > kHighestDomain) {
    throw TransportError(domain + ": must be in 0.." + std::to_string(kHighestDomain));
  }
  std::string scope;
  AppliedSecurity security;
  const fastdds::DomainParticipantQos qos = participant_qos(options, warnings_, scope, security);
  discovery_.share_payloads(scope);
  auto* factory = fastdds::DomainParticipantFactory::get_instance();
  participant_ =
      factory->create_participant(options.domain_id, qos, &discovery_, fastdds::StatusMask::none());
  if (participant_ == nullptr) {
    throw TransportError(domain + ": cannot create a participant");
  }
  gid_ = to_gid(participant_->guid());
  if (announcements_) {
    announcements_->connect([this, enclave = effective_enclave(options)](const std::string& text) {
      fastdds::DomainParticipantQos changed = participant_->get_qos();
      changed.user_data() = user_data(enclave, text);
      if (participant_->set_qos(changed) != ReturnCode_t::RETCODE_OK) {
        EPROSIMA_LOG_ERROR(PIPESCOUT, "the announcement could not be changed");
      }
    });
  }
  if (!scope.empty()) {
    payload_folder_ = std::make_shared<PayloadFolder>(prefix_of(gid_), warnings_);
  }
  publisher_ = participant_->create_publisher(participant_->get_default_publisher_qos());
  fastdds::PublisherQos machine_qos = participant_->get_default_publisher_qos();
  fastdds::SubscriberQos subscriber_qos = participant_->get_default_subscriber_qos();
  if (options.exported_topics || (options.hears_unexported && security.may_use_any_partition)) {
    const std::string partition = machine_partition();
    machine_qos.partition().push_back(partition.c_str());
    subscriber_qos.partition().push_back("");
    subscriber_qos.partition().push_back(partition.c_str());
  }
  machine_publisher_ = participant_->create_publisher(machine_qos);
  subscriber_ = participant_->create_subscriber(subscriber_qos);
  if (publisher_ == nullptr || machine_publisher_ == nullptr || subscriber_ == nullptr) {
    leave();
    throw TransportError(domain + ": cannot create a publisher or subscriber");
  }
  if (!options.discovery_servers.empty()) {
    server_watch_.emplace(events_, discovery_, options.discovery_servers);
  }
  revocation_watch_.emplace(events_, security.revocations,
                            [warnings = warnings_, revocations = security.revocations,
                             changed = options.security.on_revocations_changed] {
                              warnings->add("DDS Security: " + revocations.string() +
                                            " has changed; only a new start obeys it");
                              if (changed) {
                                changed();
                              } else {
                                kill(getpid(), SIGTERM);
                              }
                            });
}

Participant::~Participant() {
  server_watch_.reset();
  leave();
}

std::vector<UnheardParticipant> Participant::take_census() {
  // In this order: who is discovered in between is taken for unheard, not for departed.
  const auto discovered = discovery_.ports_of_this_machine();
  const auto sockets = bound_sockets();
  const std::lock_guard lock(census_mutex_);
  auto [unheard, departed] = census_.count(sockets, owners_of(sockets), discovered);
  for (const Gid& participant : departed) {
    discovery_.forget(participant);
  }
  std::erase_if(unheard, [](const UnheardParticipant& each) { return each.process == getpid(); });
  for (const std::uint16_t port : ports_of_shared_memory_alone(sockets, domain_)) {
    unheard.push_back({.process = 0, .program = {}, .port = port, .has_no_udp = true});
  }
  return unheard;
}

std::vector<std::string> Participant::warnings() const {
  std::vector<std::string> all = warnings_->all();
  if (server_watch_) {
    const std::vector<std::string> missing = server_watch_->missing();
    all.insert(all.end(), missing.begin(), missing.end());
  }
  return all;
}

bool Participant::exports(const std::string& wire_name) const {
  constexpr std::string_view kTopics = "rt";  // before the '/' of the name in ROS
  if (!exported_topics_ || !wire_name.starts_with("rt/")) {
    return true;
  }
  const std::string name = wire_name.substr(kTopics.size());
  return name == "/diagnostics" || name == "/rosout" || name == "/parameter_events" ||
         name.find("/_action/") != std::string::npos || exported_topics_->contains(name);
}

// Where there is no profile of a name, the QoS stays as it is.
fastdds::DataWriterQos Participant::writer_profile(const std::string& wire_name) const {
  fastdds::DataWriterQos qos = publisher_->get_default_datawriter_qos();
  load_profiles(wire_name, "client", "service", [&](const std::string& name) {
    publisher_->get_datawriter_qos_from_profile(name, qos);
  });
  return qos;
}

fastdds::DataReaderQos Participant::reader_profile(const std::string& wire_name) const {
  fastdds::DataReaderQos qos = subscriber_->get_default_datareader_qos();
  load_profiles(wire_name, "service", "client", [&](const std::string& name) {
    subscriber_->get_datareader_qos_from_profile(name, qos);
  });
  return qos;
}

void Participant::leave() noexcept {
  if (announcements_) {
    announcements_->connect({});
  }
  participant_->set_listener(nullptr);
  bool clean = true;
  if (publisher_ != nullptr) {
    clean &= participant_->delete_publisher(publisher_) == ReturnCode_t::RETCODE_OK;
  }
  if (machine_publisher_ != nullptr) {
    clean &= participant_->delete_publisher(machine_publisher_) == ReturnCode_t::RETCODE_OK;
  }
  if (subscriber_ != nullptr) {
    clean &= participant_->delete_subscriber(subscriber_) == ReturnCode_t::RETCODE_OK;
  }
  auto* factory = fastdds::DomainParticipantFactory::get_instance();
  clean &= factory->delete_participant(participant_) == ReturnCode_t::RETCODE_OK;
  if (!clean) {
    EPROSIMA_LOG_ERROR(PIPESCOUT, "the participant could not be deleted");
  }
}

fastdds::Topic* Participant::acquire(const WireTopic& wanted) {
  if (wanted.type == nullptr) {
    throw TransportError("topic '" + wanted.name + "': no type");
  }
  const std::lock_guard lock(topics_mutex_);
  const auto known = topics_.find(wanted.name);
  if (known != topics_.end()) {
    TopicEntry& entry = known->second;
    if (entry.type->dds_name != wanted.type->dds_name) {
      throw TransportError("topic '" + wanted.name + "': cannot be of type " +
                           std::string(wanted.type->name) + ", this process uses it with type " +
                           std::string(entry.type->name));
    }
    ++entry.uses;
    return entry.topic;
  }
  register_type(*wanted.type);
  fastdds::Topic* topic = participant_->create_topic(
      wanted.name, std::string(wanted.type->dds_name), participant_->get_default_topic_qos());
  if (topic == nullptr) {
    unregister_type(*wanted.type);
    throw TransportError("topic '" + wanted.name + "': cannot create it with type " +
                         std::string(wanted.type->name));
  }
  topics_[wanted.name] = {topic, wanted.type, 1};
  return topic;
}

void Participant::release(const std::string& name) {
  const std::lock_guard lock(topics_mutex_);
  const auto known = topics_.find(name);
  if (--known->second.uses > 0) {
    return;
  }
  const TopicEntry entry = known->second;
  topics_.erase(known);
  if (participant_->delete_topic(entry.topic) != ReturnCode_t::RETCODE_OK) {
    EPROSIMA_LOG_ERROR(PIPESCOUT, "topic '" << name << "' could not be deleted");
  }
  unregister_type(*entry.type);
}

void Participant::register_type(const MessageType& type) {
  int& uses = type_uses_[std::string(type.dds_name)];
  if (uses == 0) {
    const fastdds::TypeSupport support(new WireType(type.dds_name));
    if (participant_->register_type(support) != ReturnCode_t::RETCODE_OK) {
      throw TransportError("type " + std::string(type.name) + ": cannot register it");
    }
  }
  ++uses;
}

void Participant::unregister_type(const MessageType& type) {
  const auto known = type_uses_.find(type.dds_name);
  if (--known->second == 0) {
    participant_->unregister_type(known->first);
    type_uses_.erase(known);
  }
}

}  // namespace pipescout::dds
