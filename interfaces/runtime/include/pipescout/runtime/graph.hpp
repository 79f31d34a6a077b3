// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout {

class UntypedPublisher;
class UntypedSubscription;

/// A publisher or subscription anywhere on the network.
struct GraphEndpoint {
  Gid gid;
  bool is_publisher = false;
  std::string wire_topic;        ///< "rt/odometer/fused"
  std::string wire_type;         ///< "pipescout_msgs::msg::dds_::FusedOdometer_"
  QoS qos;                       ///< depth 0: unknown
  std::optional<NodeName> node;  ///< none: not announced (a plain DDS program)
  bool in_this_process = false;
};

/// A process collects what is new of its nodes for at most so long before it announces it.
inline constexpr Duration kLongestCollecting = std::chrono::milliseconds(640);

/// A participant of ROS 2 that is discovered and has not told all yet.
struct UntoldParticipant {
  DiscoveredParticipant participant;
  bool has_told_its_nodes = false;
  /// Endpoints that it has told of and that are not discovered.
  std::size_t undiscovered_endpoints = 0;
  /// Endpoints of ROS topics and services that are discovered and that it has told no node of. They
  /// may stay so: not every endpoint belongs to a node.
  std::size_t unowned_endpoints = 0;

  /// Whether something is missing for certain.
  [[nodiscard]] bool lacks() const noexcept {
    return !has_told_its_nodes || undiscovered_endpoints > 0;
  }
};

/// Names with their types: more than one type is an error of one of the nodes.
using NamesAndTypes = std::map<std::string, std::set<std::string>>;

/// The node graph of ROS 2: nodes, and their publishers and subscriptions. Announces the nodes of
/// this process on `ros_discovery_info` and reads the announcements of others. Thread-safe.
class Graph {
 public:
  virtual ~Graph() = default;

  /// Announces a node. Throws std::invalid_argument when this process has one of that name already.
  virtual void add_node(const NodeName& node) = 0;
  virtual void remove_node(const NodeName& node) = 0;
  /// Assigns an endpoint of this process to a node. Destroyed endpoints leave the graph
  /// automatically; those of a node that is removed first stay without an owner. Throws
  /// std::invalid_argument when the node is not in this process or the endpoint has an owner.
  virtual void add_endpoint(const NodeName& node,
                            const std::shared_ptr<UntypedPublisher>& publisher) = 0;
  virtual void add_endpoint(const NodeName& node,
                            const std::shared_ptr<UntypedSubscription>& subscription) = 0;
  /// The same for a subscription that several nodes share: it appears once for each of them.
  virtual void add_shared_endpoint(const NodeName& node,
                                   const std::shared_ptr<UntypedSubscription>& subscription) = 0;

  /// All nodes, sorted; a name used by two nodes appears twice.
  [[nodiscard]] virtual std::vector<NodeName> nodes() const = 0;
  [[nodiscard]] virtual std::vector<GraphEndpoint> endpoints() const = 0;
  /// ROS topic names with ROS type names ("sensor_msgs/msg/Image"), without services.
  [[nodiscard]] virtual NamesAndTypes topics() const = 0;
  /// ROS service names with service types ("std_srvs/srv/Trigger").
  [[nodiscard]] virtual NamesAndTypes services() const = 0;

  /// Calls `changed` after each change of the graph, on the thread that caused it (possibly one of
  /// the transport); it must return soon, must not throw, and may query the graph. Once the
  /// returned handle is destroyed, no call is in progress or follows (except a call that destroys
  /// it itself), so the handle must not be destroyed under a lock that `changed` takes.
  [[nodiscard]] virtual std::shared_ptr<void> on_changed(std::function<void()> changed) = 0;
  /// Blocks until `done` returns true, checking after each change; false after the time-out.
  virtual bool wait_until(const std::function<bool()>& done, Duration timeout) = 0;

  /// Those of which `nodes` or `endpoints` lack something: participants, their nodes and each
  /// endpoint are discovered apart from each other. Participants that are not of ROS 2 do not say
  /// when they have told everything, and are never among these.
  [[nodiscard]] virtual std::vector<UntoldParticipant> untold() const = 0;

  /// Announces what is new of this process now, without collecting more: before somebody is told
  /// that its nodes are there.
  virtual void announce_pending() = 0;
};

}  // namespace pipescout
