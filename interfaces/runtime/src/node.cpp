// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/node.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <rosgraph_msgs/msg/clock.hpp>
#include <stdexcept>

#include "logger_services.hpp"
#include "parameter_services.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "rosout.hpp"
#include "step_reporter.hpp"
#include "transform_listener.hpp"

namespace pipescout {

namespace {

template <class T>
std::vector<std::shared_ptr<T>> alive(const std::vector<std::weak_ptr<T>>& all) {
  std::vector<std::shared_ptr<T>> result;
  for (const auto& weak : all) {
    if (auto strong = weak.lock()) {
      result.push_back(std::move(strong));
    }
  }
  return result;
}

template <class T>
void add(std::vector<std::weak_ptr<T>>& all, const std::shared_ptr<T>& one) {
  std::erase_if(all, [](const std::weak_ptr<T>& weak) { return weak.expired(); });
  all.push_back(one);
}

/// True when no callback of the groups is running. Otherwise `idle` is called once none of any of
/// them is.
bool when_all_idle(const std::vector<std::shared_ptr<CallbackGroup>>& groups,
                   const std::function<void()>& idle) {
  // One more for this function: only when it is through can the last one be known.
  const auto left = std::make_shared<std::atomic<std::size_t>>(groups.size() + 1);
  for (const auto& group : groups) {
    const bool is_idle = group->when_idle([left, idle] {
      if (--*left == 0) {
        idle();
      }
    });
    if (is_idle) {
      --*left;
    }
  }
  return --*left == 0;
}

}  // namespace

class Node::Impl {
 public:
  /// Which callbacks may not begin.
  enum class Held {
    kNone,
    kAllButDefault,  ///< a transition is in progress
    kAll,            ///< the object is not complete yet
    kStopped,        ///< all, for good
  };

  Impl(Node& node, NodeOptions given, CallbackStart start)
      : options(std::move(given)),
        name(remap_node(options.name, options.remap_rules)),
        logger(name.logger_name()),
        parameters(options.parameter_overrides),
        held(start == CallbackStart::kWhenAllowed ? Held::kAll : Held::kNone),
        node_(node) {
    default_group = create_group(CallbackGroupType::kMutuallyExclusive);
  }

  std::shared_ptr<CallbackGroup> create_group(CallbackGroupType type) {
    auto group = options.executor->create_callback_group(type);
    group->set_exception_handler(
        [this](std::exception_ptr error) { node_.on_callback_exception(std::move(error)); });
    group->join(options.context->activity(), name.fully_qualified());
    const std::lock_guard lock(mutex);
    if (held != Held::kNone) {
      group->hold();
      held_groups.push_back(group);
    }
    add(groups, group);
    return group;
  }

  /// The group that an endpoint asks for. A foreign one would not be held back in a transition, nor
  /// be closed with the node.
  const std::shared_ptr<CallbackGroup>& own_group(
      const std::shared_ptr<CallbackGroup>& wanted) const {
    if (!wanted) {
      return default_group;
    }
    const std::lock_guard lock(mutex);
    if (std::none_of(groups.begin(), groups.end(), [&](const std::weak_ptr<CallbackGroup>& own) {
          return own.lock() == wanted;
        })) {
      throw std::invalid_argument("node '" + name.fully_qualified() +
                                  "': a callback group of another node");
    }
    return wanted;
  }

  /// Lets callbacks begin again that are held for that reason; changes nothing when they are not.
  void release(Held reason);

  /// Follows `/clock`, or the time of this machine. Calls must not overlap.
  void use_simulated_time(bool simulated);

  const NodeOptions options;
  const NodeName name;
  const Logger logger;
  Parameters parameters;
  std::shared_ptr<CallbackGroup> default_group;

