// SPDX-License-Identifier: Apache-2.0
#include "schema_comparison.hpp"

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::bag_command {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;  ///< type and name

/// "pkg/msg/Type" and "pkg/Type" are the same.
std::string short_name(std::string name) {
  if (const std::size_t middle = name.find("/msg/"); middle != std::string::npos) {
    name.erase(middle, 4);
  }
  return name;
}

std::string canonical_type(const std::string& written, const std::string& package) {
  const std::size_t end = written.find_first_of("[<");
  std::string name = short_name(written.substr(0, end));
  const std::string rest = end == std::string::npos ? "" : written.substr(end);
  if (name == "Header") {
    name = "std_msgs/Header";
  } else if (name == "byte" || name == "char") {
    name = "uint8";
  } else if (name.find('/') == std::string::npos && !name.empty() && name[0] >= 'A' &&
             name[0] <= 'Z') {
    name = package + "/" + name;
  }
  return name + rest;
}

/// Fields by type; constants, defaults and comments do not matter on the wire.
std::map<std::string, Fields> parse(const std::string& type, const std::string& text) {
  std::map<std::string, Fields> result;
  std::string current = short_name(type);
  result[current];
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("MSG: ")) {
      std::istringstream(line.substr(5)) >> current;
      current = short_name(current);
      result[current];
      continue;
    }
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    std::string field_type;
    std::string name;
    if (!(words >> field_type >> name) || field_type.starts_with("====")) {
      continue;
    }
    std::string next;
    words >> next;
    if (name.find('=') == std::string::npos && !next.starts_with('=')) {
      result[current].emplace_back(canonical_type(field_type, current.substr(0, current.find('/'))),
                                   name);
    }
  }
  return result;
}

}  // namespace

std::optional<std::string> schema_contradiction(const bags::BagTopic& topic) {
  const MessageType* type = find_message_type(topic.type);
  if (type == nullptr || topic.schema_encoding != "ros2msg" || topic.schema_text.empty()) {
    return std::nullopt;
  }
  const auto theirs = parse(topic.type, topic.schema_text);
  for (const auto& [name, fields] : parse(topic.type, ros2msg_schema(*type))) {
    const auto found = theirs.find(name);
    if (found == theirs.end()) {
      return topic.name + ": the bag's definition of " + topic.type + " lacks " + name;
    }
    const auto& other = found->second;
    for (std::size_t k = 0; k < std::max(fields.size(), other.size()); ++k) {
      const auto text = [k](const Fields& from) {
        return k < from.size() ? "'" + from[k].first + " " + from[k].second + "'"
                               : std::string("nothing");
      };
      if (text(fields) != text(other)) {
        return topic.name + ": " + name + " has " + text(other) + " in the bag where it has " +
               text(fields) + " here";
      }
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::bag_command
