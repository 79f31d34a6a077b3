// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "discovery.hpp"
#include "event_thread.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "security.hpp"
#include "server_watch.hpp"
#include "signs_of_life.hpp"
#include "warnings.hpp"

namespace pipescout::dds {

/// The process's place on the network, shared by the transport and its endpoints; lives until the
/// last of them is gone. Thread-safe.
class Participant {
 public:
  /// Throws TransportError.
  explicit Participant(const DdsOptions& options);
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant();

  /// For a topic, by its name on the wire.
  [[nodiscard]] fastdds::Publisher& publisher(const std::string& wire_name) const {
    return exports(wire_name) ? *publisher_ : *machine_publisher_;
  }
  [[nodiscard]] fastdds::Subscriber& subscriber() const { return *subscriber_; }
  /// What the QoS of an endpoint starts from: as with rmw_fastrtps the profile of the user's
  /// profile file for this topic ("/chatter") or service ("service", "client", "rq/getRequest"),
  /// else the default one.
  [[nodiscard]] fastdds::DataWriterQos writer_profile(const std::string& wire_name) const;
  [[nodiscard]] fastdds::DataReaderQos reader_profile(const std::string& wire_name) const;
  [[nodiscard]] Gid gid() const { return gid_; }
  [[nodiscard]] EventThread& events() { return events_; }
  [[nodiscard]] Discovery& discovery() { return discovery_; }
  [[nodiscard]] const NetworkProfile& network() const { return network_; }
  [[nodiscard]] bool is_found_by_server() const { return is_found_by_server_; }
  /// See Transport::take_census.
  [[nodiscard]] std::vector<UnheardParticipant> take_census();
  /// See Transport::warnings.
  [[nodiscard]] std::vector<std::string> warnings() const;
  /// For large messages that other participants send; for those that are sent, null when there is
  /// no shared memory.
  [[nodiscard]] PayloadReader& payloads() { return discovery_.payloads(); }
  [[nodiscard]] const std::shared_ptr<PayloadFolder>& payload_folder() const {
    return payload_folder_;
  }

 private:
  friend class TopicUse;

  struct TopicEntry {
    fastdds::Topic* topic = nullptr;
    const MessageType* type = nullptr;
    int uses = 0;
  };

  fastdds::Topic* acquire(const WireTopic& topic);
  void release(const std::string& name);
  void register_type(const MessageType& type);
  void unregister_type(const MessageType& type);
  void leave() noexcept;
  [[nodiscard]] bool exports(const std::string& wire_name) const;

  const std::uint32_t domain_;
  const NetworkProfile network_;
  const bool is_found_by_server_;
  const std::optional<std::set<std::string>> exported_topics_;
  const std::shared_ptr<Announcements> announcements_;  // null: none
  const std::shared_ptr<Warnings> warnings_ = std::make_shared<Warnings>();
  EventThread events_;
  Discovery discovery_;
  fastdds::DomainParticipant* participant_ = nullptr;
  fastdds::Publisher* publisher_ = nullptr;
  fastdds::Publisher* machine_publisher_ = nullptr;  // of what does not leave it
  fastdds::Subscriber* subscriber_ = nullptr;
  Gid gid_;
  std::shared_ptr<PayloadFolder> payload_folder_;
  std::optional<RevocationWatch> revocation_watch_;
  std::optional<ServerWatch> server_watch_;

  std::mutex census_mutex_;
  Census census_;

  std::mutex topics_mutex_;
  std::map<std::string, TopicEntry> topics_;
  std::map<std::string, int, std::less<>> type_uses_;  // by DDS name
};

/// Keeps a topic and its type registered as long as it lives.
class TopicUse {
 public:
  /// Throws TransportError naming the topic, also when this process uses it with another type.
  TopicUse(Participant& participant, const WireTopic& topic)
      : participant_(participant), name_(topic.name), topic_(participant.acquire(topic)) {}
  TopicUse(const TopicUse&) = delete;
  TopicUse& operator=(const TopicUse&) = delete;
  ~TopicUse() { participant_.release(name_); }

  [[nodiscard]] fastdds::Topic* get() const { return topic_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  Participant& participant_;
  std::string name_;
  fastdds::Topic* topic_;
};

}  // namespace pipescout::dds
