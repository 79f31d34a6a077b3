// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pipescout/files/yaml_location.hpp"
#include "pipescout/runtime/parameter_value.hpp"

/// Parameter files in the layout of ROS 2:
///
///     /**:                      # every node
///       ros__parameters:
///         use_sim_time: false
///     /robot_1/*/camera:        # * is one part of the name, ** any number of parts
///       ros__parameters:
///         exposure: {auto: true, limit: 0.02}     # exposure.auto, exposure.limit
///     robot_2:                  # a namespace may be nested
///       leak_inspector:
///         ros__parameters:
///           threshold: 2.5
///
/// Differences from rcl, which are all stricter: duplicate keys, values of null, names without
/// `ros__parameters` and whole numbers outside int64 are errors; a '*' stands for whole parts of a
/// name only.
namespace pipescout {

/// Whether a pattern of a parameter file matches a node: "/a/b" (also without the leading '/'), '*'
/// for exactly one part, '**' for any number of parts, also none.
[[nodiscard]] bool matches_node_pattern(std::string_view pattern,
                                        std::string_view fully_qualified_node_name);

/// The content of one `ros__parameters` of a file.
struct NodeParameters {
  std::string pattern;                        ///< with leading '/'
  std::string source;                         ///< "file:line" of the node's key
  std::vector<ParameterOverride> parameters;  ///< in the order of the file
};

/// A valid parameter file. A value type.
class ParameterFile {
 public:
  ParameterFile() = default;
  explicit ParameterFile(std::vector<NodeParameters> nodes) : nodes_(std::move(nodes)) {}

  /// In the order of the file.
  [[nodiscard]] const std::vector<NodeParameters>& nodes() const noexcept { return nodes_; }

  /// The parameters of one node, each name once. If several patterns match, the later one in the
  /// file wins, whether or not it is a wildcard, as in rclcpp.
  [[nodiscard]] std::vector<ParameterOverride> overrides_for(
      std::string_view fully_qualified_node_name) const;

 private:
  std::vector<NodeParameters> nodes_;
};

/// Throws YamlError.
[[nodiscard]] ParameterFile load_parameter_yaml(const std::string& path);

/// The same from text; `path` is the name in errors and sources.
[[nodiscard]] ParameterFile parse_parameter_yaml(const std::string& text, const std::string& path);

/// The content of a `ros__parameters` key (or of any map of parameters in another file), nested
/// maps flattened with '.'. Throws YamlError.
[[nodiscard]] std::vector<ParameterOverride> read_parameter_map(const YAML::Node& map,
                                                                const std::string& path);

/// As `ros2 param dump` writes it: one node, names sorted and nested at each '.', arrays one
/// element a line. If a name is also the prefix of another ("a" and "a.b"), the other one is
/// written flat; both forms are equivalent. Parameters that are not set are omitted. Reading the
/// text back gives the same values, except that empty arrays lose their element type and strings
/// must be UTF-8.
[[nodiscard]] std::string dump_parameter_yaml(std::string_view fully_qualified_node_name,
                                              const std::vector<NamedParameter>& parameters);

}  // namespace pipescout
