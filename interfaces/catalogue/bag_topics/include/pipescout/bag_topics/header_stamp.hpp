// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "pipescout/idl/message_type.hpp"

/// The stamp of a message that is not decoded.
namespace pipescout {

/// Whether the first field of the type is a std_msgs/Header; false for null, an unknown type.
[[nodiscard]] bool begins_with_header(const MessageType* type);

/// header.stamp in ns of a message in CDR whose first field is a std_msgs/Header; none when it is
/// cut short.
[[nodiscard]] std::optional<std::int64_t> header_stamp(std::span<const std::byte> cdr);

}  // namespace pipescout
