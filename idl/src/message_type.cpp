// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/message_type.hpp"

#include <algorithm>

namespace pipescout {

const MessageType* find_message_type(std::string_view name) noexcept {
  const auto types = message_types();
  const auto found = std::ranges::lower_bound(types, name, {}, &MessageType::name);
  return found != types.end() && (*found)->name == name ? *found : nullptr;
}

}  // namespace pipescout
