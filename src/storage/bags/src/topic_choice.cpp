// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/topic_choice.hpp"

#include <algorithm>
#include <vector>

#include "bag_source.hpp"
#include "pipescout/bags/bag_metadata.hpp"

namespace pipescout::bags {

bool is_bag(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) {
    return true;
  }
  return std::filesystem::exists(path / kMetadataFile) || !files_in(path).empty();
}

const TopicCount& choose_topic(const BagReader& reader, const std::filesystem::path& bag,
                               std::initializer_list<const char*> types, const std::string& wanted,
                               const std::string& option) {
  std::vector<const TopicCount*> candidates;
  for (const TopicCount& each : reader.metadata().topics) {
    if (each.topic.serialization_format == "cdr" &&
        std::ranges::find(types, each.topic.type) != types.end()) {
      candidates.push_back(&each);
    }
  }
  std::string names;
  for (const TopicCount* each : candidates) {
    if (each->topic.name == wanted || each->topic.name == "/" + wanted) {
      return *each;
    }
    names += (names.empty() ? "" : ", ") + each->topic.name;
  }
  if (wanted.empty() && candidates.size() == 1) {
    return *candidates.front();
  }
  std::string asked;
  for (const char* type : types) {
    asked += (asked.empty() ? "" : " or ") + std::string(type);
  }
  if (candidates.empty()) {
    std::string others;
    for (const TopicCount& each : reader.metadata().topics) {
      if (each.topic.serialization_format != "cdr") {
        others += (others.empty() ? "" : ", ") + each.topic.name + " (" +
                  each.topic.serialization_format + ")";
      }
    }
    throw BagError(
        BagFault::kUsage, bag,
        "has no topic of " + asked +
            (others.empty() ? "" : "; topics in an encoding that is not read: " + others));
  }
  throw BagError(BagFault::kUsage, bag,
                 (wanted.empty() ? "has several topics of " + asked
                                 : "has no topic '" + wanted + "' of " + asked) +
                     "; choose one with " + option + ": " + names);
}

}  // namespace pipescout::bags
