// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace eprosima::fastcdr {
class Cdr;
}

namespace pipescout::idl {

/// Bytes ahead of every serialised message that tell its encoding.
inline constexpr std::size_t kEncapsulationSize = 4;

using WriteFields = void (*)(const void* message, eprosima::fastcdr::Cdr& stream);
using ReadFields = void (*)(void* message, eprosima::fastcdr::Cdr& stream);

/// As MessageType::serialize.
std::size_t serialize(const void* message, std::span<std::byte> buffer, WriteFields write);

/// As MessageType::deserialize.
bool deserialize(std::span<const std::byte> buffer, void* message, ReadFields read);

}  // namespace pipescout::idl
