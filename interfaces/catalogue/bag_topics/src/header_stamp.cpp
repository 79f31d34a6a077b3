// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/header_stamp.hpp"

namespace pipescout {
namespace {

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at, bool little_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t k = little_endian ? 3 - i : i;
    value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + k]);
  }
  return value;
}

}  // namespace

bool begins_with_header(const MessageType* type) {
  return type != nullptr && !type->fields.empty() && type->fields[0].name == "header" &&
         type->fields[0].kind == FieldKind::kMessage &&
         type->fields[0].message().name == "std_msgs/msg/Header";
}

std::optional<std::int64_t> header_stamp(std::span<const std::byte> cdr) {
  // Encapsulation (4 bytes, the lowest bit of the second says little-endian), sec, nanosec.
  constexpr std::size_t kNeeded = 12;
  if (cdr.size() < kNeeded) {
    return std::nullopt;
  }
  const bool little_endian = (std::to_integer<unsigned>(cdr[1]) & 1U) != 0;
  const auto sec = static_cast<std::int32_t>(word(cdr, 4, little_endian));
  const std::uint32_t nanosec = word(cdr, 8, little_endian);
  return static_cast<std::int64_t>(sec) * 1'000'000'000 + static_cast<std::int64_t>(nanosec);
}

}  // namespace pipescout
