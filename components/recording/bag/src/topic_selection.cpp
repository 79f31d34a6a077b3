// SPDX-License-Identifier: Apache-2.0
#include "topic_selection.hpp"

namespace pipescout {

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
  return regex ? std::regex_search(topic, *regex) : all;
}

}  // namespace pipescout
