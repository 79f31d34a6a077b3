// SPDX-License-Identifier: Apache-2.0
#include "graph.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

using rmw_dds_common::msg::NodeEntitiesInfo;
using rmw_dds_common::msg::ParticipantEntitiesInfo;

// ROS 2 keeps all; the transport hands samples over at once, so this only bounds a burst.
constexpr std::size_t kDiscoveryReaderDepth = 1000;

// Announcements describe all nodes of the process, and endpoints come in bursts (a composition that
// starts has hundreds). So changes are collected: for a moment at first, twice as long each time
// while a burst goes on. The sum of what is sent stays within a few times the last announcement.
constexpr Duration kShortestCollecting = std::chrono::milliseconds(20);

// A participant's message may arrive before discovery shows the participant, but not this long.
constexpr Duration kLongestUnknown = std::chrono::minutes(1);

/// How many of the first are not among the second.
std::size_t count_missing(const std::set<Gid>& some, const std::set<Gid>& all) {
  return static_cast<std::size_t>(
      std::count_if(some.begin(), some.end(), [&](const Gid& gid) { return !all.contains(gid); }));
}

/// Who is told of changes, and waits for them.
class ChangeBell {
 public:
  std::shared_ptr<void> add(std::function<void()> changed) {
    auto listener = std::make_shared<Listener>();
    listener->changed = std::move(changed);
    const std::lock_guard lock(mutex_);
    std::erase_if(listeners_, [](const auto& weak) { return weak.expired(); });
    listeners_.push_back(listener);
    // Ends the listening, and is held by nobody but the caller.
    return {listener.get(), [listener](void*) { listener->end(); }};
  }

  void ring() {
    std::vector<std::weak_ptr<Listener>> listeners;
    {
      const std::lock_guard lock(mutex_);
      ++changes_;
      listeners = listeners_;
    }
    rung_.notify_all();
    for (const auto& weak : listeners) {
      if (const auto listener = weak.lock()) {
        listener->tell();
      }
    }
  }

  bool wait_until(const std::function<bool()>& done, Duration timeout) {
    const SteadyTime until = add_saturated(steady_now(), timeout);
    while (true) {
      std::uint64_t seen = 0;
      {
        const std::lock_guard lock(mutex_);
        seen = changes_;
      }
      // With no lock held: it may ask the graph.
      if (done()) {
        return true;
      }
      std::unique_lock lock(mutex_);
      if (!rung_.wait_until(lock, until, [&] { return changes_ != seen; })) {
        return false;
      }
    }
  }

 private:
  struct Listener {
    // Recursive, since a callback may give up its own handle.
    std::recursive_mutex mutex;
    bool ended = false;
    std::function<void()> changed;

    void tell() {
      const std::lock_guard lock(mutex);
      if (!ended) {
        changed();
      }
    }
    void end() {
      const std::lock_guard lock(mutex);
      ended = true;
    }
  };

  std::mutex mutex_;
  std::condition_variable rung_;
  std::uint64_t changes_ = 0;
  std::vector<std::weak_ptr<Listener>> listeners_;
};

/// What the graph knows, shared with the callbacks of endpoints and transport, which may outlive
/// the graph. No lock is held while a publisher or a callback is called, or the transport asked.
class Knowledge {
 public:
  explicit Knowledge(Transport* transport) : transport_(transport) {}

  void start_announcing(std::shared_ptr<UntypedPublisher> publisher,
                        std::unique_ptr<DelayedCall> announcement) {
    publisher_ = std::move(publisher);
    const std::lock_guard lock(mutex_);
    announcement_ = std::move(announcement);
    announce_later();
  }

  void stop_announcing() {
    std::unique_ptr<DelayedCall> announcement;  // ends without the lock, which its call takes
    const std::lock_guard lock(mutex_);
    announcement.swap(announcement_);
  }

