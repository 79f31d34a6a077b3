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

/// A component class that an installed package offers.
struct ComponentType {
  std::string class_name;  ///< fully qualified: "pipescout::OdometryFusion"
  std::string package;
  std::filesystem::path library;

  bool operator==(const ComponentType&) const = default;
};

/// No package offers the class, or several do and it is not said which is meant. The message names
/// the class, what is similar or in conflict, and how many prefixes were searched.
class UnknownComponent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The class is known, but its library cannot be loaded or does not have it. The message gives the
/// library and the loader's reason.
class ComponentLoadError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Finds component classes by name in what is installed, and makes objects of them. A package says
/// what it offers in `<prefix>/share/ament_index/resource_index/pipescout_components/<package>`,
/// see `pipescout_add_component` in CMake. A package that stands in several prefixes counts where
/// it is found first, so that an overlay workspace hides what it replaces.
///
/// Libraries are loaded when first needed and stay until the process ends: messages that a
/// component published, and exceptions that it threw, may live longer than itself, and their code
/// is in its library.
///
/// Looks at the disk once, at construction. Thread-safe.
class ComponentRegistry {
 public:
  /// Searches `default_prefixes()`.
  ComponentRegistry();
  explicit ComponentRegistry(const std::vector<std::filesystem::path>& prefixes);

  /// The prefixes of `AMENT_PREFIX_PATH`, of `CMAKE_PREFIX_PATH`, that of the running executable,
  /// and in a workspace with a prefix per package (colcon's isolated layout) those beside it. Each
  /// once, in this order.
  [[nodiscard]] static std::vector<std::filesystem::path> default_prefixes();

  /// Sorted by class, then by package.
  [[nodiscard]] const std::vector<ComponentType>& types() const noexcept { return types_; }
  /// What could not be read of the index: "file:line: reason". The rest is usable.
  [[nodiscard]] const std::vector<std::string>& problems() const noexcept { return problems_; }

  /// `package` empty: of whichever package offers the class. Throws UnknownComponent.
  [[nodiscard]] const ComponentType& find(std::string_view class_name,
                                          std::string_view package = {}) const;
  /// Makes a component. Throws UnknownComponent, ComponentLoadError, and what the component's
  /// constructor throws.
  [[nodiscard]] ComponentPtr<> create(std::string_view class_name, ComponentOptions options,
                                      std::string_view package = {}) const;

 private:
  void read_index(const std::filesystem::path& prefix, const std::filesystem::path& file);

  std::size_t prefixes_ = 0;
  std::vector<ComponentType> types_;
  std::vector<std::string> problems_;
};

/// The node name that a component of a class gets when none is given: the class's own name in snake
/// case, "pipescout::OdometryFusion" -> "odometry_fusion".
[[nodiscard]] std::string default_component_name(std::string_view class_name);

}  // namespace pipescout
