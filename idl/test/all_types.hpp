// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::testing {

/// The types of the library and those of test_msgs.
[[nodiscard]] const std::vector<const MessageType*>& all_types();

}  // namespace pipescout::testing
