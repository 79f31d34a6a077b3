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
  std::string package{};  ///< empty: whichever offers the class
  NodeName name{};        ///< empty name: `default_component_name`
  RemapRules remap_rules{};
  std::vector<ParameterOverride> parameter_overrides{};
  /// Messages below it go nowhere; none: as Logger.
  std::optional<LogSeverity> log_threshold{};
  /// Runs the component in place of the container's; must outlive the component.
  Executor* executor = nullptr;
};

/// Whoever keeps `component` keeps the component from being destroyed, and its name taken, when it
/// is unloaded; a callback of the component itself must not hold it.
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

/// The components of one process: loads them, takes them through their lifecycle, and unloads them,
/// for a program that calls it and for anyone on the network through the ROS 2 services
/// `~/_container/load_node`, `~/_container/unload_node` and `~/_container/list_nodes`, which
/// `ros2 component` uses.
///
/// `load_node` differs from ROS 2 in what a managed component makes natural: unless the extra
/// argument `autostart` is false, the new component is configured and activated too, and it is
/// unloaded again when that fails. As in ROS 2, what a request says beyond what is understood
/// changes nothing: an overridden parameter that the component does not declare, an unknown extra
/// argument or log level is warned of. A parameter of the wrong type or out of range is an error.
/// (`use_intra_process_comms` and `forward_global_arguments` change nothing either.)
///
/// Thread-safe. Callbacks run in the container's group on the executor.
class ComponentContainer {
 public:
  /// How starting or unloading ended; `message` says why it failed.
  using Done = std::function<void(const TransitionResult& result)>;

  /// Throws what Node's constructor throws.
  explicit ComponentContainer(ContainerOptions options, ComponentRegistry registry = {});
  ComponentContainer(const ComponentContainer&) = delete;
  ComponentContainer& operator=(const ComponentContainer&) = delete;
  /// Destroys the components as they are, last loaded first. For an orderly end see `unload_all`.
  ~ComponentContainer();

  /// The node that serves the services.
  [[nodiscard]] Node& node() const;
  [[nodiscard]] const ComponentRegistry& registry() const;

  /// Makes a component, which is then unconfigured. Throws UnknownComponent, ComponentLoadError,
  /// InvalidName, ParameterError for a parameter that the component does not declare or refuses,
  /// std::runtime_error when this process has a component of that name or the constructor throws
  /// anything else. After an exception everything is as it was.
  LoadedComponent load(LoadRequest request);

  /// Configures and activates a component; stops where it fails. `done` gets a failure with state
  /// unknown when there is no such component (any more).
  void start(std::uint64_t id, Done done = {});

  /// Takes a component down (deactivate, clean up, shut down), whatever of it fails, and destroys
  /// it. `done` gets a failure when there is no such component or it is being unloaded already.
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