  mutable std::mutex mutex;
  Held held;
  // As queued work keeps a group that is not held.
  std::vector<std::shared_ptr<CallbackGroup>> held_groups;
  bool managed_active = true;
  bool services_enabled = true;
  std::shared_ptr<SimulatedClock> simulated_clock;  // null: system time
  std::shared_ptr<UntypedSubscription> clock_subscription;
  std::shared_ptr<StepParticipation> step_participation;  // null unless it follows `/clock`
  std::vector<std::weak_ptr<Timer>> timers;
  std::vector<std::weak_ptr<CallbackGroup>> groups;
  std::vector<std::weak_ptr<UntypedPublisher>> publishers;
  std::vector<std::weak_ptr<UntypedSubscription>> subscriptions;
  std::vector<std::weak_ptr<UntypedService>> services;
  std::vector<std::weak_ptr<UntypedClient>> clients;
  std::vector<std::weak_ptr<UntypedActionServer>> action_servers;
  std::vector<std::weak_ptr<UntypedPublisher>> managed_publishers;
  std::vector<std::weak_ptr<UntypedSubscription>> managed_subscriptions;
  std::vector<std::weak_ptr<UntypedService>> managed_services;
  std::vector<std::weak_ptr<Timer>> managed_timers;
  std::vector<std::weak_ptr<UntypedActionServer>> managed_action_servers;

  ParameterCallbackHandle use_sim_time_changed;
  std::unique_ptr<ParameterServices> parameter_services;
  std::unique_ptr<LoggerServices> logger_services;
  std::unique_ptr<Rosout> rosout;
  std::unique_ptr<Transforms> transforms;  // null: not in use

