// SPDX-License-Identifier: Apache-2.0
#include "topic_selection.hpp"

#include <algorithm>
#include <string_view>

namespace pipescout {
namespace {

/// Whether the name `inner` is that of the namespace `outer`, or of something in it.
bool is_within(std::string_view inner, std::string_view outer) {
  return outer == "/" || inner == outer ||
         (inner.starts_with(outer) && inner.substr(outer.size()).starts_with('/'));
}

/// Of a topic.
std::string_view namespace_of(std::string_view topic) {
  return topic.substr(0, std::max<std::size_t>(topic.rfind('/'), 1));
}

}  // namespace

bool TopicSelection::selects(const std::string& topic) const {
  if (exclude && std::regex_search(topic, *exclude)) {
    return false;
  }
  if (topics.contains(topic)) {
    return true;
  }
  if (!hidden && topic.find("/_") != std::string::npos) {
    return false;
  }
  if (regex) {
    return std::regex_search(topic, *regex);
  }
  return all && (is_within(topic, ns) || is_within(ns, namespace_of(topic)));
}

}  // namespace pipescout
