// SPDX-License-Identifier: Apache-2.0
#include "type_slots.hpp"

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "loaded_type.hpp"
#include "pipescout/idl/support/type_support.hpp"

namespace pipescout::idl {
namespace {

// Written before anybody has the functions of a slot, never changed afterwards.
std::array<const LoadedType*, kTypeSlots> slot_types{};
std::size_t used_slots = 0;
std::array<const MessageType*, kTypeSlots> nested_types{};

template <std::size_t I>
constexpr SlotFunctions functions_of_slot() {
  return {
      .create = [] { return slot_types[I]->create(); },
      .serialized_size =
          [](const void* message) {
            CdrSize size;
            slot_types[I]->measure(size, message);
            return kEncapsulationSize + size.bytes();
          },
      .serialize =
          [](const void* message, std::span<std::byte> buffer) {
            return serialize(message, buffer, [](CdrWriter& cdr, const void* object) {
              slot_types[I]->write(cdr, object);
            });
          },
      .deserialize =
          [](std::span<const std::byte> buffer, void* message) {
            return deserialize(buffer, message, [](CdrReader& cdr, void* object) {
              slot_types[I]->read(cdr, object);
            });
          },
  };
}

template <std::size_t... I>
constexpr std::array<SlotFunctions, sizeof...(I)> all_functions(std::index_sequence<I...>) {
  return {functions_of_slot<I>()...};
}

template <std::size_t I>
const MessageType& nested_type() {
  return *nested_types[I];
}

template <std::size_t... I>
constexpr std::array<MessageFunction, sizeof...(I)> all_nested(std::index_sequence<I...>) {
  return {nested_type<I>...};
}

constexpr auto kSlotFunctions = all_functions(std::make_index_sequence<kTypeSlots>{});
constexpr auto kNestedFunctions = all_nested(std::make_index_sequence<kTypeSlots>{});

[[noreturn]] void refuse_more(std::string_view name) {
  throw MessageTypeError(std::string(name) + " is not loaded: this process has loaded " +
                         std::to_string(kTypeSlots) + " types, as many as it can");
}

}  // namespace

const SlotFunctions& claim_type_slot(const LoadedType& type, std::string_view name) {
  if (used_slots == kTypeSlots) {
    refuse_more(name);
  }
  slot_types[used_slots] = &type;
  return kSlotFunctions[used_slots++];
}

MessageFunction message_function(const ObjectType& type) {
  static auto& functions = *new std::map<const MessageType*, MessageFunction>;
  if (const auto known = functions.find(&type.type()); known != functions.end()) {
    return known->second;
  }
  const std::size_t next = functions.size();
  if (next == kTypeSlots) {
    refuse_more(type.type().name);
  }
  nested_types[next] = &type.type();
  return functions.emplace(&type.type(), kNestedFunctions[next]).first->second;
}

}  // namespace pipescout::idl