 private:
  Node& node_;
};

void Node::Impl::use_simulated_time(bool simulated) {
  std::shared_ptr<SimulatedClock> clock;
  std::shared_ptr<UntypedSubscription> subscription;
  std::shared_ptr<StepParticipation> participation;
  if (simulated) {
    Context& context = *options.context;
    const std::string topic = resolve_topic_name(topics::kClock.name, name, options.remap_rules);
    const std::string wire_topic = mangle_topic_name(topic, DdsTopicKind::kTopic);
    clock = context.simulated_clock(topic);
    // First: from the first message of the clock on none may be lost.
    participation = context.take_part_in_steps(wire_topic, name.fully_qualified());
    // Without a group: the time must not wait for callbacks, which may ask for it.
    subscription = context.create_subscription(
        {.topic = {wire_topic, &message_type<rosgraph_msgs::msg::Clock>()},
         .qos = topics::kClock.requested,
         .callback = [clock, source = std::make_shared<const char>()](
                         const std::shared_ptr<const void>& message, const MessageInfo&) {
           const auto& stamp = static_cast<const rosgraph_msgs::msg::Clock*>(message.get())->clock;
           clock->set_from(source, from_message(stamp));
         }});
    context.graph().add_endpoint(name, subscription);
  }
  std::vector<std::shared_ptr<Timer>> switched;
  {
    const std::lock_guard lock(mutex);
    simulated_clock = clock;
    clock_subscription.swap(subscription);
    step_participation.swap(participation);
    switched = alive(timers);
    if (transforms) {
      transforms->follow(clock);
    }
  }
  for (const auto& timer : switched) {
    timer->follow(clock);
  }
}

Node::Node(NodeOptions options) : Node(std::move(options), CallbackStart::kAtOnce) {}

Node::Node(NodeOptions options, CallbackStart start) {
  if (!options.context || options.executor == nullptr) {
    throw std::invalid_argument("node '" + options.name.name +
                                "': context and executor are needed");
  }
  impl_ = std::make_unique<Impl>(*this, std::move(options), start);
  impl_->name.validate();
  context().graph().add_node(impl_->name);
  try {
    if (impl_->options.standard_interfaces) {
      const auto use_sim_time = parameters().declare<bool>(
          "use_sim_time", false,
          {.description = "use the time of the topic /clock instead of the system clock"});
      impl_->use_simulated_time(use_sim_time.get());
      impl_->use_sim_time_changed =
          parameters().on_changed([this, use_sim_time](const std::vector<NamedParameter>& changed) {
            if (std::any_of(changed.begin(), changed.end(), [&](const NamedParameter& parameter) {
                  return parameter.name == use_sim_time.name();
                })) {
              impl_->use_simulated_time(use_sim_time.get());
            }
          });
      impl_->rosout = std::make_unique<Rosout>(*this);
      impl_->parameter_services = std::make_unique<ParameterServices>(*this);
      impl_->logger_services = std::make_unique<LoggerServices>(*this);
    }
  } catch (...) {
    context().graph().remove_node(impl_->name);
    throw;
  }
}

Node::~Node() {
  close();
  for (const auto& server : action_servers()) {
    server->close();  // it asks for the node's time
  }
  impl_->use_sim_time_changed.reset();
  impl_->clock_subscription.reset();
  impl_->step_participation.reset();
  impl_->logger_services.reset();
  impl_->parameter_services.reset();
  impl_->transforms.reset();
  impl_->rosout.reset();
  context().graph().remove_node(impl_->name);
}

void Node::Impl::release(Held reason) {
  std::vector<std::shared_ptr<CallbackGroup>> released;
  {
    const std::lock_guard lock(mutex);
    if (held != reason) {
      return;
    }
    held = Held::kNone;
    released.swap(held_groups);
  }
  for (const auto& group : released) {
    group->release();
  }
}

void Node::allow_callbacks() {
  impl_->release(Impl::Held::kAll);
}

bool Node::hold_other_groups(std::function<void()> idle) {
  std::vector<std::shared_ptr<CallbackGroup>> others;
  {
    const std::lock_guard lock(impl_->mutex);
    others = alive(impl_->groups);
    std::erase(others, impl_->default_group);
    if (impl_->held == Impl::Held::kNone) {
      impl_->held = Impl::Held::kAllButDefault;
      impl_->held_groups = others;
      for (const auto& group : others) {
        group->hold();
      }
    }
  }
  return when_all_idle(
      others, [group = impl_->default_group, idle = std::move(idle)] { group->post(idle); });
}

void Node::release_other_groups() {
  impl_->release(Impl::Held::kAllButDefault);
}

void Node::stop_callbacks(const std::function<void()>& stopped) {
  std::vector<std::shared_ptr<CallbackGroup>> groups;
  {
    const std::lock_guard lock(impl_->mutex);
    groups = alive(impl_->groups);
    impl_->held = Impl::Held::kStopped;
    for (const auto& group : groups) {
      group->hold();
    }
  }
  if (when_all_idle(groups, stopped)) {
    stopped();
  }
}

void Node::close() {
  std::vector<std::shared_ptr<CallbackGroup>> groups;
  {
    const std::lock_guard lock(impl_->mutex);
    groups = alive(impl_->groups);
  }
  for (const auto& group : groups) {
    group->close();
  }
}

const NodeName& Node::node_name() const {
  return impl_->name;
}
bool Node::has_standard_interfaces() const {
  return impl_->options.standard_interfaces;
}

Context& Node::context() const {
  return *impl_->options.context;
}
Executor& Node::executor() const {
  return *impl_->options.executor;
}
const Logger& Node::logger() const {
  return impl_->logger;
}
Parameters& Node::parameters() const {
  return impl_->parameters;
}

std::string Node::resolve_topic(std::string_view name) const {
  return resolve_topic_name(name, impl_->name, impl_->options.remap_rules);
}

Transforms& Node::transforms() {
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->transforms) {
      return *impl_->transforms;
    }
  }
  auto made = std::make_unique<Transforms>(*this);
  const auto subscriptions = made->listener_->subscriptions();
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->transforms) {
      return *impl_->transforms;  // another thread was faster
    }
    if (impl_->simulated_clock) {
      made->follow(impl_->simulated_clock);
    }
    impl_->transforms = std::move(made);
    for (const auto& subscription : subscriptions) {
      add(impl_->subscriptions, subscription);
    }
  }
  for (const auto& subscription : subscriptions) {
    context().graph().add_shared_endpoint(impl_->name, subscription);
  }
  return *impl_->transforms;
}

const Transforms* Node::transforms_in_use() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->transforms.get();
}

std::shared_ptr<SimulatedClock> Node::simulated_clock() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->simulated_clock;
}

Time Node::now() const {
  const std::shared_ptr<SimulatedClock> simulated = simulated_clock();
  return simulated ? simulated->now() : context().system_clock()->now();
}

const std::shared_ptr<CallbackGroup>& Node::default_group() const {
  return impl_->default_group;
}

std::shared_ptr<CallbackGroup> Node::create_callback_group(CallbackGroupType type) {
  return impl_->create_group(type);
}

