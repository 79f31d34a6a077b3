// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <rapidcheck.h>
#include <memory>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::testing {

struct AnyMessage {
  const MessageType* type;
  std::shared_ptr<void> message;
};

/// What rapidcheck prints of a counterexample.
void showValue(const AnyMessage& value, std::ostream& stream);

/// Messages of that type with any content that it can have, filled through its field table.
[[nodiscard]] rc::Gen<AnyMessage> any_message(const MessageType& type);

}  // namespace pipescout::testing
