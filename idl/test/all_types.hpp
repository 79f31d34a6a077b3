// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::testing {

/// One definition, compiled into this program and loaded by it at run time.
struct TwinTypes {
  const MessageType* generated;
  const MessageType* loaded;
};

/// Of test_msgs.
[[nodiscard]] const std::vector<TwinTypes>& twin_types();

/// The types of the library and those of test_msgs in both forms.
[[nodiscard]] const std::vector<const MessageType*>& all_types();

}  // namespace pipescout::testing
