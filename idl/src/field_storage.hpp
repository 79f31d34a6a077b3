// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "model.hpp"
#include "pipescout/idl/message_field.hpp"
#include "pipescout/idl/support/object_type.hpp"

namespace pipescout::idl {

/// A field of a type that is loaded at run time: how it lies in memory and on the wire. Numbers,
/// strings and arrays lie as in a generated class; a sequence is an object of its own, which knows
/// its bound and is reached through `SequenceAccess` as those of generated classes are.
///
/// All addresses are those of the field itself.
class FieldStorage {
 public:
  FieldStorage() = default;
  virtual ~FieldStorage() = default;
  FieldStorage(const FieldStorage&) = delete;
  FieldStorage& operator=(const FieldStorage&) = delete;

  [[nodiscard]] virtual std::size_t size() const noexcept = 0;          ///< bytes
  [[nodiscard]] virtual std::size_t element_size() const noexcept = 0;  ///< bytes of one element
  [[nodiscard]] virtual std::size_t alignment() const noexcept = 0;     ///< bytes
  /// Of a sequence; nullptr for all others.
  [[nodiscard]] virtual const SequenceAccess* sequence() const noexcept { return nullptr; }

  /// As in ObjectType.
  virtual void construct(std::byte* memory) const = 0;
  virtual void relocate(std::byte* memory, std::byte* from) const noexcept = 0;
  virtual void destroy(std::byte* field) const noexcept = 0;
  virtual void write(CdrWriter& cdr, const std::byte* field) const = 0;
  virtual void read(CdrReader& cdr, std::byte* field) const = 0;
  virtual void measure(CdrSize& cdr, const std::byte* field) const = 0;
};

/// `nested`: the type of the messages in it; for other fields nullptr.
[[nodiscard]] std::unique_ptr<FieldStorage> make_field_storage(const generator::Field& field,
                                                               const ObjectType* nested);

}  // namespace pipescout::idl
