// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/yaml_entries.hpp"

#include <array>
#include <charconv>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace pipescout {
namespace {

/// Nothing where the node does not spell one. yaml-cpp would read it by the global locale.
template <class T>
std::optional<T> as(const YAML::Node& node) {
  if (!node.IsScalar()) {
    return std::nullopt;
  }
  std::string_view text = node.Scalar();
  if (text.starts_with('+')) {
    text.remove_prefix(1);
  }
  if constexpr (std::is_floating_point_v<T>) {
    const T sign = text.starts_with('-') ? -1 : 1;
    const std::string_view word = text.substr(sign < 0 ? 1 : 0);
    for (const auto name : {".inf", ".Inf", ".INF"}) {
      if (word == name) {
        return sign * std::numeric_limits<T>::infinity();
      }
    }
    for (const auto name : {".nan", ".NaN", ".NAN"}) {
      if (text == name) {
        return std::numeric_limits<T>::quiet_NaN();
      }
    }
    // from_chars takes "inf" and "nan(x)" too.
    if (text.find_first_not_of("+-.0123456789eE") != std::string_view::npos) {
      return std::nullopt;
    }
  }
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return value;
}

std::string spelled(const YAML::Node& node) {
  return node.IsScalar() ? "'" + node.Scalar() + "'" : std::string("a list or map");
}

}  // namespace

YAML::Node YamlEntries::root(const std::string& text) const {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(name_ + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
  }
}

void YamlEntries::refuse(const YAML::Node& node, const std::string& what) const {
  throw std::runtime_error(name_ + ":" + std::to_string(node.Mark().line + 1) + ": " + what);
}

void YamlEntries::entries(const YAML::Node& map, const std::string& what,
                          const std::vector<Entry>& known) const {
  if (!map.IsMap()) {
    refuse(map, what + " is not a map");
  }
  std::set<std::string> seen;
  for (const auto& pair : map) {
    const std::string key = text(pair.first);
    if (!seen.insert(key).second) {
      refuse(pair.first, "'" + key + "' is given twice");
    }
    const Entry* found = nullptr;
    std::string names;
    for (const Entry& entry : known) {
      found = entry.first == key ? &entry : found;
      names += (names.empty() ? "" : ", ") + std::string(entry.first);
    }
    if (found == nullptr) {
      refuse(pair.first, "unknown name '" + key + "'; there is " + names);
    }
    found->second(pair.second);
  }
}

double YamlEntries::number(const YAML::Node& node) const {
  const auto value = as<double>(node);
  if (!value) {
    refuse(node, spelled(node) + " is not a number");
  }
  return *value;
}

int YamlEntries::whole(const YAML::Node& node) const {
  const auto value = as<int>(node);
  if (!value) {
    refuse(node, spelled(node) + " is not an integer");
  }
  return *value;
}

std::string YamlEntries::text(const YAML::Node& node) const {
  if (!node.IsScalar()) {
    refuse(node, "a list or map is not a text");
  }
  return node.Scalar();
}

Eigen::Vector3d YamlEntries::three(const YAML::Node& node) const {
  if (!node.IsSequence() || node.size() != 3) {
    refuse(node, "needs three numbers");
  }
  return {number(node[0]), number(node[1]), number(node[2])};
}

std::size_t YamlEntries::chosen(const YAML::Node& node,
                                const std::vector<std::string>& names) const {
  const std::string value = text(node);
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == value) {
      return i;
    }
    list += (i == 0 ? "" : ", ") + names[i];
  }
  refuse(node, "'" + value + "' is not one of " + list);
}

YamlEntries::Entry YamlEntries::number_into(const char* key, double& target) const {
  return {key, [this, &target](const YAML::Node& node) { target = number(node); }};
}

YamlEntries::Entry YamlEntries::number_into(const char* key, std::optional<double>& target) const {
  return {key, [this, &target](const YAML::Node& node) { target = number(node); }};
}

YamlEntries::Entry YamlEntries::whole_into(const char* key, int& target) const {
  return {key, [this, &target](const YAML::Node& node) { target = whole(node); }};
}

YamlEntries::Entry YamlEntries::text_into(const char* key, std::string& target) const {
  return {key, [this, &target](const YAML::Node& node) { target = text(node); }};
}

void YamlEntries::checked(const YAML::Node& node, const std::function<void()>& check) const {
  try {
    check();
  } catch (const std::invalid_argument& error) {
    refuse(node, error.what());
  }
}

std::string yaml_number(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) {
    throw std::runtime_error(file.string() + ": cannot be read");
  }
  return text.str();
}

}  // namespace pipescout
