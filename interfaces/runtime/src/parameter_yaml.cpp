// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameter_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <utility>

#include "pipescout/runtime/names.hpp"
#include "yaml_parameter_value.hpp"

namespace pipescout {
namespace {

constexpr std::string_view kParametersKey = "ros__parameters";

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    if (end == std::string_view::npos) {
      parts.push_back(text.substr(begin));
      return parts;
    }
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
}

std::vector<std::string_view> name_parts(std::string_view name) {
  if (name.starts_with('/')) {
    name.remove_prefix(1);
  }
  return split(name, '/');
}

bool has_wildcard(std::string_view pattern) {
  return pattern.find('*') != std::string_view::npos;
}

void check_pattern(const std::string& pattern, const YAML::Mark& mark, const std::string& path) {
  for (const std::string_view part : name_parts(pattern)) {
    if (part == "*" || part == "**") {
      continue;
    }
    if (part.find('*') != std::string_view::npos) {
      throw YamlError(path, mark,
                      "'" + pattern + "': '*' and '**' replace whole parts of a node name");
    }
    try {
      validate_node_name(part);
    } catch (const InvalidName& error) {
      throw YamlError(path, mark, "'" + pattern + "' is not a node name: " + error.what());
    }
  }
}

void flatten(const YAML::Node& map, const std::string& prefix, const std::string& path,
             std::map<std::string, std::string>& seen, std::vector<ParameterOverride>& result) {
  for (const auto& entry : map) {
    const std::string& key = entry.first.Scalar();
    const YAML::Mark mark = entry.first.Mark();
    for (const std::string_view part : split(key, '.')) {
      if (part.empty()) {
        throw YamlError(path, mark, "'" + key + "': a part of a parameter name is empty");
      }
    }
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    if (entry.second.IsMap()) {
      flatten(entry.second, name, path, seen, result);
      continue;
    }
    if (entry.second.IsNull()) {
      throw YamlError(path, mark, "parameter '" + name + "' has no value");
    }
    // "a: {b: 1}" beside "a.b: 2".
    const auto [first, is_new] = seen.emplace(name, line_location(path, mark));
    if (!is_new) {
      throw YamlError(path, mark,
                      "parameter '" + name + "' is given twice, first at " + first->second);
    }
    result.push_back({name, read_parameter_value(entry.second, path), line_location(path, mark)});
  }
}

void read_node_keys(const YAML::Node& map, const std::string& prefix, const YAML::Mark& prefix_mark,
                    const std::string& path, std::vector<NodeParameters>& result) {
  if (map.size() == 0) {
    throw YamlError(path, prefix_mark,
                    "'" + prefix + "' has no '" + std::string(kParametersKey) + "'");
  }
  for (const auto& entry : map) {
    const std::string& key = entry.first.Scalar();
    const YAML::Mark mark = entry.first.Mark();
    if (key == kParametersKey) {
      if (prefix.empty()) {
        throw YamlError(path, mark, "'" + key + "' must be below the name of a node");
      }
      if (!entry.second.IsMap()) {
        throw YamlError(path, mark, "'" + key + "' must be a map of parameters");
      }
      NodeParameters node{prefix, line_location(path, prefix_mark),
                          read_parameter_map(entry.second, path)};
      for (ParameterOverride& parameter : node.parameters) {
        parameter.from_wildcard = has_wildcard(prefix);
      }
      result.push_back(std::move(node));
      continue;
    }
    std::string name = prefix;
    if (!key.starts_with('/')) {
      name += '/';
    } else if (!prefix.empty()) {
      throw YamlError(
          path, mark,
          "'" + key + "' under '" + prefix + "': a nested name must not begin with '/'");
    }
    name += key;
    check_pattern(name, mark, path);
    if (!entry.second.IsMap()) {
      throw YamlError(path, mark,
                      "'" + key + "' is neither a node nor a namespace: it needs a '" +
                          std::string(kParametersKey) + "' with the parameters below it");
    }
    read_node_keys(entry.second, name, mark, path, result);
  }
}

ParameterFile read_parameter_file(const YAML::Node& root, const std::string& path) {
  // All lines may be comments.
  if (root.IsNull()) {
    return {};
  }
  if (!root.IsMap()) {
    throw YamlError(path, root.Mark(), "the top level must be a map of node names");
  }
  std::vector<NodeParameters> nodes;
  if (root.size() > 0) {
    read_node_keys(root, "", root.Mark(), path, nodes);
  }
  return ParameterFile(std::move(nodes));
}

bool matches(const std::vector<std::string_view>& pattern,
             const std::vector<std::string_view>& name) {
  // reachable[j]: the parts of the pattern so far match the first j parts of the name.
  std::vector<bool> reachable(name.size() + 1, false);
  reachable[0] = true;
  for (const std::string_view part : pattern) {
    std::vector<bool> next(name.size() + 1, false);
    bool any_before = false;
    for (std::size_t j = 0; j <= name.size(); ++j) {
      if (part == "**") {
        any_before = any_before || reachable[j];
        next[j] = any_before;
      } else if (j > 0) {
        next[j] = reachable[j - 1] && (part == "*" || part == name[j - 1]);
      }
    }
    reachable = std::move(next);
  }
  return reachable[name.size()];
}

// A parameter tree for the layout of a dump.
struct DumpNode {
  std::string value;  ///< empty for an inner node
  std::map<std::string, DumpNode> children;
};

void write(const DumpNode& node, const std::string& indent, std::string& out) {
  for (const auto& [key, child] : node.children) {
    out += indent + to_yaml(key) + ":";
    if (!child.children.empty()) {
      out += "\n";
      write(child, indent + "  ", out);
    } else {
      out += child.value + "\n";
    }
  }
}

struct BlockText {
  const std::string& indent;

