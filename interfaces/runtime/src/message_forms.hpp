// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "pipescout/runtime/serialized_message.hpp"

namespace pipescout {

/// One published message as the subscriptions of this process want it: as the object or as bytes.
/// Whichever the publisher did not give is made once, when the first subscription asks for it.
class MessageForms {
 public:
  MessageForms(std::shared_ptr<const void> message, const MessageType& type)
      : message_(std::move(message)), type_(&type) {}

  /// Null when the message has no such form: bytes that are no message of the type, or a message
  /// beyond the bounds of its type.
  std::shared_ptr<const void> as(const MessageType& wanted) {
    if (is_serialized(wanted) == is_serialized(*type_)) {
      return message_;
    }
    if (!other_) {
      other_ =
          is_serialized(wanted)
              ? serialize(*type_, message_.get())
              : deserialize(wanted, static_cast<const SerializedMessage*>(message_.get())->bytes());
    }
    return *other_;
  }

 private:
  std::shared_ptr<const void> message_;
  const MessageType* type_;
  std::optional<std::shared_ptr<const void>> other_;
};

}  // namespace pipescout
