// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component_container.hpp"

#include <algorithm>
#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <exception>
#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "pipescout/runtime/bring_up.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

namespace srv = composition_interfaces::srv;

std::string no_component(std::uint64_t id) {
  return "no component with unique id " + std::to_string(id);
}

/// What `load_node` asks for.
struct WireRequest {
  LoadRequest load;
  bool autostart = true;
  std::vector<std::string> ignored{};  ///< what the request says that means nothing here
};

bool boolean_argument(const NamedParameter& argument) {
  const bool* value = argument.value.get_if<bool>();
  if (value == nullptr) {
    throw std::invalid_argument("extra argument '" + argument.name + "' is " +
                                to_string(argument.value.type()) + ", not boolean");
  }
  return *value;
}

/// Throws std::invalid_argument.
WireRequest read(const srv::LoadNode::Request& message) {
  WireRequest request;
  request.load.class_name = message.plugin_name;
  request.load.package = message.package_name;
  request.load.name = {join_namespaces("/", message.node_namespace), message.node_name};
  for (const std::string& rule : message.remap_rules) {
    request.load.remap_rules.push_back(RemapRule::parse(rule));
  }
  for (const auto& parameter : message.parameters) {
    NamedParameter named = from_message(parameter);
    request.load.parameter_overrides.push_back({.name = std::move(named.name),
                                                .value = std::move(named.value),
                                                .source = "load_node",
                                                .from_wildcard = false});
  }
  for (const auto& parameter : message.extra_arguments) {
    const NamedParameter argument = from_message(parameter);
    if (argument.name == "autostart") {
      request.autostart = boolean_argument(argument);
    } else if (argument.name == "use_intra_process_comms" ||
               argument.name == "forward_global_arguments") {
      boolean_argument(argument);
    } else {
      request.ignored.push_back("unknown extra argument '" + argument.name + "'");
    }
  }
  if (message.log_level != 0) {
    const auto severity = static_cast<LogSeverity>(message.log_level);
    const bool known = severity == LogSeverity::kDebug || severity == LogSeverity::kInfo ||
                       severity == LogSeverity::kWarn || severity == LogSeverity::kError ||
                       severity == LogSeverity::kFatal;
    if (known) {
      request.load.log_threshold = severity;
    } else {
      request.ignored.push_back("log level " + std::to_string(message.log_level) +
                                " is not one of 10, 20, 30, 40, 50");
    }
  }
  return request;
}

}  // namespace

class ComponentContainer::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(ContainerOptions options, ComponentRegistry registry)
      : options_(std::move(options)),
        registry_(std::move(registry)),
        node_(NodeOptions{.context = options_.context,
                          .executor = options_.executor,
                          .name = options_.name,
                          .standard_interfaces = true}) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  ~Impl() {
    while (!entries_.empty()) {
      entries_.erase(std::prev(entries_.end()));
    }
  }

  /// Second part of construction: needs weak_from_this.
  void serve();

  Node& node() { return node_; }
  const ComponentRegistry& registry() const { return registry_; }

  enum class UnusedOverrides { kRefuse, kWarn };
  LoadedComponent load(LoadRequest request, UnusedOverrides unused);
  void start(std::uint64_t id, Done done);
  void unload(std::uint64_t id, Done done);
  void unload_all(std::function<void()> done);
  std::vector<LoadedComponent> components() const;

 private:
  struct Entry {
    LoadedComponent loaded;
    bool unloading = false;
    std::vector<std::function<void()>> when_gone;
  };

  ComponentPtr<> create(const LoadRequest& request) const;
  /// Calls `done` in the container's group.
  void tell(Done done, TransitionResult result) {
    if (done) {
      node_.default_group()->post(
          [done = std::move(done), result = std::move(result)] { done(result); });
    }
  }
  void take_down(std::uint64_t id, Component& component);
  void destroy(std::uint64_t id);
  void unload_next(std::vector<std::uint64_t> ids, std::function<void()> done);

  void on_load(const srv::LoadNode::Request& message, const Responder<srv::LoadNode>& responder);
  void start_loaded(const LoadedComponent& loaded, const Responder<srv::LoadNode>& responder);

  const ContainerOptions options_;
  const ComponentRegistry registry_;
  Node node_;
  mutable std::mutex mutex_;
  std::uint64_t last_id_ = 0;
  std::map<std::uint64_t, Entry> entries_;
  Service<srv::LoadNode> load_node_;
  Service<srv::UnloadNode> unload_node_;
  Service<srv::ListNodes> list_nodes_;
};