  /// Publishes the nodes of this process.
  void announce() {
    const std::lock_guard announcing(announcing_mutex_);
    auto message = std::make_shared<ParticipantEntitiesInfo>();
    {
      const std::lock_guard lock(mutex_);
      announcement_pending_ = false;
      announced_at_ = steady_now();
      describe_local_nodes(*message);
    }
    publisher_->publish(std::move(message), {});
  }

  /// Does not wait until more has come.
  void announce_pending() {
    {
      const std::lock_guard lock(mutex_);
      if (!announcement_pending_) {
        return;
      }
    }
    announce();
  }

  void add_node(const NodeName& node) {
    {
      const std::lock_guard lock(mutex_);
      if (!local_nodes_.insert(node).second) {
        throw std::invalid_argument("node '" + node.fully_qualified() +
                                    "' exists already in this process");
      }
      announce_later();
    }
    bell_.ring();
  }

  void remove_node(const NodeName& node) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = local_nodes_.find(node);
      if (found == local_nodes_.end()) {
        return;
      }
      for (auto entry = local_endpoints_.begin(); entry != local_endpoints_.end();) {
        GraphEndpoint& endpoint = entry->second;
        if (endpoint.node == node && local_endpoints_.count(entry->first) > 1) {
          entry = local_endpoints_.erase(entry);  // others share it
          continue;
        }
        if (endpoint.node == node) {
          endpoint.node.reset();
        }
        ++entry;
      }
      local_nodes_.erase(found);
      announce_later();
    }
    bell_.ring();
  }

  /// `address`: names the endpoint until it is destroyed.
  void add_endpoint(const void* address, const NodeName& node, bool is_publisher, const Gid& gid,
                    const WireTopic& topic, const QoS& qos, bool is_shared = false) {
    {
      const std::lock_guard lock(mutex_);
      if (!local_nodes_.contains(node)) {
        throw std::invalid_argument("an endpoint of '" + topic.name + "' cannot belong to node '" +
                                    node.fully_qualified() + "', which is not in this process");
      }
      if (!is_shared && local_endpoints_.contains(address)) {
        throw std::invalid_argument("the endpoint " + to_string(gid) + " of '" + topic.name +
                                    "' belongs to a node already");
      }
      local_endpoints_.emplace(
          address, GraphEndpoint{gid, is_publisher, topic.name, std::string(topic.type->dds_name),
                                 qos, node, true});
      announce_later();
    }
    bell_.ring();
  }

  [[nodiscard]] bool is_assigned(const void* address, const NodeName& node) const {
    const std::lock_guard lock(mutex_);
    const auto [first, last] = local_endpoints_.equal_range(address);
    return std::any_of(first, last, [&](const auto& entry) { return entry.second.node == node; });
  }

  void endpoint_destroyed(const void* address) {
    {
      const std::lock_guard lock(mutex_);
      if (local_endpoints_.erase(address) == 0) {
        return;
      }
      announce_later();
    }
    bell_.ring();
  }

  void hear(const ParticipantEntitiesInfo& message, const MessageInfo& info) {
    const Gid participant = from_message(message.gid);
    // One may speak for oneself only, so what is kept is bounded by the participants that there
    // are.
    if (info.from_this_process || !same_participant(participant, info.identity.writer)) {
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      remote_nodes_[participant] = {message.node_entities_info_seq, steady_now(), prunings_, false};
    }
    bell_.ring();
  }

  /// Forgets participants that discovery has lost.
  void remote_graph_changed() {
    std::uint64_t pruning = 0;
    {
      const std::lock_guard lock(mutex_);
      pruning = ++prunings_;
    }
    const std::vector<Gid> present = present_participants();
    const SteadyTime long_ago = steady_now() - kLongestUnknown;
    {
      const std::lock_guard lock(mutex_);
      for (auto entry = remote_nodes_.begin(); entry != remote_nodes_.end();) {
        RemoteNodes& remote = entry->second;
        const bool is_present = std::binary_search(present.begin(), present.end(), entry->first);
        // What was heard after the list was asked for may be missing from it.
        const bool is_gone = !is_present && remote.heard_after_pruning < pruning &&
                             (remote.was_present || remote.heard_at < long_ago);
        remote.was_present = remote.was_present || is_present;
        entry = is_gone ? remote_nodes_.erase(entry) : std::next(entry);
      }
    }
    bell_.ring();
  }

  [[nodiscard]] std::vector<NodeName> nodes() const {
    const std::vector<Gid> present = present_participants();
    std::vector<NodeName> nodes;
    {
      const std::lock_guard lock(mutex_);
      nodes.assign(local_nodes_.begin(), local_nodes_.end());
      for (const auto& [participant, remote] : remote_nodes_) {
        if (!std::binary_search(present.begin(), present.end(), participant)) {
          continue;
        }
        for (const auto& node : remote.nodes) {
          nodes.push_back({node.node_namespace, node.node_name});
        }
      }
    }
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  }

  [[nodiscard]] std::vector<GraphEndpoint> endpoints() const {
    std::vector<DiscoveredEndpoint> remote;
    if (transport_ != nullptr) {
      remote = transport_->remote_endpoints();
    }
    std::vector<GraphEndpoint> endpoints;
    const std::lock_guard lock(mutex_);
    endpoints.reserve(local_endpoints_.size() + remote.size());
    for (const auto& [address, endpoint] : local_endpoints_) {
      endpoints.push_back(endpoint);
    }
    std::sort(endpoints.begin(), endpoints.end(), [](const auto& a, const auto& b) {
      return std::tie(a.gid, a.node) < std::tie(b.gid, b.node);
    });
    // Subscriptions that share a reader appear as one endpoint for each node.
    std::multimap<Gid, NodeName> owners;
    for (const auto& [participant, entry] : remote_nodes_) {
      for (const auto& node : entry.nodes) {
        const NodeName name{node.node_namespace, node.node_name};
        for (const auto* gids : {&node.reader_gid_seq, &node.writer_gid_seq}) {
          for (const auto& gid : *gids) {
            owners.emplace(from_message(gid), name);
          }
        }
      }
    }
    for (const auto& found : remote) {
      GraphEndpoint endpoint{found.gid, found.is_writer, found.topic, found.type,
                             found.qos, std::nullopt,    false};
      const auto [first, last] = owners.equal_range(found.gid);
      if (first == last) {
        endpoints.push_back(std::move(endpoint));
        continue;
      }
      for (auto owner = first; owner != last; ++owner) {
        endpoint.node = owner->second;
        endpoints.push_back(endpoint);
      }
    }
    return endpoints;
  }

  [[nodiscard]] std::vector<UntoldParticipant> untold() const {
    std::vector<UntoldParticipant> untold;
    if (transport_ == nullptr) {
      return untold;
    }
    std::map<Gid, std::set<Gid>> discovered;  // by participant
    std::map<Gid, std::set<Gid>> of_ros;      // those of them with a topic or service of ROS
    for (const auto& endpoint : transport_->remote_endpoints()) {
      discovered[endpoint.participant].insert(endpoint.gid);
      if (demangle_topic_name(endpoint.topic)) {
        of_ros[endpoint.participant].insert(endpoint.gid);
      }
    }
    const auto participants = transport_->remote_participants();
    const std::lock_guard lock(mutex_);
    for (const auto& participant : participants) {
      if (participant.enclave.empty()) {
        continue;  // not of ROS
      }
      UntoldParticipant found{.participant = participant};
      std::set<Gid> told;
      if (const auto heard = remote_nodes_.find(participant.gid); heard != remote_nodes_.end()) {
        found.has_told_its_nodes = true;
        for (const auto& node : heard->second.nodes) {
          for (const auto* gids : {&node.reader_gid_seq, &node.writer_gid_seq}) {
            std::transform(gids->begin(), gids->end(), std::inserter(told, told.end()),
                           [](const auto& gid) { return from_message(gid); });
          }
        }
      }
      found.undiscovered_endpoints = count_missing(told, discovered[participant.gid]);
      found.unowned_endpoints = count_missing(of_ros[participant.gid], told);
      if (found.lacks() || found.unowned_endpoints > 0) {
        untold.push_back(std::move(found));
      }
    }
    return untold;
  }

  ChangeBell& bell() { return bell_; }

 private:
  struct RemoteNodes {
    std::vector<NodeEntitiesInfo> nodes;
    SteadyTime heard_at{};
    std::uint64_t heard_after_pruning = 0;
    bool was_present = false;  // discovery has shown the participant
  };

  [[nodiscard]] std::vector<Gid> present_participants() const {
    std::vector<Gid> present;
    if (transport_ != nullptr) {
      for (const auto& participant : transport_->remote_participants()) {
        present.push_back(participant.gid);
      }
    }
    std::sort(present.begin(), present.end());
    return present;
  }

  void announce_later() {  // under mutex_
    if (announcement_pending_ || !announcement_) {
      return;
    }
    announcement_pending_ = true;
    const bool in_burst = steady_now() - announced_at_ < collecting_;
    collecting_ = in_burst ? std::min(2 * collecting_, kLongestCollecting) : kShortestCollecting;
    announcement_->start(collecting_);
  }

  void describe_local_nodes(ParticipantEntitiesInfo& message) const {  // under mutex_
    message.gid = to_message(transport_->participant());
    // Each identity once, however many subscriptions of the node share it.
    std::map<NodeName, std::set<Gid>> readers;
    std::map<NodeName, std::set<Gid>> writers;
    for (const auto& [address, endpoint] : local_endpoints_) {
      if (endpoint.node) {
        (endpoint.is_publisher ? writers : readers)[*endpoint.node].insert(endpoint.gid);
      }
    }
    const auto copy = [](const std::set<Gid>& gids, auto& wire) {
      wire.reserve(gids.size());
      for (const Gid& gid : gids) {
        wire.push_back(to_message(gid));
      }
    };
    auto& nodes = message.node_entities_info_seq;
    nodes.reserve(local_nodes_.size());
    for (const NodeName& name : local_nodes_) {
      NodeEntitiesInfo& described = nodes.emplace_back();
      described.node_namespace = name.ns;
      described.node_name = name.name;
      copy(readers[name], described.reader_gid_seq);
      copy(writers[name], described.writer_gid_seq);
    }
  }

  Transport* const transport_;
  std::shared_ptr<UntypedPublisher> publisher_;  // null without a transport
  ChangeBell bell_;

  std::mutex announcing_mutex_;  // of two announcements the later one is published last
  mutable std::mutex mutex_;
  std::set<NodeName> local_nodes_;
  // By address; several for one that nodes share.
  std::multimap<const void*, GraphEndpoint> local_endpoints_;
  std::map<Gid, RemoteNodes> remote_nodes_;
  std::unique_ptr<DelayedCall> announcement_;  // null without a transport
  bool announcement_pending_ = false;
  SteadyTime announced_at_{};
  Duration collecting_ = kShortestCollecting;
  std::uint64_t prunings_ = 0;
};

