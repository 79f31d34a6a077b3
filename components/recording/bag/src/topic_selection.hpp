// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <regex>
#include <set>
#include <string>

namespace pipescout {

/// Which topics are recorded, by the rules of rosbag2.
struct TopicSelection {
  /// Those in `ns` or in a namespace around it: in "/a/b" all of "/a/b/...", and "/a/x" and "/x",
  /// but neither "/a/c/x" nor "/c/x", which may be another robot's. Of "/" that is every topic.
  bool all = false;
  std::string ns = "/";
  std::set<std::string> topics;  ///< fully qualified
  /// Recorded beside `topics`, and in place of `all`, if found anywhere in the name.
  std::optional<std::regex> regex;
  std::optional<std::regex> exclude;  ///< whatever else asks for it
  bool hidden = false;                ///< those with a part that begins with '_' too

  [[nodiscard]] bool selects(const std::string& topic) const;
};

}  // namespace pipescout
