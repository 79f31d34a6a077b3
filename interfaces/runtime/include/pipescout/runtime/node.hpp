// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipescout/runtime/action_client.hpp"
#include "pipescout/runtime/action_server.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/serialized_message.hpp"
#include "pipescout/runtime/service.hpp"
#include "pipescout/runtime/subscription.hpp"
#include "pipescout/runtime/timer.hpp"
#include "pipescout/runtime/topic.hpp"
#include "pipescout/runtime/transforms.hpp"

namespace pipescout {

struct NodeOptions {
  std::shared_ptr<Context> context;
  Executor* executor = nullptr;  ///< must outlive the node
  NodeName name;
  RemapRules remap_rules = {};
  std::vector<ParameterOverride> parameter_overrides = {};
  /// Serve `~/get_parameters` and the other five parameter services, the log level,
  /// `/parameter_events` and `/rosout`. Off for the short-lived nodes of command line tools.
  bool standard_interfaces = true;
};

// Options of endpoints and timers; each struct has the members
//
//   group callback group, created by the node; null: its default group
//   managed  unmanaged ones work in every lifecycle state, managed ones only while active; but a
//            service answers in every state, see there. A plain node is always active.

struct NodePublisherOptions {
  PublisherEvents events = {};
  std::shared_ptr<CallbackGroup> group = nullptr;
  bool managed = true;
};

struct NodeSubscriptionOptions {
  SubscriptionEvents events = {};
  /// None: as the catalogue topic defines; kKeep for a topic by name.
  std::optional<WhileInactive> while_inactive = std::nullopt;
  /// A component watches the rate and age of this input while it is active, and warns on
  /// `/diagnostics`. The parameters `inputs.topics`, `inputs.minimum_rates` and
  /// `inputs.maximum_ages` of the component come before it.
  InputExpectation expected = {};
  std::shared_ptr<CallbackGroup> group = nullptr;
  bool managed = true;
  /// The callback runs on whatever thread brings the message, of a publisher or of the transport,
  /// before `publish` returns; see SubscriptionOptions::group. No events then; what the QoS keeps
  /// apart is only counted.
  bool at_once = false;
};

using GenericPublisher = Publisher<SerializedMessage>;
using GenericSubscription = Subscription<SerializedMessage>;

/// As those of rclcpp's lifecycle nodes, a service answers in every state: its caller waits. A
/// handler whose request makes no sense while the component is not active says so in the response.
/// Requests to managed services wait while an exception that left a callback is being processed.
struct NodeServiceOptions {
  QoS qos = QoS::services();
  std::shared_ptr<CallbackGroup> group = nullptr;
  bool managed = true;
};

/// A client may call in every lifecycle state.
struct NodeClientOptions {
  QoS qos = QoS::services();
  std::shared_ptr<CallbackGroup> group = nullptr;
  std::function<void()> matched = {};  ///< called after the servers that are matched changed
};

struct TimerOptions {
  std::shared_ptr<CallbackGroup> group = nullptr;
  bool managed = true;
};

/// A member of the ROS graph: a name, parameters, and the means to communicate. `Component` adds
/// the managed lifecycle. Names of topics and services are expanded and remapped as in ROS 2.
/// Creating endpoints is thread-safe.
class Node {
 public:
  /// Throws InvalidName, std::invalid_argument when this process has a node of that name already,
  /// TransportError.
  explicit Node(NodeOptions options);
  virtual ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  [[nodiscard]] const NodeName& node_name() const;
  /// As given in the options.
  [[nodiscard]] bool has_standard_interfaces() const;
  [[nodiscard]] Context& context() const;
  [[nodiscard]] Executor& executor() const;
  [[nodiscard]] const Logger& logger() const;
  [[nodiscard]] Parameters& parameters() const;
  /// ROS time: of the system, or of `/clock` while the parameter `use_sim_time` is true. The nodes
  /// of a process with the same clock topic share one time, which is zero until the first message.
  [[nodiscard]] Time now() const;
  /// Mutually exclusive; the group of callbacks unless another one is given.
  [[nodiscard]] const std::shared_ptr<CallbackGroup>& default_group() const;
  /// The name of a topic as the node uses it: expanded, remapped. Throws InvalidName.
  [[nodiscard]] std::string resolve_topic(std::string_view name) const;
  /// The transforms of this node's robot. From the first call on the process listens to `tf` and
  /// `tf_static`, in every lifecycle state; a node that may look up something calls it before, in
  /// `on_configure`. Throws what making a subscription throws.
  [[nodiscard]] Transforms& transforms();
  /// Null before the first call of `transforms`.
  [[nodiscard]] const Transforms* transforms_in_use() const;
  [[nodiscard]] std::shared_ptr<CallbackGroup> create_callback_group(CallbackGroupType type);

  // The following functions throw InvalidName for a name that cannot be expanded or remapped,
  // TopicTypeMismatch when this process uses the name with another type, TransportError, and
  // std::invalid_argument for an invalid QoS or a group of another node. They have the strong
  // exception guarantee.

