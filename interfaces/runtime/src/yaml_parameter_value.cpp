// SPDX-License-Identifier: Apache-2.0
#include "yaml_parameter_value.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <stdexcept>

#include "pipescout/runtime/names.hpp"

namespace pipescout {
namespace {

constexpr std::string_view kStandardTags = "tag:yaml.org,2002:";

bool is_base64(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' ||
           c == '/' || c == '=' || c == '\n' || c == ' ';
  });
}

ParameterValue read_binary(const YAML::Node& node, const std::string& path) {
  const std::string& text = node.Scalar();
  std::vector<std::uint8_t> bytes;
  if (is_base64(text)) {
    bytes = YAML::DecodeBase64(text);
  }
  // The decoder gives nothing for what it cannot decode.
  if (bytes.empty() && !text.empty()) {
    throw YamlError(path, node.Mark(), "malformed base64 in a !!binary value");
  }
  return bytes;
}

ParameterValue type_scalar(const YAML::Node& node, const std::string& path) {
  try {
    return type_yaml_scalar(node.Scalar());
  } catch (const std::out_of_range& error) {
    throw YamlError(path, node.Mark(), error.what());
  }
}

ParameterValue read_tagged(const YAML::Node& node, std::string_view tag, const std::string& path) {
  if (tag == "binary") {
    return read_binary(node, path);
  }
  const ParameterValue value = type_scalar(node, path);
  if (tag == "float" && value.type() == ParameterType::kInteger) {
    return static_cast<double>(value.get<std::int64_t>());
  }
  const bool fits = (tag == "bool" && value.type() == ParameterType::kBool) ||
                    (tag == "int" && value.type() == ParameterType::kInteger) ||
                    (tag == "float" && value.type() == ParameterType::kDouble);
  if (!fits) {
    throw YamlError(path, node.Mark(),
                    "'" + node.Scalar() + "' does not fit its tag !!" + std::string(tag));
  }
  return value;
}

ParameterValue read_scalar(const YAML::Node& node, const std::string& path) {
  const std::string& tag = node.Tag();
  if (tag == "!" || tag == std::string(kStandardTags) + "str") {
    return node.Scalar();
  }
  if (tag.starts_with(kStandardTags)) {
    return read_tagged(node, std::string_view(tag).substr(kStandardTags.size()), path);
  }
  if (tag != "?" && !tag.empty()) {
    throw YamlError(path, node.Mark(), "unknown tag " + tag);
  }
  return type_scalar(node, path);
}

template <class T>
ParameterValue collect(const std::vector<ParameterValue>& elements) {
  std::vector<T> values;
  values.reserve(elements.size());
  for (const ParameterValue& element : elements) {
    values.push_back(element.get<T>());
  }
  return values;
}

ParameterValue read_sequence(const YAML::Node& node, const std::string& path) {
  std::vector<ParameterValue> elements;
  elements.reserve(node.size());
  for (const auto& child : node) {
    if (!child.IsScalar()) {
      throw YamlError(path, child.Mark(),
                      child.IsNull() ? "an array element has no value"
                                     : "an array contains plain values only, no arrays or maps");
    }
    ParameterValue element = read_scalar(child, path);
    if (!elements.empty() && element.type() != elements.front().type()) {
      const bool numbers = (element.type() == ParameterType::kDouble &&
                            elements.front().type() == ParameterType::kInteger) ||
                           (element.type() == ParameterType::kInteger &&
                            elements.front().type() == ParameterType::kDouble);
      throw YamlError(path, child.Mark(),
                      "mixed types in an array: element " + std::to_string(elements.size() + 1) +
                          " (" + child.Scalar() + ") is of type " + to_string(element.type()) +
                          ", the first is of type " + to_string(elements.front().type()) +
                          (numbers ? "; write every number of a double array with a '.'" : ""));
    }
    elements.push_back(std::move(element));
  }
  if (elements.empty()) {
    return std::vector<bool>{};
  }
  switch (elements.front().type()) {
    case ParameterType::kBool:
      return collect<bool>(elements);
    case ParameterType::kInteger:
      return collect<std::int64_t>(elements);
    case ParameterType::kDouble:
      return collect<double>(elements);
    case ParameterType::kString:
      return collect<std::string>(elements);
    default:
      throw YamlError(path, node.Mark(), "an array contains plain values only, no arrays or maps");
  }
}

}  // namespace

ParameterValue read_parameter_value(const YAML::Node& node, const std::string& path) {
  if (node.IsScalar()) {
    return read_scalar(node, path);
  }
  if (node.IsSequence()) {
    return read_sequence(node, path);
  }
  throw YamlError(path, node.Mark(),
                  node.IsMap() ? "a map is not a parameter value" : "no value (null)");
}

ParameterValue parse_parameter_value(const std::string& text) {
  static const std::string kName = "value";
  YAML::Node node;
  try {
    node = parse_yaml(text, kName);
  } catch (const YamlError&) {
    return text;
  }
  if (node.IsNull() || node.IsMap()) {
    return text;
  }
  try {
    return read_parameter_value(node, kName);
  } catch (const YamlError& error) {
    throw std::invalid_argument("'" + text + "': " + error.what());
  }
}

ParameterRule ParameterRule::parse(const std::string& text, const std::string& source) {
  const std::size_t separator = text.find(":=");
  if (separator == std::string::npos) {
    throw std::invalid_argument("'" + text + "' must have the form name:=value");
  }
  ParameterRule rule;
  std::string name = text.substr(0, separator);
  if (const std::size_t colon = name.find(':'); colon != std::string::npos) {
    rule.node = name.substr(0, colon);
    validate_node_name(rule.node);
    name.erase(0, colon + 1);
  }
  if (name.empty()) {
    throw std::invalid_argument("'" + text + "' has no parameter name before ':='");
  }
  rule.parameter = {std::move(name), parse_parameter_value(text.substr(separator + 2)), source,
                    rule.node.empty()};
  return rule;
}

}  // namespace pipescout