ComponentPtr<> ComponentContainer::Impl::create(const LoadRequest& request) const {
  ComponentOptions options;
  options.context = options_.context;
  options.executor = request.executor != nullptr ? request.executor : options_.executor;
  options.name = request.name;
  options.remap_rules = request.remap_rules;
  options.parameter_overrides = request.parameter_overrides;
  const std::string what =
      "component '" + request.name.fully_qualified() + "' (" + request.class_name + "): ";
  try {
    return registry_.create(request.class_name, std::move(options), request.package);
  } catch (const UnknownComponent&) {
    throw;
  } catch (const ComponentLoadError&) {
    throw;
  } catch (const InvalidName&) {
    throw;
  } catch (const ParameterError&) {
    throw;
  } catch (const std::exception& error) {
    throw std::runtime_error(what + error.what());
  } catch (...) {
    throw std::runtime_error(what + "its constructor threw an object that is not a std::exception");
  }
}

LoadedComponent ComponentContainer::Impl::load(LoadRequest request, UnusedOverrides on_unused) {
  if (request.name.name.empty()) {
    request.name.name = default_component_name(request.class_name);
  }
  const std::shared_ptr<Component> component = create(request);
  for (const UnusedOverride& unused : component->parameters().unused_overrides()) {
    if (unused.parameter.from_wildcard) {
      continue;
    }
    const std::string what =
        to_string(unused) + " (component '" + component->node_name().fully_qualified() + "')";
    if (on_unused == UnusedOverrides::kRefuse) {
      throw ParameterError(unused.parameter.name, what);
    }
    node_.logger().warn(what);
  }
  if (request.log_threshold) {
    Logger logger = component->logger();
    logger.set_threshold(*request.log_threshold);
  }
  const std::lock_guard lock(mutex_);
  const std::uint64_t id = ++last_id_;
  LoadedComponent loaded{id, request.class_name, component};
  entries_.emplace(id, Entry{loaded, false, {}});
  return loaded;
}

void ComponentContainer::Impl::start(std::uint64_t id, Done done) {
  std::shared_ptr<Component> component;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(id); found != entries_.end() && !found->second.unloading) {
      component = found->second.loaded.component;
    }
  }
  if (!component) {
    tell(std::move(done), {false, LifecycleState::kUnknown, no_component(id)});
    return;
  }
  // A plain pointer: these run in the component's own group, where nothing may be its last owner.
  bring_up(*component,
           [weak = weak_from_this(), done = std::move(done)](const TransitionResult& result) {
             if (const auto self = weak.lock()) {
               self->tell(done, result);
             }
           });
}

void ComponentContainer::Impl::unload(std::uint64_t id, Done done) {
  std::shared_ptr<Component> component;
  std::string refusal = no_component(id);
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(id);
    if (found != entries_.end() && found->second.unloading) {
      refusal = "the component with unique id " + std::to_string(id) + " is being unloaded already";
    } else if (found != entries_.end()) {
      Entry& entry = found->second;
      entry.unloading = true;
      component = entry.loaded.component;
      if (done) {
        entry.when_gone.emplace_back([done] { done({true, LifecycleState::kFinalized, {}}); });
      }
    }
  }
  if (component) {
    take_down(id, *component);
  } else {
    tell(std::move(done), {false, LifecycleState::kUnknown, std::move(refusal)});
  }
}

void ComponentContainer::Impl::take_down(std::uint64_t id, Component& component) {
  // On to the container's group: a component must not be destroyed by its own callback. Not before
  // the last of these has returned, as destroying it would wait for that, and all others with it.
  const auto destroy_later = [weak = weak_from_this(), id] {
    if (const auto self = weak.lock()) {
      self->node_.default_group()->post([weak, id] {
        if (const auto alive = weak.lock()) {
          alive->destroy(id);
        }
      });
    }
  };
  pipescout::take_down(component,
                       [&component, destroy_later] { component.stop_callbacks(destroy_later); });
}

void ComponentContainer::Impl::destroy(std::uint64_t id) {
  Entry entry;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end()) {
      return;
    }
    entry = std::move(found->second);
    entries_.erase(found);
  }
  entry.loaded.component.reset();
  for (const auto& tell_gone : entry.when_gone) {
    tell_gone();
  }
}

void ComponentContainer::Impl::unload_all(std::function<void()> done) {
  std::vector<std::uint64_t> ids;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, entry] : entries_) {
      ids.push_back(id);
    }
  }
  node_.default_group()->post(
      [weak = weak_from_this(), ids = std::move(ids), done = std::move(done)] {
        if (const auto self = weak.lock()) {
          self->unload_next(ids, done);
        }
      });
}

void ComponentContainer::Impl::unload_next(std::vector<std::uint64_t> ids,
                                           std::function<void()> done) {
  std::shared_ptr<Component> component;
  std::uint64_t id = 0;
  {
    const std::lock_guard lock(mutex_);
    auto found = entries_.end();
    while (found == entries_.end() && !ids.empty()) {
      id = ids.back();
      ids.pop_back();
      found = entries_.find(id);
    }
    if (found != entries_.end()) {
      Entry& entry = found->second;
      entry.when_gone.emplace_back([weak = weak_from_this(), ids, done] {
        if (const auto self = weak.lock()) {
          self->unload_next(ids, done);
        }
      });
      if (entry.unloading) {
        return;
      }
      entry.unloading = true;
      component = entry.loaded.component;
    }
  }
  if (component) {
    take_down(id, *component);
  } else if (done) {
    done();
  }
}

