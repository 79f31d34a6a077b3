// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <regex>
#include <set>
#include <string>

namespace pipescout {

/// Which topics are recorded, by the rules of rosbag2.
struct TopicSelection {
  bool all = false;
  std::set<std::string> topics;  ///< fully qualified
  /// Recorded beside `topics`, and in place of `all`, if found anywhere in the name.
  std::optional<std::regex> regex;
  std::optional<std::regex> exclude;  ///< whatever else asks for it
  bool hidden = false;                ///< those with a part that begins with '_' too

  [[nodiscard]] bool selects(const std::string& topic) const;
};

}  // namespace pipescout
