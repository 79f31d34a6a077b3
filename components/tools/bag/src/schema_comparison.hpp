// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bag_command {

/// How the definition that a bag keeps of a topic's type contradicts that of this installation, in
/// one sentence; none when they agree, or one of them is not known. Only "ros2msg" is compared.
[[nodiscard]] std::optional<std::string> schema_contradiction(const bags::BagTopic& topic);

}  // namespace pipescout::bag_command