  template <class T>
  [[nodiscard]] Publisher<T> create_publisher(std::string_view topic, const QoS& qos,
                                              NodePublisherOptions options = {}) {
    return Publisher<T>(
        create_untyped_publisher(topic, message_type<T>(), qos, std::move(options)));
  }
  template <class T>
  [[nodiscard]] Publisher<T> create_publisher(const Topic<T>& topic,
                                              NodePublisherOptions options = {}) {
    return create_publisher<T>(topic.name, topic.qos, std::move(options));
  }

  /// `callback` takes `const T&`, or `const std::shared_ptr<const T>&`, each optionally followed by
  /// `const MessageInfo&`.
  template <class T, class Callback>
  [[nodiscard]] Subscription<T> create_subscription(std::string_view topic, const QoS& qos,
                                                    Callback callback,
                                                    NodeSubscriptionOptions options = {}) {
    return Subscription<T>(create_untyped_subscription(topic, message_type<T>(), qos,
                                                       untyped_callback<T>(std::move(callback)),
                                                       std::move(options)));
  }
  template <class T, class Callback>
  [[nodiscard]] Subscription<T> create_subscription(const Topic<T>& topic, Callback callback,
                                                    NodeSubscriptionOptions options = {}) {
    options.while_inactive = options.while_inactive.value_or(topic.while_inactive);
    return create_subscription<T>(topic.name, topic.requested, std::move(callback),
                                  std::move(options));
  }

  /// A publisher of messages that are bytes already, of the type with that ROS name, which need not
  /// be known here. Subscriptions of this process that know it get one object, decoded once; bytes
  /// that are no such message are counted there as malformed. Throws InvalidName for the type, too.
  [[nodiscard]] GenericPublisher create_generic_publisher(std::string_view topic,
                                                          std::string_view type, const QoS& qos,
                                                          NodePublisherOptions options = {}) {
    return GenericPublisher(
        create_untyped_publisher(topic, serialized_type(type), qos, std::move(options)));
  }
  /// The messages of a topic of any type, as bytes: as they came from other processes, and of this
  /// one's publishers, which serialise once for all generic subscriptions. `callback` as above with
  /// T = SerializedMessage. What publishers offer is not looked at: see `request_for`.
  template <class Callback>
  [[nodiscard]] GenericSubscription create_generic_subscription(
      std::string_view topic, std::string_view type, const QoS& qos, Callback callback,
      NodeSubscriptionOptions options = {}) {
    return GenericSubscription(create_untyped_subscription(
        topic, serialized_type(type), qos, untyped_callback<SerializedMessage>(std::move(callback)),
        std::move(options)));
  }

  /// `handler` is `void(const S::Request&, S::Response&)`, or `void(const std::shared_ptr<const
  /// S::Request>&, Responder<S>)` to answer later.
  template <class S, class Handler>
  [[nodiscard]] Service<S> create_service(std::string_view name, Handler handler,
                                          const NodeServiceOptions& options = {}) {
    using Request = typename S::Request;
    using Response = typename S::Response;
    // The handler needs the service that it answers through, which exists only after it; so no
    // request is taken before it knows it.
    auto self = std::make_shared<std::weak_ptr<UntypedService>>();
    auto untyped = create_untyped_service_on(
        name, message_type<Request>(), message_type<Response>(),
        [handler = std::move(handler), self](const std::shared_ptr<const void>& request,
                                             const SampleIdentity& caller) {
          auto typed = std::static_pointer_cast<const Request>(request);
          Responder<S> responder(*self, caller);
          if constexpr (std::is_invocable_v<const Handler&, const Request&, Response&>) {
            Response response;
            handler(*typed, response);
            responder.respond(std::move(response));
          } else {
            handler(typed, std::move(responder));
          }
        },
        options);
    *self = untyped;
    enable_service(untyped, options);
    return Service<S>(std::move(untyped));
  }

  template <class S>
  [[nodiscard]] Client<S> create_client(std::string_view name,
                                        const NodeClientOptions& options = {}) {
    return Client<S>(create_untyped_client_on(name, message_type<typename S::Request>(),
                                              message_type<typename S::Response>(), options));
  }

  /// Serves an action: see ActionHandlers. The server follows the node's clock. Throws
  /// std::invalid_argument too when the handler `accepted` is empty or an option out of its range.
  template <ActionTag A>
  [[nodiscard]] ActionServer<A> create_action_server(std::string_view name,
                                                     ActionHandlers<A> handlers,
                                                     const NodeActionServerOptions& options = {}) {
    return ActionServer<A>(create_untyped_action_server(name, action_types<A>(),
                                                        std::move(handlers).untyped(), options));
  }

  template <ActionTag A>
  [[nodiscard]] ActionClient<A> create_action_client(std::string_view name,
                                                     const NodeActionClientOptions& options = {}) {
    return ActionClient<A>(create_untyped_action_client(name, action_types<A>(), options));
  }

  /// Uses simulated time while `use_sim_time` is true, else the steady clock; a new period begins
  /// when that changes. Throws std::invalid_argument unless the period is positive.
  [[nodiscard]] std::shared_ptr<Timer> create_timer(Duration period, std::function<void()> callback,
                                                    const TimerOptions& options = {});

