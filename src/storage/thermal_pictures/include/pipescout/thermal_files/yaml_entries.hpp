// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pipescout {

/// Strict reader of YAML: unknown names are errors. All functions throw std::runtime_error,
/// "file:line: problem".
class YamlEntries {
 public:
  using Entry = std::pair<const char*, std::function<void(const YAML::Node&)>>;

  /// `name`: of the file, for messages.
  explicit YamlEntries(std::string name) : name_(std::move(name)) {}

  /// The root node; null for an empty text.
  [[nodiscard]] YAML::Node root(const std::string& text) const;
  [[noreturn]] void refuse(const YAML::Node& node, const std::string& what) const;

  /// Passes each value of a map to the entry of its name, in the order of the file.
  void entries(const YAML::Node& map, const std::string& what,
               const std::vector<Entry>& known) const;

  [[nodiscard]] double number(const YAML::Node& node) const;
  [[nodiscard]] int whole(const YAML::Node& node) const;
  [[nodiscard]] std::string text(const YAML::Node& node) const;
  /// A list of three numbers.
  [[nodiscard]] Eigen::Vector3d three(const YAML::Node& node) const;
  /// Index in `names`.
  [[nodiscard]] std::size_t chosen(const YAML::Node& node,
                                   const std::vector<std::string>& names) const;
  /// One of these values, with the names from `to_string`.
  template <class Values>
  [[nodiscard]] auto chosen(const YAML::Node& node, const Values& values) const {
    std::vector<std::string> names;
    for (const auto value : values) {
      names.emplace_back(to_string(value));
    }
    return values[chosen(node, names)];
  }

  /// Entries that set a variable.
  [[nodiscard]] Entry number_into(const char* key, double& target) const;
  [[nodiscard]] Entry number_into(const char* key, std::optional<double>& target) const;
  [[nodiscard]] Entry whole_into(const char* key, int& target) const;
  [[nodiscard]] Entry text_into(const char* key, std::string& target) const;

  /// Refuses the node with the message of `check` when that throws std::invalid_argument.
  void checked(const YAML::Node& node, const std::function<void()>& check) const;

 private:
  std::string name_;
};

/// With as many digits as a lossless round trip needs. `value`: finite.
[[nodiscard]] std::string yaml_number(double value);

/// The content of a file. Throws std::runtime_error naming it.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);

}  // namespace pipescout
