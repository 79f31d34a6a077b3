// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/component_registry.hpp"

namespace pipescout {

/// Which component to load, and how it starts.
struct LoadRequest {
  std::string class_name;
  std::string package{};  ///< empty: any package that provides the class
  NodeName name{};        ///< empty name: `default_component_name`
  RemapRules remap_rules{};
  std::vector<ParameterOverride> parameter_overrides{};
  /// Log level of the component; none: the default of Logger.
  std::optional<LogSeverity> log_threshold{};
  /// Runs the component instead of the container's executor; must outlive the component.
  Executor* executor = nullptr;
};

/// While `component` is held, unloading neither destroys the component nor frees its name; a
/// callback of the component itself must not hold it.
struct LoadedComponent {
  std::uint64_t id = 0;  ///< unique in the container, never used again
  std::string class_name;
  std::shared_ptr<Component> component;
};

struct ContainerOptions {
  std::shared_ptr<Context> context;
  Executor* executor = nullptr;  ///< must outlive the container; runs its components too
  NodeName name{.ns = "/", .name = "pipescout_container"};
};

/// The components of one process: loads them, controls their lifecycle, and unloads them, for the
/// calling program and for clients on the network through the ROS 2 services
/// `~/_container/load_node`, `~/_container/unload_node` and `~/_container/list_nodes`, which `ros2
/// component` uses.
///
/// `load_node` extends ROS 2 for managed components: unless the extra argument `autostart` is
/// false, the new component is configured and activated too, and unloaded again when that fails. As
/// in ROS 2, unknown content of a request only gives a warning: a parameter that the component does
/// not declare, an unknown extra argument or log level. A parameter of the wrong type or out of
/// range is an error. (`use_intra_process_comms` and `forward_global_arguments` have no effect.)
///
/// Thread-safe. Callbacks run in the container's group on the executor.
class ComponentContainer {
 public:
  /// Result of starting or unloading; `message` is the reason of a failure.
  using Done = std::function<void(const TransitionResult& result)>;

  /// Throws what Node's constructor throws.
  explicit ComponentContainer(ContainerOptions options, ComponentRegistry registry = {});
  ComponentContainer(const ComponentContainer&) = delete;
  ComponentContainer& operator=(const ComponentContainer&) = delete;
  /// Destroys the components in their current states, last loaded first. For an orderly shutdown
  /// see `unload_all`.
  ~ComponentContainer();

  /// The node that serves the services.
  [[nodiscard]] Node& node() const;
  [[nodiscard]] const ComponentRegistry& registry() const;

  /// Creates a component, which is then unconfigured. Throws UnknownComponent, ComponentLoadError,
  /// InvalidName, ParameterError for a parameter that the component does not declare or refuses,
  /// std::runtime_error when this process has a component of that name or the constructor throws
  /// anything else. Strong exception guarantee.
  LoadedComponent load(LoadRequest request);

  /// Configures and activates a component; stops at the first failure. `done` gets a failure with
  /// state unknown when there is no such component (any more).
  void start(std::uint64_t id, Done done = {});

  /// Deactivates, cleans up and shuts down a component, continuing after failures, and destroys it.
  /// `done` gets a failure when there is no such component or it is being unloaded already.
  void unload(std::uint64_t id, Done done = {});
  /// Unloads all components one after the other, last loaded first.
  void unload_all(std::function<void()> done = {});

  /// In the order of loading, without those that are being unloaded.
  [[nodiscard]] std::vector<LoadedComponent> components() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace pipescout