  [[nodiscard]] std::shared_ptr<UntypedPublisher> create_untyped_publisher(
      std::string_view topic, const MessageType& type, const QoS& qos,
      NodePublisherOptions options = {});
  [[nodiscard]] std::shared_ptr<UntypedSubscription> create_untyped_subscription(
      std::string_view topic, const MessageType& type, const QoS& qos,
      UntypedSubscription::Callback callback, NodeSubscriptionOptions options = {});

  [[nodiscard]] std::shared_ptr<UntypedActionServer> create_untyped_action_server(
      std::string_view name, const ActionTypes& types, UntypedActionHandlers handlers,
      const NodeActionServerOptions& options = {});
  [[nodiscard]] std::shared_ptr<UntypedActionClient> create_untyped_action_client(
      std::string_view name, const ActionTypes& types, const NodeActionClientOptions& options = {});

  /// Every endpoint, service and client that this node made and that still exists. The endpoints of
  /// services and clients are found through these; those of actions are among them.
  [[nodiscard]] std::vector<std::shared_ptr<UntypedPublisher>> publishers() const;
  [[nodiscard]] std::vector<std::shared_ptr<UntypedSubscription>> subscriptions() const;
  [[nodiscard]] std::vector<std::shared_ptr<UntypedService>> services() const;
  [[nodiscard]] std::vector<std::shared_ptr<UntypedClient>> clients() const;
  [[nodiscard]] std::vector<std::shared_ptr<UntypedActionServer>> action_servers() const;

 protected:
  enum class CallbackStart {
    kAtOnce,
    kWhenAllowed  ///< not before `allow_callbacks`: for base classes
  };
  Node(NodeOptions options, CallbackStart start);
  /// Allows the callbacks of all groups, present and future ones. Thread-safe.
  void allow_callbacks();
  /// Suspends callbacks of all groups except the default one, including groups created later, until
  /// `release_other_groups`. True when none of them is running. Otherwise `idle` is called in the
  /// default group once none is; no thread blocks, so a callback that never returns stops this node
  /// only. Calls do not nest. Call it in the default group.
  bool hold_other_groups(std::function<void()> idle);
  void release_other_groups();
  /// Stops all groups permanently: no further callback begins. `stopped` is called once none is
  /// running, at once or on the thread that ran the last one; it must neither block nor throw.
  /// After it `close` and the destructor do not wait. Thread-safe.
  void stop_callbacks(const std::function<void()>& stopped);
  /// Enables or disables all managed publishers, subscriptions, timers and action servers, present
  /// and future ones.
  void set_managed_active(bool active);
  /// The same for managed services. Requests to disabled ones wait.
  void set_services_enabled(bool enabled);
  /// Called when a callback of one of the node's groups throws, on the thread that ran it. The
  /// default rethrows it out of the executor's spin.
  virtual void on_callback_exception(std::exception_ptr error);
  /// Ends all callbacks: closes the groups, and waits for running callbacks, but not for one that
  /// calls it. For base classes, whose objects the owner closes before it destroys them: a callback
  /// must not access a partly destroyed object.
  void close();

 private:
  template <class T, class Callback>
  static UntypedSubscription::Callback untyped_callback(Callback callback) {
    using Shared = std::shared_ptr<const T>;
    return [callback = std::move(callback)](const std::shared_ptr<const void>& message,
                                            const MessageInfo& info) mutable {
      if constexpr (std::is_invocable_v<Callback&, const T&, const MessageInfo&>) {
        callback(*static_cast<const T*>(message.get()), info);
      } else if constexpr (std::is_invocable_v<Callback&, const T&>) {
        callback(*static_cast<const T*>(message.get()));
      } else if constexpr (std::is_invocable_v<Callback&, const Shared&, const MessageInfo&>) {
        callback(std::static_pointer_cast<const T>(message), info);
      } else {
        static_assert(std::is_invocable_v<Callback&, const Shared&>,
                      "a subscription callback takes const T& or const std::shared_ptr<const T>&");
        callback(std::static_pointer_cast<const T>(message));
      }
    };
  }

  friend class Transforms;
  /// Null: the time of this machine.
  [[nodiscard]] std::shared_ptr<SimulatedClock> simulated_clock() const;

  std::shared_ptr<UntypedService> create_untyped_service_on(std::string_view name,
                                                            const MessageType& request,
                                                            const MessageType& response,
                                                            UntypedService::Handler handler,
                                                            const NodeServiceOptions& options);
  void enable_service(const std::shared_ptr<UntypedService>& service,
                      const NodeServiceOptions& options);
  std::shared_ptr<UntypedClient> create_untyped_client_on(std::string_view name,
                                                          const MessageType& request,
                                                          const MessageType& response,
                                                          const NodeClientOptions& options);
  std::string action_name(std::string_view name) const;
  void add_action_server(const std::shared_ptr<UntypedActionServer>& server, bool managed);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pipescout