std::shared_ptr<UntypedPublisher> Node::create_untyped_publisher(std::string_view topic,
                                                                 const MessageType& type,
                                                                 const QoS& qos,
                                                                 NodePublisherOptions options) {
  const std::string full = resolve_topic_name(topic, impl_->name, impl_->options.remap_rules);
  auto& incompatible_qos = options.events.incompatible_qos;
  incompatible_qos = [logger = impl_->logger, full,
                      told = std::move(incompatible_qos)](const IncompatibleQos& event) {
    logger.warn("a subscription of '" + full +
                "' requests an incompatible QoS, it receives nothing: " + to_string(event.policy));
    if (told) {
      told(event);
    }
  };
  auto publisher =
      context().create_publisher({.topic = {mangle_topic_name(full, DdsTopicKind::kTopic), &type},
                                  .qos = qos,
                                  .events = std::move(options.events),
                                  .group = impl_->own_group(options.group)});
  context().graph().add_endpoint(impl_->name, publisher);
  const std::lock_guard lock(impl_->mutex);
  add(impl_->publishers, publisher);
  if (options.managed) {
    add(impl_->managed_publishers, publisher);
    publisher->set_enabled(impl_->managed_active);
  }
  return publisher;
}

std::shared_ptr<UntypedSubscription> Node::create_untyped_subscription(
    std::string_view topic, const MessageType& type, const QoS& qos,
    UntypedSubscription::Callback callback, NodeSubscriptionOptions options) {
  const std::string full = resolve_topic_name(topic, impl_->name, impl_->options.remap_rules);
  if (!options.at_once) {
    auto& incompatible_qos = options.events.incompatible_qos;
    incompatible_qos = [logger = impl_->logger, full,
                        told = std::move(incompatible_qos)](const IncompatibleQos& event) {
      logger.warn(
          "a publisher of '" + full +
          "' offers an incompatible QoS, nothing is received from it: " + to_string(event.policy));
      if (told) {
        told(event);
      }
    };
  } else if (options.group) {
    throw std::invalid_argument("subscription of '" + full +
                                "': a callback at once runs in no callback group");
  }
  auto subscription = context().create_subscription(
      {.topic = {mangle_topic_name(full, DdsTopicKind::kTopic), &type},
       .qos = qos,
       .callback = std::move(callback),
       .events = std::move(options.events),
       .group = options.at_once ? nullptr : impl_->own_group(options.group),
       .while_inactive = options.while_inactive.value_or(WhileInactive::kKeep),
       .expected = options.expected,
       .enabled = !options.managed});
  context().graph().add_endpoint(impl_->name, subscription);
  const std::lock_guard lock(impl_->mutex);
  add(impl_->subscriptions, subscription);
  if (options.managed) {
    add(impl_->managed_subscriptions, subscription);
    subscription->set_enabled(impl_->managed_active);
  }
  return subscription;
}

std::shared_ptr<UntypedService> Node::create_untyped_service_on(std::string_view name,
                                                                const MessageType& request,
                                                                const MessageType& response,
                                                                UntypedService::Handler handler,
                                                                const NodeServiceOptions& options) {
  auto service = create_untyped_service(
      context(),
      {.name = resolve_service_name(name, impl_->name, impl_->options.remap_rules),
       .request = &request,
       .response = &response,
       .qos = options.qos,
       .group = impl_->own_group(options.group),
       .enabled = false},
      std::move(handler));
  context().graph().add_endpoint(impl_->name, service->reply_publisher());
  context().graph().add_endpoint(impl_->name, service->request_subscription());
  const std::lock_guard lock(impl_->mutex);
  add(impl_->services, service);
  return service;
}

void Node::enable_service(const std::shared_ptr<UntypedService>& service,
                          const NodeServiceOptions& options) {
  const std::lock_guard lock(impl_->mutex);
  if (options.managed) {
    add(impl_->managed_services, service);
  }
  service->set_enabled(!options.managed || impl_->services_enabled);
}

