// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/node.hpp"

/// Helpers for unit tests of components. They open no socket and do not wait for fixed times.
namespace pipescout::testing {

/// The messages received on a topic, in order. A handle: copies share the messages, and the last
/// one ends the subscription.
template <class T>
class Collector {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return state_->messages.size(); }
  [[nodiscard]] bool empty() const noexcept { return state_->messages.empty(); }
  /// Throws std::out_of_range.
  [[nodiscard]] const T& at(std::size_t index) const { return *state_->messages.at(index); }
  /// The latest. Throws std::out_of_range when there is none.
  [[nodiscard]] const T& back() const { return *state_->messages.at(size() - 1); }
  /// The published objects themselves, when the publisher is in this process.
  [[nodiscard]] const std::vector<std::shared_ptr<const T>>& messages() const noexcept {
    return state_->messages;
  }
  [[nodiscard]] std::size_t publisher_count() const {
    return state_->subscription.publisher_count();
  }
  void clear() noexcept { state_->messages.clear(); }

 private:
  friend class ComponentHarness;
  struct State {
    std::vector<std::shared_ptr<const T>> messages;
    Subscription<T> subscription;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

struct LogEntry {
  LogSeverity severity = LogSeverity::kInfo;
  std::string logger;  ///< "robot_1.odometry_fusion"
  std::string text;
};

/// Options for creating a component.
struct ComponentSpec {
  std::string name = "component_under_test";
  std::vector<NamedParameter> parameters{};  ///< overrides, as a parameter file gives them
  std::vector<std::string> remappings{};     ///< "from:=to"
};

struct HarnessOptions {
  /// Namespace of the components, and of the relative topic names.
  std::string ns = "/";
  /// Components use the time of the harness, see `set_time`; it begins at zero.
  bool simulated_time = false;
};

/// Test environment of components: a context without transport, an executor that runs callbacks
/// only inside calls of the harness and on the calling thread, and a peer node that publishes,
/// subscribes and calls services for the test. For use by one thread.
///
///     ComponentHarness harness;
///     auto& fusion = harness.make<OdometryFusion>({.name = "fusion", .parameters = {{"m", 3}}});
///     const auto fused = harness.collect(topics::kOdometerFused);
///     ASSERT_TRUE(harness.bring_up(fusion).success);
///     harness.publish(topics::kOdometerReadings, readings);
///     harness.spin();
///     ASSERT_EQ(fused.size(), 1U);
class ComponentHarness {
 public:
  explicit ComponentHarness(HarnessOptions options = {});
  ~ComponentHarness();
  ComponentHarness(const ComponentHarness&) = delete;
  ComponentHarness& operator=(const ComponentHarness&) = delete;

  /// Creates a component, owned by the harness. Throws what its constructor throws.
  template <class C>
  C& make(const ComponentSpec& spec = {}) {
    auto component = make_component<C>(component_options(spec));
    C& reference = *component;
    own(std::move(component));
    return reference;
  }
  /// The options that `make` uses, for a component that the test creates itself.
  [[nodiscard]] ComponentOptions component_options(const ComponentSpec& spec);
  /// Destroys a component created by `make`.
  void destroy(Component& component);

  /// Requests a transition and runs callbacks until it has ended.
  TransitionResult request(Component& component, LifecycleTransition transition);
  TransitionResult configure(Component& component);
  TransitionResult activate(Component& component);
  TransitionResult deactivate(Component& component);
  TransitionResult cleanup(Component& component);
  /// Requests the shutdown transition of the component's current state.
  TransitionResult shutdown(Component& component);
  /// Configures and activates; returns the result of the last attempted transition.
  TransitionResult bring_up(Component& component);

  /// Runs all ready work, and work that becomes ready meanwhile. Returns the number of callbacks.
  std::size_t spin();
  /// Runs callbacks, waiting for more, until `done` returns true. False after the time-out.
  bool spin_until(const std::function<bool()>& done, Duration timeout = std::chrono::seconds(10));

  /// Publishes; the message arrives at the next spin. Names are relative to the namespace.
  template <class T>
  void publish(const Topic<T>& topic, T message) {
    publish<T>(topic.name, std::move(message), topic.qos);
  }
  template <class T>
  void publish(std::string_view topic, T message, const QoS& qos = QoS::reliable(100)) {
    publisher(topic, message_type<T>(), qos)
        .publish(std::make_shared<const T>(std::move(message)), {});
  }

  /// Collects from now on; retained messages of transient local publishers come first.
  template <class T>
  [[nodiscard]] Collector<T> collect(const Topic<T>& topic) {
    return collect<T>(topic.name, topic.requested);
  }
  template <class T>
  [[nodiscard]] Collector<T> collect(std::string_view topic, QoS qos = QoS::reliable()) {
    qos.depth = std::max(qos.depth, kCollectorDepth);
    Collector<T> collector;
    collector.state_->subscription = peer().create_subscription<T>(
        topic, qos,
        [state = std::weak_ptr(collector.state_)](const std::shared_ptr<const T>& message) {
          if (const auto alive = state.lock()) {
            alive->messages.push_back(message);
          }
        });
    return collector;
  }

  /// Calls a service and runs callbacks until the answer, or until the executor is stopped.
  template <class S>
  typename Client<S>::Result call(std::string_view service, typename S::Request request,
                                  Duration timeout = std::chrono::seconds(10)) {
    using Result = typename Client<S>::Result;
    Client<S> client = peer().create_client<S>(service);
    // Shared with the client, which answers outstanding calls when it is destroyed.
    const auto result = std::make_shared<std::optional<Result>>();
    client.call(
        std::move(request), [result](Result answer) { *result = std::move(answer); }, timeout);
    spin_until([&result] { return result->has_value(); }, timeout + timeout);
    return result->value_or(Result(ServiceError::kTimeout));
  }

  /// Sets a parameter like another node, and runs the resulting callbacks.
  SetResult set_parameter(Component& component, const std::string& name, ParameterValue value);

  /// Moves the simulated time, and runs callbacks that became due. Timers fire at most once per
  /// call. Throws std::logic_error unless the option `simulated_time` is set.
  void set_time(Time now);
  void advance(Duration duration);

  /// The statuses that a component has published on `/diagnostics`, in order.
  [[nodiscard]] std::vector<diagnostic_msgs::msg::DiagnosticStatus> diagnostics(
      const Component& component);
  /// Waits for the next status of a component: with simulated time by advancing it by a second,
  /// else for up to two seconds. Throws std::runtime_error when none comes.
  diagnostic_msgs::msg::DiagnosticStatus next_diagnostics(const Component& component);
  /// The value under a key of a status; nothing when there is none.
  [[nodiscard]] static std::optional<std::string> value(
      const diagnostic_msgs::msg::DiagnosticStatus& status, std::string_view key);

  /// The log messages of the components, in order.
  [[nodiscard]] std::vector<LogEntry> logs();

  [[nodiscard]] Context& context();
  [[nodiscard]] Executor& executor();
  /// The node that publishes and subscribes for the test, always active.
  [[nodiscard]] Node& peer();

 private:
  static constexpr std::size_t kCollectorDepth = 10000;

  void own(ComponentPtr<> component);
  /// The received diagnostics of a component; runs no callbacks.
  [[nodiscard]] std::vector<diagnostic_msgs::msg::DiagnosticStatus> arrived_diagnostics(
      const Component& component) const;
  UntypedPublisher& publisher(std::string_view topic, const MessageType& type, const QoS& qos);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pipescout::testing