class ProcessGraph final : public OwnGraph {
 public:
  explicit ProcessGraph(const std::shared_ptr<Broker>& broker)
      : transport_(broker->transport()), knowledge_(std::make_shared<Knowledge>(transport_)) {
    const std::weak_ptr<Knowledge> weak = knowledge_;
    broker->on_endpoint_destroyed([weak](const void* address) {
      if (const auto knowledge = weak.lock()) {
        knowledge->endpoint_destroyed(address);
      }
    });
    if (transport_ == nullptr) {
      return;
    }
    const WireTopic topic{"ros_discovery_info", &message_type<ParticipantEntitiesInfo>()};
    transport_->on_graph_changed([weak] {
      if (const auto knowledge = weak.lock()) {
        knowledge->remote_graph_changed();
      }
    });
    subscription_ = broker->create_subscription(
        {.topic = topic,
         .qos = QoS::latched(kDiscoveryReaderDepth),
         .callback = [weak](const std::shared_ptr<const void>& message, const MessageInfo& info) {
           if (const auto knowledge = weak.lock()) {
             knowledge->hear(*static_cast<const ParticipantEntitiesInfo*>(message.get()), info);
           }
         }});
    knowledge_->start_announcing(broker->create_publisher({.topic = topic, .qos = QoS::latched(1)}),
                                 transport_->create_delayed_call([weak] {
                                   if (const auto knowledge = weak.lock()) {
                                     knowledge->announce();
                                   }
                                 }));
  }

