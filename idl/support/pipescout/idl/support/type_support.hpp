// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>

#include "pipescout/idl/message_type.hpp"
#include "pipescout/idl/support/cdr.hpp"

/// Type descriptions of the generated code; for that code only.
namespace pipescout::idl {

/// Encapsulation header before every serialised message, which gives its encoding.
inline constexpr std::size_t kEncapsulationSize = 4;

using WriteFields = void (*)(CdrWriter& cdr, const void* message);
using ReadFields = void (*)(CdrReader& cdr, void* message);

/// As MessageType::serialize.
std::size_t serialize(const void* message, std::span<std::byte> buffer, WriteFields write);

/// As MessageType::deserialize.
bool deserialize(std::span<const std::byte> buffer, void* message, ReadFields read);

/// Describes the generated class `T`.
template <class T>
constexpr MessageType message_type_of(std::string_view name, std::string_view dds_name,
                                      std::span<const MessageField> fields,
                                      std::span<const MessageConstant> constants,
                                      std::string_view definition) {
  return {
      .name = name,
      .dds_name = dds_name,
      .create = []() -> std::shared_ptr<void> { return std::make_shared<T>(); },
      .serialized_size =
          [](const void* message) {
            CdrSize size;
            measure_fields(size, *static_cast<const T*>(message));
            return kEncapsulationSize + size.bytes();
          },
      .serialize =
          [](const void* message, std::span<std::byte> buffer) {
            return serialize(message, buffer, [](CdrWriter& cdr, const void* object) {
              write_fields(cdr, *static_cast<const T*>(object));
            });
          },
      .deserialize =
          [](std::span<const std::byte> buffer, void* message) {
            return deserialize(buffer, message, [](CdrReader& cdr, void* object) {
              read_fields(cdr, *static_cast<T*>(object));
            });
          },
      .fields = fields,
      .constants = constants,
      .definition = definition,
  };
}

template <class Sequence>
constexpr SequenceAccess sequence_access() {
  constexpr bool kOfBool = std::is_same_v<typename Sequence::value_type, bool>;
  SequenceAccess access{};
  access.size = [](const void* sequence) { return static_cast<const Sequence*>(sequence)->size(); };
  access.resize = [](void* sequence, std::size_t size) {
    static_cast<Sequence*>(sequence)->resize(size);
  };
  access.data = [](void* sequence) -> void* {
    if constexpr (kOfBool) {
      return nullptr;
    } else {
      return static_cast<Sequence*>(sequence)->data();
    }
  };
  access.get_bool = [](const void* sequence, std::size_t index) -> bool {
    if constexpr (kOfBool) {
      return (*static_cast<const Sequence*>(sequence))[index];
    } else {
      return false;
    }
  };
  access.set_bool = [](void* sequence, std::size_t index, bool value) {
    if constexpr (kOfBool) {
      (*static_cast<Sequence*>(sequence))[index] = value;
    }
  };
  return access;
}

template <class Sequence>
inline constexpr SequenceAccess kSequenceAccess = sequence_access<Sequence>();

/// The types of a package, sorted by name: exported by a generated library as the symbol
/// `pipescout_message_types_of_PACKAGE`.
struct PackageTypes {
  const MessageType* const* types;
  std::size_t count;
};

}  // namespace pipescout::idl
