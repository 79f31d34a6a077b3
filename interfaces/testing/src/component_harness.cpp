// SPDX-License-Identifier: Apache-2.0
#include "pipescout/testing/component_harness.hpp"

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <rcl_interfaces/msg/log.hpp>
#include <stdexcept>

#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::testing {

namespace {

constexpr Duration kDiagnosticsPeriod = std::chrono::seconds(1);
constexpr Duration kTransitionTimeout = std::chrono::seconds(30);

}  // namespace

class ComponentHarness::Impl {
 public:
  explicit Impl(HarnessOptions given)
      : options(std::move(given)),
        context(Context::create_in_process()),
        peer(NodeOptions{.context = context,
                         .executor = &executor,
                         .name = {options.ns, "_component_harness"},
                         .standard_interfaces = false}),
        diagnostics(peer.create_subscription(
            topics::kDiagnostics,
            [this](const diagnostic_msgs::msg::DiagnosticArray& message) {
              statuses.insert(statuses.end(), message.status.begin(), message.status.end());
            })),
        rosout(peer.create_subscription(
            topics::kRosout, [this](const rcl_interfaces::msg::Log& message) {
              logs.push_back({static_cast<LogSeverity>(message.level), message.name, message.msg});
            })) {}

  const HarnessOptions options;
  const std::shared_ptr<Context> context;
  Executor executor;
  Node peer;
  std::vector<diagnostic_msgs::msg::DiagnosticStatus> statuses;
  std::vector<LogEntry> logs;
  std::map<std::string, std::shared_ptr<UntypedPublisher>, std::less<>> publishers;
  const Subscription<diagnostic_msgs::msg::DiagnosticArray> diagnostics;
  const Subscription<rcl_interfaces::msg::Log> rosout;
  std::vector<ComponentPtr<>> components;
};

ComponentHarness::ComponentHarness(HarnessOptions options)
    : impl_(std::make_unique<Impl>(std::move(options))) {}

ComponentHarness::~ComponentHarness() = default;

ComponentOptions ComponentHarness::component_options(const ComponentSpec& spec) {
  ComponentOptions options;
  options.context = impl_->context;
  options.executor = &impl_->executor;
  options.name = {impl_->options.ns, spec.name};
  for (const std::string& rule : spec.remappings) {
    options.remap_rules.push_back(RemapRule::parse(rule));
  }
  if (impl_->options.simulated_time) {
    options.parameter_overrides.push_back({.name = "use_sim_time",
                                           .value = true,
                                           .source = "component harness",
                                           .from_wildcard = true});
  }
  for (const NamedParameter& parameter : spec.parameters) {
    options.parameter_overrides.push_back({.name = parameter.name,
                                           .value = parameter.value,
                                           .source = "component harness",
                                           .from_wildcard = false});
  }
  return options;
}

void ComponentHarness::own(ComponentPtr<> component) {
  impl_->components.push_back(std::move(component));
}

void ComponentHarness::destroy(Component& component) {
  std::erase_if(impl_->components,
                [&component](const ComponentPtr<>& owned) { return owned.get() == &component; });
}

TransitionResult ComponentHarness::request(Component& component, LifecycleTransition transition) {
  // Shared: an answer that comes after the time is over must find its place.
  const auto result = std::make_shared<std::optional<TransitionResult>>();
  component.request_transition(transition,
                               [result](const TransitionResult& outcome) { *result = outcome; });
  if (!spin_until([&result] { return result->has_value(); }, kTransitionTimeout)) {
    return {false, component.state(), "the transition did not end in time"};
  }
  spin();
  return **result;
}

TransitionResult ComponentHarness::configure(Component& component) {
  return request(component, LifecycleTransition::kConfigure);
}

TransitionResult ComponentHarness::activate(Component& component) {
  return request(component, LifecycleTransition::kActivate);
}

TransitionResult ComponentHarness::deactivate(Component& component) {
  return request(component, LifecycleTransition::kDeactivate);
}

TransitionResult ComponentHarness::cleanup(Component& component) {
  return request(component, LifecycleTransition::kCleanup);
}

TransitionResult ComponentHarness::shutdown(Component& component) {
  const auto transition = requested_transition(component.state(), 0, "shutdown");
  if (!transition) {
    return {false, component.state(),
            "no shutdown from state '" + std::string(to_string(component.state())) + "'"};
  }
  return request(component, *transition);
}

TransitionResult ComponentHarness::bring_up(Component& component) {
  const TransitionResult configured = configure(component);
  return configured.success ? activate(component) : configured;
}

std::size_t ComponentHarness::spin() {
  return impl_->executor.spin_ready();
}

bool ComponentHarness::spin_until(const std::function<bool()>& done, Duration timeout) {
  return impl_->executor.spin_until(done, timeout);
}

UntypedPublisher& ComponentHarness::publisher(std::string_view topic, const MessageType& type,
                                              const QoS& qos) {
  auto found = impl_->publishers.find(topic);
  if (found == impl_->publishers.end()) {
    found = impl_->publishers
                .emplace(std::string(topic), impl_->peer.create_untyped_publisher(topic, type, qos))
                .first;
  }
  if (found->second->topic().type != &type) {
    throw std::logic_error("the harness publishes '" + std::string(topic) + "' with another type");
  }
  return *found->second;
}

SetResult ComponentHarness::set_parameter(Component& component, const std::string& name,
                                          ParameterValue value) {
  SetResult result = component.parameters().set(name, std::move(value));
  spin();
  return result;
}

void ComponentHarness::set_time(Time now) {
  if (!impl_->options.simulated_time) {
    throw std::logic_error("the harness was made without simulated time");
  }
  impl_->context->simulated_clock()->set(now);
  spin();
}

void ComponentHarness::advance(Duration duration) {
  set_time(impl_->context->simulated_clock()->now() + duration);
}

std::vector<diagnostic_msgs::msg::DiagnosticStatus> ComponentHarness::arrived_diagnostics(
    const Component& component) const {
  const std::string name = component.node_name().fully_qualified().substr(1) + ": status";
  std::vector<diagnostic_msgs::msg::DiagnosticStatus> result;
  for (const auto& status : impl_->statuses) {
    if (status.name == name) {
      result.push_back(status);
    }
  }
  return result;
}

std::vector<diagnostic_msgs::msg::DiagnosticStatus> ComponentHarness::diagnostics(
    const Component& component) {
  spin();
  return arrived_diagnostics(component);
}

diagnostic_msgs::msg::DiagnosticStatus ComponentHarness::next_diagnostics(
    const Component& component) {
  const std::size_t before = diagnostics(component).size();
  if (impl_->options.simulated_time) {
    advance(kDiagnosticsPeriod);
  } else {
    spin_until([&] { return arrived_diagnostics(component).size() > before; },
               2 * kDiagnosticsPeriod);
  }
  const auto statuses = arrived_diagnostics(component);
  if (statuses.size() <= before) {
    throw std::runtime_error(component.node_name().fully_qualified() + " published no diagnostics");
  }
  return statuses.at(before);
}

std::optional<std::string> ComponentHarness::value(
    const diagnostic_msgs::msg::DiagnosticStatus& status, std::string_view key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) {
      return pair.value;
    }
  }
  return std::nullopt;
}

std::vector<LogEntry> ComponentHarness::logs() {
  spin();
  return impl_->logs;
}

Context& ComponentHarness::context() {
  return *impl_->context;
}

Executor& ComponentHarness::executor() {
  return impl_->executor;
}

Node& ComponentHarness::peer() {
  return impl_->peer;
}

}  // namespace pipescout::testing