  ~ProcessGraph() override {
    if (transport_ != nullptr) {
      transport_->on_graph_changed({});
      knowledge_->stop_announcing();
    }
  }
  ProcessGraph(const ProcessGraph&) = delete;
  ProcessGraph& operator=(const ProcessGraph&) = delete;

  void add_node(const NodeName& node) override { knowledge_->add_node(node); }
  void remove_node(const NodeName& node) override { knowledge_->remove_node(node); }
  void add_endpoint(const NodeName& node,
                    const std::shared_ptr<UntypedPublisher>& publisher) override {
    knowledge_->add_endpoint(publisher.get(), node, true, publisher->gid(), publisher->topic(),
                             publisher->qos());
  }
  void add_endpoint(const NodeName& node,
                    const std::shared_ptr<UntypedSubscription>& subscription) override {
    knowledge_->add_endpoint(subscription.get(), node, false, subscription->gid(),
                             subscription->topic(), subscription->qos());
  }
  void add_shared_endpoint(const NodeName& node,
                           const std::shared_ptr<UntypedSubscription>& subscription) override {
    knowledge_->add_endpoint(subscription.get(), node, false, subscription->gid(),
                             subscription->topic(), subscription->qos(), true);
  }
  void add_shared_endpoint(const NodeName& node,
                           const std::shared_ptr<UntypedPublisher>& publisher) override {
    if (!knowledge_->is_assigned(publisher.get(), node)) {
      knowledge_->add_endpoint(publisher.get(), node, true, publisher->gid(), publisher->topic(),
                               publisher->qos(), true);
    }
  }

