// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "cdr_stream.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::idl {

/// Describes the generated class `T`.
template <class T>
constexpr MessageType message_type_of(std::string_view name, std::string_view dds_name) {
  return {
      .name = name,
      .dds_name = dds_name,
      .create = []() -> std::shared_ptr<void> { return std::make_shared<T>(); },
      .serialized_size =
          [](const void* message) {
            return kEncapsulationSize + T::getCdrSerializedSize(*static_cast<const T*>(message));
          },
      .serialize =
          [](const void* message, std::span<std::byte> buffer) {
            return serialize(message, buffer, [](const void* fields, eprosima::fastcdr::Cdr& out) {
              static_cast<const T*>(fields)->serialize(out);
            });
          },
      .deserialize =
          [](std::span<const std::byte> buffer, void* message) {
            return deserialize(buffer, message, [](void* fields, eprosima::fastcdr::Cdr& in) {
              static_cast<T*>(fields)->deserialize(in);
            });
          },
  };
}

}  // namespace pipescout::idl
