// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "pipescout/runtime/clock.hpp"
#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/subscription.hpp"
#include "pipescout/runtime/topic.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout {

class Activity;
class Graph;
class StepTraffic;
struct StepParticipation;
class TransformListener;

/// An endpoint was requested on a topic that has another type in this process.
class TopicTypeMismatch : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PublisherOptions {
  WireTopic topic;
  QoS qos = {};
  PublisherEvents events = {};
  /// Group of the events. Null: only for endpoints without events.
  std::shared_ptr<CallbackGroup> group = nullptr;
};

struct SubscriptionOptions {
  WireTopic topic;
  QoS qos = {};
  UntypedSubscription::Callback callback = nullptr;
  SubscriptionEvents events = {};
  /// Group of the callback and the events. Null: the callback runs at once, on the thread that
  /// delivers the message (of a publisher or of the transport); it must return soon and must not
  /// publish or create endpoints, and there must be no events.
  std::shared_ptr<CallbackGroup> group = nullptr;
  /// What happens to messages while the subscription is disabled.
  WhileInactive while_inactive = WhileInactive::kKeep;
  InputExpectation expected = {};  ///< kept for whoever watches the subscription
  /// Start disabled, see UntypedSubscription::set_enabled.
  bool enabled = true;
  /// Subscriptions of one topic with the same QoS share one reader for other processes, and its
  /// identity. When true, the subscription has a separate reader: clients of a service are
  /// distinguished by it.
  bool own_reader = false;
};

/// The communication state of one process: at most one participant, the in-process delivery, the
/// graph and the clocks. Everything that communicates belongs to a context and keeps it alive.
/// Thread-safe.
class Context : public std::enable_shared_from_this<Context> {
 public:
  /// With a transport, messages reach other processes. Without one no socket is opened, and
  /// everything else works the same: the backend of unit tests.
  [[nodiscard]] static std::shared_ptr<Context> create(std::unique_ptr<Transport> transport);
  [[nodiscard]] static std::shared_ptr<Context> create_in_process() { return create(nullptr); }

  virtual ~Context() = default;

  /// Throws TopicTypeMismatch, TransportError, std::invalid_argument (QoS).
  [[nodiscard]] virtual std::shared_ptr<UntypedPublisher> create_publisher(
      PublisherOptions options) = 0;
  [[nodiscard]] virtual std::shared_ptr<UntypedSubscription> create_subscription(
      SubscriptionOptions options) = 0;

  /// Nodes, topics and services, here and on the network.
  [[nodiscard]] virtual Graph& graph() = 0;

  [[nodiscard]] virtual std::shared_ptr<SystemClock> system_clock() const = 0;
  /// The clock of this process for a topic with a fully qualified name; it exists as long as the
  /// context. The nodes that subscribe to the topic drive it.
  [[nodiscard]] virtual std::shared_ptr<SimulatedClock> simulated_clock(
      const std::string& topic = "/clock") = 0;

  /// Whether the nodes of this context have anything to do.
  [[nodiscard]] virtual const std::shared_ptr<Activity>& activity() const = 0;

  /// What has passed between this process and others, for simulations in lock step.
  [[nodiscard]] virtual const std::shared_ptr<StepTraffic>& step_traffic() const = 0;
  /// While it exists, this process tells the simulation that drives the clock of that topic (DDS
  /// name) when it has nothing more to do; `node` (fully qualified) is why. Null without transport.
  [[nodiscard]] virtual std::shared_ptr<StepParticipation> take_part_in_steps(
      const std::string& clock_topic, const std::string& node) = 0;
  /// A group on a thread of the context that no component can hold up. Its callbacks must neither
  /// block nor throw, and must not own the context.
  [[nodiscard]] virtual std::shared_ptr<CallbackGroup> create_watch_group() = 0;

  /// What fills the transform buffer of this process for a pair of topics, in fully qualified
  /// names; it exists while somebody holds it. For `Transforms`.
  [[nodiscard]] virtual std::shared_ptr<TransformListener> transform_listener(
      const std::string& tf_topic, const std::string& tf_static_topic) = 0;

  /// Null for the in-process backend.
  [[nodiscard]] virtual Transport* transport() = 0;
};

}  // namespace pipescout
