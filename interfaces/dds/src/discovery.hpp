// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "event_thread.hpp"
#include "pipescout/dds/announcements.hpp"
#include "pipescout/runtime/transport.hpp"
#include "rtps_conversions.hpp"
#include "shared_payloads.hpp"
#include "signs_of_life.hpp"

namespace pipescout::dds {

/// Before the text of `Announcements`, in the user data of a participant.
inline constexpr std::string_view kAnnouncementKey = "pipescout=";

/// One of our own endpoints, for finding remote ones that its QoS keeps apart from it.
struct LocalEndpoint {
  const void* owner = nullptr;  ///< of the events, see EventThread
  bool is_writer = false;
  std::string topic;
  std::string type;
  QoS qos;
  std::function<void(QosPolicy)> on_incompatible;
};

/// What the network has told of other processes. Fast DDS's own "incompatible QoS" events do not
/// say which endpoint is meant and count those of this process too; so the pairs are judged here.
class Discovery : public fastdds::DomainParticipantListener {
 public:
  /// `announcements`: gets what the participants say in theirs; may be null.
  explicit Discovery(EventThread& events, std::shared_ptr<Announcements> announcements = nullptr)
      : events_(events), announcements_(std::move(announcements)) {}

  /// From now on finds out which participants announce the same scope. Set once, before there is a
  /// participant.
  void share_payloads(std::string scope) { payload_scope_ = std::move(scope); }
  /// True when the participants of all these endpoints can take large messages from our memory.
  [[nodiscard]] bool take_payloads(const std::set<Gid>& endpoints) const;
  [[nodiscard]] PayloadReader& payloads() noexcept { return payloads_; }

  [[nodiscard]] bool knows(const Gid& participant) const;
  [[nodiscard]] std::vector<DiscoveredParticipant> participants() const;
  [[nodiscard]] std::vector<DiscoveredEndpoint> endpoints() const;
  [[nodiscard]] PortsByParticipant ports_of_this_machine() const;
  /// As if Fast DDS had told that it has gone.
  void forget(const Gid& participant);

  /// See Transport::on_graph_changed.
  void on_graph_changed(GraphChanged callback);

  /// Reports incompatible remote endpoints, those known already and those that come.
  void add(LocalEndpoint endpoint);
  void remove(const void* owner);

  void on_participant_discovery(fastdds::DomainParticipant* participant,
                                rtps::ParticipantDiscoveryInfo&& info) override;
  void on_subscriber_discovery(fastdds::DomainParticipant* participant,
                               rtps::ReaderDiscoveryInfo&& info) override;
  void on_publisher_discovery(fastdds::DomainParticipant* participant,
                              rtps::WriterDiscoveryInfo&& info) override;

 private:
  void endpoint_discovered(DiscoveredEndpoint endpoint);
  void endpoint_removed(const Gid& gid);
  void compare(const LocalEndpoint& local, const DiscoveredEndpoint& remote);
  void graph_changed();
  void erase(const Gid& participant);  // under mutex_

  EventThread& events_;
  const std::shared_ptr<Announcements> announcements_;
  std::string payload_scope_;  // empty: none
  PayloadReader payloads_;
  mutable std::mutex mutex_;
  std::set<GuidPrefix> payload_takers_;
  std::map<Gid, DiscoveredParticipant> participants_;
  PortsByParticipant ports_of_this_machine_;
  std::map<Gid, DiscoveredEndpoint> endpoints_;
  std::vector<LocalEndpoint> local_;
  GraphChanged callback_;
  bool event_pending_ = false;
};

}  // namespace pipescout::dds