  std::vector<NodeName> nodes() const override { return knowledge_->nodes(); }
  std::vector<GraphEndpoint> endpoints() const override { return knowledge_->endpoints(); }

  NamesAndTypes topics() const override {
    NamesAndTypes topics;
    for (const auto& endpoint : endpoints()) {
      const auto topic = demangle_topic_name(endpoint.wire_topic);
      if (topic && topic->kind == DdsTopicKind::kTopic) {
        // A type that is none of ROS is shown as it is.
        topics[topic->name].insert(
            demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type));
      }
    }
    return topics;
  }

  NamesAndTypes services() const override {
    NamesAndTypes services;
    for (const auto& endpoint : endpoints()) {
      const auto topic = demangle_topic_name(endpoint.wire_topic);
      const auto type = demangle_service_type_name(endpoint.wire_type);
      if (topic && topic->kind != DdsTopicKind::kTopic && type) {
        services[topic->name].insert(*type);
      }
    }
    return services;
  }

  std::shared_ptr<void> on_changed(std::function<void()> changed) override {
    return knowledge_->bell().add(std::move(changed));
  }
  bool wait_until(const std::function<bool()>& done, Duration timeout) override {
    return knowledge_->bell().wait_until(done, timeout);
  }
  std::vector<UntoldParticipant> untold() const override { return knowledge_->untold(); }
  void announce_pending() override { knowledge_->announce_pending(); }

 private:
  Transport* const transport_;
  std::shared_ptr<Knowledge> knowledge_;
  std::shared_ptr<UntypedSubscription> subscription_;
};

}  // namespace

std::unique_ptr<OwnGraph> create_graph(const std::shared_ptr<Broker>& broker) {
  return std::make_unique<ProcessGraph>(broker);
}

}  // namespace pipescout
