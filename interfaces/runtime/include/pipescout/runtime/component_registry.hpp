// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// A component class that an installed package provides.
struct ComponentType {
  std::string class_name;  ///< fully qualified: "pipescout::OdometryFusion"
  std::string package;
  std::filesystem::path library;
  /// It looks at endpoints that are not its own, as a recorder of all topics does: behind a
  /// discovery server its process asks to be told everything.
  bool sees_whole_graph = false;

  bool operator==(const ComponentType&) const = default;
};

/// No package provides the class, or several do and none was selected. The message names the class,
/// similar or conflicting ones, and how many prefixes were searched.
class UnknownComponent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The class is registered, but its library cannot be loaded or does not contain it. The message
/// gives the library and the loader's reason.
class ComponentLoadError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Finds installed component classes by name and creates objects of them. A package lists its
/// classes in `<prefix>/share/ament_index/resource_index/pipescout_components/<package>`, see
/// `pipescout_add_component` in CMake. Of a package in several prefixes the first one is used, so
/// that an overlay workspace hides what it replaces.
///
/// Libraries are loaded when first needed and stay loaded until the process ends: messages and
/// exceptions of a component may outlive it, and their code is in its library.
///
/// Reads the index once, at construction. Thread-safe.
class ComponentRegistry {
 public:
  /// Searches `default_prefixes()`.
  ComponentRegistry();
  explicit ComponentRegistry(const std::vector<std::filesystem::path>& prefixes);

  /// The prefixes of `AMENT_PREFIX_PATH`, of `CMAKE_PREFIX_PATH`, that of the running executable,
  /// and in a workspace with a prefix per package (colcon's isolated layout) those of the other
  /// packages. Each once, in this order.
  [[nodiscard]] static std::vector<std::filesystem::path> default_prefixes();

  /// Sorted by class, then by package.
  [[nodiscard]] const std::vector<ComponentType>& types() const noexcept { return types_; }
  /// Errors of the index: "file:line: reason". The other entries are usable.
  [[nodiscard]] const std::vector<std::string>& problems() const noexcept { return problems_; }

  /// `package` empty: any package that provides the class. Throws UnknownComponent.
  [[nodiscard]] const ComponentType& find(std::string_view class_name,
                                          std::string_view package = {}) const;
  /// Whether a process that runs the class needs to be told of everything; false for a class that
  /// is not known, which `create` says.
  [[nodiscard]] bool sees_whole_graph(std::string_view class_name) const noexcept;
  /// Creates a component. Throws UnknownComponent, ComponentLoadError, and what the component's
  /// constructor throws.
  [[nodiscard]] ComponentPtr<> create(std::string_view class_name, ComponentOptions options,
                                      std::string_view package = {}) const;

 private:
  void read_index(const std::filesystem::path& prefix, const std::filesystem::path& file);

  std::size_t prefixes_ = 0;
  std::vector<ComponentType> types_;
  std::vector<std::string> problems_;
};

/// The default node name of a component: the class name without namespace in snake case,
/// "pipescout::OdometryFusion" -> "odometry_fusion".
[[nodiscard]] std::string default_component_name(std::string_view class_name);

}  // namespace pipescout
