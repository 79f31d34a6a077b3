// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/bag_topic.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "pipescout/bag_topics/qos_profiles.hpp"

namespace pipescout {
namespace {

void collect(const MessageType& type, std::vector<const MessageType*>& found) {
  if (std::find(found.begin(), found.end(), &type) != found.end()) {
    return;
  }
  found.push_back(&type);
  for (const MessageField& field : type.fields) {
    if (field.kind == FieldKind::kMessage) {
      collect(field.message(), found);
    }
  }
}

/// "std_msgs/Header" for "std_msgs/msg/Header".
std::string short_name(std::string_view name) {
  const auto first = name.find('/');
  const auto last = name.rfind('/');
  return std::string(name.substr(0, first)) + std::string(name.substr(last));
}

}  // namespace

std::string ros2msg_schema(const MessageType& type) {
  std::vector<const MessageType*> types;
  collect(type, types);
  std::string schema(type.definition);
  for (std::size_t i = 1; i < types.size(); ++i) {
    schema += std::string(80, '=') + "\nMSG: " + short_name(types[i]->name) + "\n" +
              std::string(types[i]->definition);
  }
  return schema;
}

bags::BagTopic make_bag_topic(const std::string& name, const std::string& type,
                              std::span<const QoS> offered) {
  bags::BagTopic topic{
      .name = name, .type = type, .offered_qos_profiles = qos_profiles_to_yaml(offered)};
  if (const auto* known = find_message_type(type); known != nullptr && !known->fields.empty()) {
    topic.schema_encoding = "ros2msg";
    topic.schema_text = ros2msg_schema(*known);
  }
  return topic;
}

}  // namespace pipescout