std::shared_ptr<UntypedClient> Node::create_untyped_client_on(std::string_view name,
                                                              const MessageType& request,
                                                              const MessageType& response,
                                                              const NodeClientOptions& options) {
  auto client = create_untyped_client(
      context(), {.name = resolve_service_name(name, impl_->name, impl_->options.remap_rules),
                  .request = &request,
                  .response = &response,
                  .qos = options.qos,
                  .group = impl_->own_group(options.group),
                  .matched = options.matched});
  context().graph().add_endpoint(impl_->name, client->request_publisher());
  context().graph().add_endpoint(impl_->name, client->reply_subscription());
  const std::lock_guard lock(impl_->mutex);
  add(impl_->clients, client);
  return client;
}

std::string Node::action_name(std::string_view name) const {
  return resolve_topic_name(name, impl_->name, impl_->options.remap_rules);
}

void Node::add_action_server(const std::shared_ptr<UntypedActionServer>& server, bool managed) {
  bool is_active = true;
  {
    const std::lock_guard lock(impl_->mutex);
    add(impl_->action_servers, server);
    if (!managed) {
      return;
    }
    add(impl_->managed_action_servers, server);
    is_active = impl_->managed_active;
  }
  // Without the lock, as the server asks for the time; so the state may change meanwhile.
  while (true) {
    server->set_accepting(is_active);
    const std::lock_guard lock(impl_->mutex);
    if (is_active == impl_->managed_active) {
      return;
    }
    is_active = impl_->managed_active;
  }
}

std::shared_ptr<Timer> Node::create_timer(Duration period, std::function<void()> callback,
                                          const TimerOptions& options) {
  const auto& group = impl_->own_group(options.group);
  const std::lock_guard lock(impl_->mutex);
  auto timer = std::make_shared<Timer>(group, period, std::move(callback), impl_->simulated_clock);
  add(impl_->timers, timer);
  if (options.managed) {
    add(impl_->managed_timers, timer);
    timer->set_enabled(impl_->managed_active);
  }
  return timer;
}

std::vector<std::shared_ptr<UntypedPublisher>> Node::publishers() const {
  const std::lock_guard lock(impl_->mutex);
  return alive(impl_->publishers);
}

std::vector<std::shared_ptr<UntypedSubscription>> Node::subscriptions() const {
  const std::lock_guard lock(impl_->mutex);
  return alive(impl_->subscriptions);
}

std::vector<std::shared_ptr<UntypedService>> Node::services() const {
  const std::lock_guard lock(impl_->mutex);
  return alive(impl_->services);
}

std::vector<std::shared_ptr<UntypedClient>> Node::clients() const {
  const std::lock_guard lock(impl_->mutex);
  return alive(impl_->clients);
}

std::vector<std::shared_ptr<UntypedActionServer>> Node::action_servers() const {
  const std::lock_guard lock(impl_->mutex);
  return alive(impl_->action_servers);
}

void Node::set_managed_active(bool active) {
  std::vector<std::shared_ptr<UntypedPublisher>> publishers;
  std::vector<std::shared_ptr<UntypedSubscription>> subscriptions;
  std::vector<std::shared_ptr<Timer>> timers;
  std::vector<std::shared_ptr<UntypedActionServer>> servers_of_actions;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->managed_active = active;
    publishers = alive(impl_->managed_publishers);
    subscriptions = alive(impl_->managed_subscriptions);
    timers = alive(impl_->managed_timers);
    servers_of_actions = alive(impl_->managed_action_servers);
  }
  // Publishers first when enabling: a callback that runs at once may publish.
  for (const auto& publisher : publishers) {
    publisher->set_enabled(active);
  }
  for (const auto& timer : timers) {
    timer->set_enabled(active);
  }
  for (const auto& subscription : subscriptions) {
    subscription->set_enabled(active);
  }
  for (const auto& server : servers_of_actions) {
    server->set_accepting(active);
  }
}

void Node::set_services_enabled(bool enabled) {
  std::vector<std::shared_ptr<UntypedService>> services;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->services_enabled = enabled;
    services = alive(impl_->managed_services);
  }
  for (const auto& service : services) {
    service->set_enabled(enabled);
  }
}

void Node::on_callback_exception(std::exception_ptr error) {
  std::rethrow_exception(std::move(error));
}

}  // namespace pipescout
