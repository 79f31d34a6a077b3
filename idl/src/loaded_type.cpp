// SPDX-License-Identifier: Apache-2.0
#include "loaded_type.hpp"

#include <algorithm>
#include <new>

#include "msg_emitter.hpp"
#include "names.hpp"
#include "type_slots.hpp"

namespace pipescout::idl {
namespace {

/// Both are in the order of rosidl's types.
FieldKind field_kind(generator::Kind kind) {
  static_assert(static_cast<int>(FieldKind::kMessage) ==
                static_cast<int>(generator::Kind::kMessage));
  return static_cast<FieldKind>(kind);
}

FieldShape field_shape(generator::Shape shape) {
  static_assert(static_cast<int>(FieldShape::kSequence) ==
                static_cast<int>(generator::Shape::kSequence));
  return static_cast<FieldShape>(shape);
}

std::size_t aligned(std::size_t at, std::size_t alignment) {
  return (at + alignment - 1) / alignment * alignment;
}

std::byte* bytes_at(void* memory, std::size_t offset) {
  return static_cast<std::byte*>(memory) + offset;
}

const std::byte* bytes_at(const void* memory, std::size_t offset) {
  return static_cast<const std::byte*>(memory) + offset;
}

}  // namespace

LoadedType::LoadedType(
    const generator::Structure& structure,
    const std::function<const ObjectType&(const generator::Field& field)>& nested)
    : name_(structure.name),
      dds_name_(generator::dds_name(structure.name)),
      definition_(generator::msg_text(structure)) {
  // The texts first: the tables refer to them.
  for (const auto& field : structure.fields) {
    field_texts_.push_back({field.name, field.default_value ? generator::msg_default(field) : ""});
  }
  for (const auto& constant : structure.constants) {
    constant_texts_.push_back({constant.name, generator::msg_value(constant.value)});
  }
  for (std::size_t i = 0; i < structure.constants.size(); ++i) {
    constants_.push_back({.name = constant_texts_[i].name,
                          .kind = field_kind(structure.constants[i].type.kind),
                          .value = constant_texts_[i].value});
  }
  for (std::size_t i = 0; i < structure.fields.size(); ++i) {
    const auto& field = structure.fields[i];
    const auto* const message =
        field.type.kind == generator::Kind::kMessage ? &nested(field) : nullptr;
    auto storage = make_field_storage(field, message);
    const std::size_t offset = aligned(size_, storage->alignment());
    fields_.push_back({.name = field_texts_[i].name,
                       .kind = field_kind(field.type.kind),
                       .shape = field_shape(field.type.shape),
                       .element_size = storage->element_size(),
                       .length = field.type.length,
                       .string_length = field.type.text_length,
                       .offset = offset,
                       .message = message != nullptr ? message_function(*message) : nullptr,
                       .sequence = storage->sequence(),
                       .default_value = field_texts_[i].value});
    size_ = offset + storage->size();
    alignment_ = std::max(alignment_, storage->alignment());
    parts_.push_back({std::move(storage), offset});
  }
  size_ = aligned(size_, alignment_);
  const auto& functions = claim_type_slot(*this, name_);
  type_ = {.name = name_,
           .dds_name = dds_name_,
           .create = functions.create,
           .serialized_size = functions.serialized_size,
           .serialize = functions.serialize,
           .deserialize = functions.deserialize,
           .fields = fields_,
           .constants = constants_,
           .definition = definition_};
}

void LoadedType::construct(void* memory) const {
  std::size_t made = 0;
  try {
    for (; made < parts_.size(); ++made) {
      parts_[made].storage->construct(bytes_at(memory, parts_[made].offset));
    }
  } catch (...) {
    while (made > 0) {
      --made;
      parts_[made].storage->destroy(bytes_at(memory, parts_[made].offset));
    }
    throw;
  }
}

void LoadedType::relocate(void* memory, void* from) const noexcept {
  for (const auto& part : parts_) {
    part.storage->relocate(bytes_at(memory, part.offset), bytes_at(from, part.offset));
  }
}

void LoadedType::destroy(void* message) const noexcept {
  for (const auto& part : parts_) {
    part.storage->destroy(bytes_at(message, part.offset));
  }
}

void LoadedType::write(CdrWriter& cdr, const void* message) const {
  for (const auto& part : parts_) {
    part.storage->write(cdr, bytes_at(message, part.offset));
  }
}

void LoadedType::read(CdrReader& cdr, void* message) const {
  for (const auto& part : parts_) {
    part.storage->read(cdr, bytes_at(message, part.offset));
  }
}

void LoadedType::measure(CdrSize& cdr, const void* message) const {
  for (const auto& part : parts_) {
    part.storage->measure(cdr, bytes_at(message, part.offset));
  }
}

std::shared_ptr<void> LoadedType::create() const {
  const auto alignment = static_cast<std::align_val_t>(alignment_);
  void* const memory = ::operator new(size_, alignment);
  try {
    construct(memory);
  } catch (...) {
    ::operator delete(memory, alignment);
    throw;
  }
  // Should the shared_ptr find no memory for its count, it calls the deleter.
  return {memory, [this, alignment](void* message) {
            destroy(message);
            ::operator delete(message, alignment);
          }};
}

}  // namespace pipescout::idl