  template <class T>
  std::string operator()(const T& scalar) const {
    return " " + to_yaml(scalar);
  }
  std::string operator()(std::monostate) const { return " null"; }
  std::string operator()(const std::vector<std::uint8_t>& bytes) const {
    return " " + to_yaml(bytes);
  }
  template <class T>
  std::string operator()(const std::vector<T>& elements) const {
    if (elements.empty()) {
      return " []";
    }
    std::string result;
    for (const T& element : elements) {
      result += "\n" + indent + "- " + to_yaml(element);
    }
    return result;
  }
};

std::string indent_of(std::size_t depth) {
  return std::string(2 * depth, ' ');
}

}  // namespace

bool matches_node_pattern(std::string_view pattern, std::string_view fully_qualified_node_name) {
  return matches(name_parts(pattern), name_parts(fully_qualified_node_name));
}

std::vector<ParameterOverride> ParameterFile::overrides_for(
    std::string_view fully_qualified_node_name) const {
  std::vector<ParameterOverride> result;
  std::map<std::string, std::size_t> index;
  for (const NodeParameters& node : nodes_) {
    if (!matches_node_pattern(node.pattern, fully_qualified_node_name)) {
      continue;
    }
    for (const ParameterOverride& parameter : node.parameters) {
      const auto [position, is_new] = index.emplace(parameter.name, result.size());
      if (is_new) {
        result.push_back(parameter);
      } else {
        result[position->second] = parameter;
      }
    }
  }
  return result;
}

ParameterFile load_parameter_yaml(const std::string& path) {
  return read_parameter_file(load_yaml(path), path);
}

ParameterFile parse_parameter_yaml(const std::string& text, const std::string& path) {
  return read_parameter_file(parse_yaml(text, path), path);
}

std::vector<ParameterOverride> read_parameter_map(const YAML::Node& map, const std::string& path) {
  if (!map.IsMap()) {
    throw YamlError(path, map.Mark(), "a map of parameters is expected");
  }
  std::vector<ParameterOverride> result;
  std::map<std::string, std::string> seen;
  flatten(map, "", path, seen, result);
  return result;
}

std::string dump_parameter_yaml(std::string_view fully_qualified_node_name,
                                const std::vector<NamedParameter>& parameters) {
  std::map<std::string, const ParameterValue*> sorted;
  for (const NamedParameter& parameter : parameters) {
    if (parameter.value.is_set()) {
      sorted[parameter.name] = &parameter.value;
    }
  }
  DumpNode root;
  for (const auto& [name, value] : sorted) {
    DumpNode* node = &root;
    std::size_t depth = 2;
    std::size_t begin = 0;
    // Descend at each '.', unless the name so far is a parameter itself: that one is not a map.
    for (std::size_t dot = name.find('.'); dot != std::string::npos;
         dot = name.find('.', dot + 1)) {
      if (!sorted.contains(name.substr(0, dot))) {
        node = &node->children[name.substr(begin, dot - begin)];
        begin = dot + 1;
        ++depth;
      }
    }
    const std::string indent = indent_of(depth);
    node->children[name.substr(begin)].value = value->visit(BlockText{indent});
  }
  std::string out(fully_qualified_node_name);
  out += ":\n  ros__parameters:";
  if (root.children.empty()) {
    return out + " {}\n";
  }
  out += "\n";
  write(root, indent_of(2), out);
  return out;
}

}  // namespace pipescout
