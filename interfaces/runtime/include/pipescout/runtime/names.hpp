// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Names of nodes, topics, services and types: validation, expansion to fully qualified names,
/// remapping, and mangling for DDS. The rules are those of ROS 2 Humble (rcl, rmw, rmw_fastrtps).
/// All functions are pure and thread-safe.
namespace pipescout {

/// An invalid name. The message gives the name, the reason and the position.
class InvalidName : public std::invalid_argument {
 public:
  /// `what_it_names`: "node name", "namespace", "topic name"; `position`: index of the first
  /// offending character.
  InvalidName(std::string_view what_it_names, std::string name, std::size_t position,
              std::string_view reason);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] std::size_t position() const noexcept { return position_; }

 private:
  std::string name_;
  std::size_t position_;
};

/// Letters, digits and '_'; no leading digit; 1 to 255 characters. Throws InvalidName.
void validate_node_name(std::string_view name);
/// "/" or "/a/b": absolute, at most 245 characters. Throws InvalidName.
void validate_namespace(std::string_view name);
/// A name as a user writes it: relative ("a/b"), private ("~/a") or absolute ("/a"), with `{...}`
/// substitutions. Holds for topics and services. Throws InvalidName.
void validate_topic_name(std::string_view name);
/// A name after expansion: absolute, no substitutions, at most 247 characters. Throws InvalidName.
void validate_full_topic_name(std::string_view name);

/// A node's identity in the graph.
struct NodeName {
  std::string ns = "/";  ///< namespace, absolute
  std::string name;

  bool operator==(const NodeName&) const = default;
  auto operator<=>(const NodeName&) const = default;

  /// "/ns/name"; "/name" in the root namespace.
  [[nodiscard]] std::string fully_qualified() const;
  /// "ns.name", as ROS 2 names a node's logger.
  [[nodiscard]] std::string logger_name() const;
  /// Throws InvalidName.
  void validate() const;
  /// Splits "/ns/name" (or "name", which is in the root namespace) at its last '/'. Throws
  /// InvalidName.
  [[nodiscard]] static NodeName parse(std::string_view fully_qualified);
};

/// A namespace below another: a relative `ns` ("arm", "a/b" or empty) is appended to `parent`, an
/// absolute one replaces it. Throws InvalidName.
[[nodiscard]] std::string join_namespaces(std::string_view parent, std::string_view ns);

/// The absolute name of a topic or service: "x" is below the node's namespace, "~/x" (or "~") below
/// the node, "/x" is absolute; `{node}`, `{ns}` and `{namespace}` are replaced by the node's. The
/// substitution `{ns}` carries its leading '/', so it belongs at the front of a name: "{ns}/x" is
/// "/a/x" in the namespace "/a" and "/x" in the root namespace. Throws InvalidName for an invalid
/// name, node, or an unknown substitution.
[[nodiscard]] std::string expand_topic_name(std::string_view name, const NodeName& node);

/// `from:=to`. The form of the rule determines what it applies to.
struct RemapRule {
  enum class Kind {
    kTopicOrService,  ///< `from:=to`
    kTopic,           ///< `rostopic://from:=to`
    kService,         ///< `rosservice://from:=to`
    kNodeName,        ///< `__node:=name` (or `__name:=`)
    kNamespace        ///< `__ns:=/namespace`
  };

  Kind kind = Kind::kTopicOrService;
  /// `node:from:=to`: only for nodes of this name (without namespace). Empty: for all.
  std::string node;
  std::string from;  ///< empty for kNodeName and kNamespace
  std::string to;

  bool operator==(const RemapRule&) const = default;

  /// Throws InvalidName when the rule or a name in it is malformed.
  [[nodiscard]] static RemapRule parse(std::string_view text);
};

/// Rules in the given order: the first that matches applies, and its result is not remapped again.
using RemapRules = std::vector<RemapRule>;

/// The remapped name of a node: `__node` rules match the given name, `__ns` rules the name after
/// them. Throws InvalidName when the result is invalid.
[[nodiscard]] NodeName remap_node(const NodeName& node, const RemapRules& rules);

/// Expands, remaps and validates. `node` is the name after `remap_node`. Throws InvalidName.
[[nodiscard]] std::string resolve_topic_name(std::string_view name, const NodeName& node,
                                             const RemapRules& rules);
/// The same for services.
[[nodiscard]] std::string resolve_service_name(std::string_view name, const NodeName& node,
                                               const RemapRules& rules);

/// The kind of a DDS topic in ROS 2.
enum class DdsTopicKind { kTopic, kServiceRequest, kServiceReply };

/// "rt/chatter"; "rq/add/getRequest"; "rr/add/getReply". `name` is fully qualified; throws
/// InvalidName when it is not.
[[nodiscard]] std::string mangle_topic_name(std::string_view name, DdsTopicKind kind);

struct DemangledTopic {
  DdsTopicKind kind = DdsTopicKind::kTopic;
  std::string name;  ///< fully qualified
  bool operator==(const DemangledTopic&) const = default;
};

/// Inverse of `mangle_topic_name`; nothing when the DDS topic is not a ROS 2 topic.
[[nodiscard]] std::optional<DemangledTopic> demangle_topic_name(std::string_view dds_name);

/// "sensor_msgs/msg/Image" -> "sensor_msgs::msg::dds_::Image_". Parts of a service are separate
/// types: "pkg/srv/Add_Request" -> "pkg::srv::dds_::Add_Request_". Throws InvalidName unless the
/// name has the form package/kind/Type.
[[nodiscard]] std::string mangle_type_name(std::string_view name);

/// Inverse of `mangle_type_name`; nothing when the DDS type is not a ROS 2 type.
[[nodiscard]] std::optional<std::string> demangle_type_name(std::string_view dds_name);

/// "pkg::srv::dds_::Add_Request_" (or `_Response_`) -> "pkg/srv/Add"; nothing for other types.
[[nodiscard]] std::optional<std::string> demangle_service_type_name(std::string_view dds_name);

/// The known name nearest to a misspelt one: that with the smallest edit distance, if it is at most
/// a third of the longer name's length (at least one edit). Nothing otherwise.
[[nodiscard]] std::optional<std::string> nearest_name(std::string_view misspelt,
                                                      const std::vector<std::string>& known);

}  // namespace pipescout