std::vector<LoadedComponent> ComponentContainer::Impl::components() const {
  std::vector<LoadedComponent> result;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, entry] : entries_) {
    if (!entry.unloading) {
      result.push_back(entry.loaded);
    }
  }
  return result;
}

void ComponentContainer::Impl::serve() {
  load_node_ = node_.create_service<srv::LoadNode>(
      "~/_container/load_node",
      [weak = weak_from_this()](const std::shared_ptr<const srv::LoadNode::Request>& request,
                                Responder<srv::LoadNode> responder) {
        if (const auto self = weak.lock()) {
          self->on_load(*request, responder);
        }
      });
  unload_node_ = node_.create_service<srv::UnloadNode>(
      "~/_container/unload_node",
      [weak = weak_from_this()](const std::shared_ptr<const srv::UnloadNode::Request>& request,
                                Responder<srv::UnloadNode> responder) {
        if (const auto self = weak.lock()) {
          self->unload(request->unique_id, [responder](const TransitionResult& result) {
            srv::UnloadNode::Response response;
            response.success = result.success;
            response.error_message = result.message;
            responder.respond(std::move(response));
          });
        }
      });
  list_nodes_ = node_.create_service<srv::ListNodes>(
      "~/_container/list_nodes", [weak = weak_from_this()](const srv::ListNodes::Request&,
                                                           srv::ListNodes::Response& response) {
        if (const auto self = weak.lock()) {
          for (const LoadedComponent& loaded : self->components()) {
            response.unique_ids.push_back(loaded.id);
            response.full_node_names.push_back(loaded.component->node_name().fully_qualified());
          }
        }
      });
}

namespace {

srv::LoadNode::Response loaded_response(const LoadedComponent& loaded) {
  srv::LoadNode::Response response;
  response.success = true;
  response.unique_id = loaded.id;
  response.full_node_name = loaded.component->node_name().fully_qualified();
  return response;
}

srv::LoadNode::Response failed_response(const std::string& why) {
  srv::LoadNode::Response response;
  response.success = false;
  response.error_message = why;
  return response;
}

}  // namespace

void ComponentContainer::Impl::on_load(const srv::LoadNode::Request& message,
                                       const Responder<srv::LoadNode>& responder) {
  try {
    WireRequest request = read(message);
    for (const std::string& ignored : request.ignored) {
      node_.logger().warn("load_node: " + ignored + "; ignored");
    }
    const LoadedComponent loaded = load(std::move(request.load), UnusedOverrides::kWarn);
    if (request.autostart) {
      start_loaded(loaded, responder);
    } else {
      responder.respond(loaded_response(loaded));
    }
  } catch (const std::exception& error) {
    node_.logger().error(std::string("load_node: ") + error.what());
    responder.respond(failed_response(error.what()));
  }
}

void ComponentContainer::Impl::start_loaded(const LoadedComponent& loaded,
                                            const Responder<srv::LoadNode>& responder) {
  const auto response = loaded_response(loaded);
  start(loaded.id, [weak = weak_from_this(), id = loaded.id, response,
                    responder](const TransitionResult& started) {
    if (started.success) {
      responder.respond(response);
      return;
    }
    const std::string why =
        "component '" + response.full_node_name + "' does not start: " + started.message;
    if (const auto self = weak.lock()) {
      self->node_.logger().error("load_node: " + why);
      self->unload(id, [responder, why](const TransitionResult&) {
        responder.respond(failed_response(why));
      });
    }
  });
}

ComponentContainer::ComponentContainer(ContainerOptions options, ComponentRegistry registry)
    : impl_(std::make_shared<Impl>(std::move(options), std::move(registry))) {
  impl_->serve();
  for (const std::string& problem : impl_->registry().problems()) {
    impl_->node().logger().warn("index of components: " + problem);
  }
}

ComponentContainer::~ComponentContainer() = default;

Node& ComponentContainer::node() const {
  return impl_->node();
}
const ComponentRegistry& ComponentContainer::registry() const {
  return impl_->registry();
}
LoadedComponent ComponentContainer::load(LoadRequest request) {
  return impl_->load(std::move(request), Impl::UnusedOverrides::kRefuse);
}
void ComponentContainer::start(std::uint64_t id, Done done) {
  impl_->start(id, std::move(done));
}
void ComponentContainer::unload(std::uint64_t id, Done done) {
  impl_->unload(id, std::move(done));
}
void ComponentContainer::unload_all(std::function<void()> done) {
  impl_->unload_all(std::move(done));
}
std::vector<LoadedComponent> ComponentContainer::components() const {
  return impl_->components();
}

}  // namespace pipescout
