// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "pipescout/idl/message_type.hpp"
#include "pipescout/idl/support/cdr.hpp"

namespace pipescout::idl {

/// Messages of one type as parts of other objects: in memory that somebody else owns, and as
/// consecutive fields of a longer CDR stream. Whatever type is loaded at run time holds its nested
/// messages so, be they of generated classes or loaded themselves.
class ObjectType {
 public:
  ObjectType() = default;
  virtual ~ObjectType() = default;
  ObjectType(const ObjectType&) = delete;
  ObjectType& operator=(const ObjectType&) = delete;

  [[nodiscard]] virtual const MessageType& type() const noexcept = 0;
  [[nodiscard]] virtual std::size_t size() const noexcept = 0;       ///< bytes
  [[nodiscard]] virtual std::size_t alignment() const noexcept = 0;  ///< bytes

  /// Makes a message with the defaults of its definition.
  virtual void construct(void* memory) const = 0;
  /// Makes the message at `memory` out of the one at `from`, which is destroyed.
  virtual void relocate(void* memory, void* from) const noexcept = 0;
  virtual void destroy(void* message) const noexcept = 0;

  /// Each throws CdrError, as the functions of generated code.
  virtual void write(CdrWriter& cdr, const void* message) const = 0;
  virtual void read(CdrReader& cdr, void* message) const = 0;
  virtual void measure(CdrSize& cdr, const void* message) const = 0;
};

/// Of a generated class.
template <class T>
class GeneratedObjectType final : public ObjectType {
 public:
  [[nodiscard]] const MessageType& type() const noexcept override { return message_type<T>(); }
  [[nodiscard]] std::size_t size() const noexcept override { return sizeof(T); }
  [[nodiscard]] std::size_t alignment() const noexcept override { return alignof(T); }

  void construct(void* memory) const override { std::construct_at(static_cast<T*>(memory)); }
  void relocate(void* memory, void* from) const noexcept override {
    auto* const source = static_cast<T*>(from);
    std::construct_at(static_cast<T*>(memory), std::move(*source));
    std::destroy_at(source);
  }
  void destroy(void* message) const noexcept override { std::destroy_at(static_cast<T*>(message)); }

  void write(CdrWriter& cdr, const void* message) const override {
    write_fields(cdr, *static_cast<const T*>(message));
  }
  void read(CdrReader& cdr, void* message) const override {
    read_fields(cdr, *static_cast<T*>(message));
  }
  void measure(CdrSize& cdr, const void* message) const override {
    measure_fields(cdr, *static_cast<const T*>(message));
  }
};

/// The object types of a package: exported by a generated library as the symbol
/// `pipescout_message_objects_of_PACKAGE`.
struct PackageObjects {
  const ObjectType* const* types;
  std::size_t count;
};

}  // namespace pipescout::idl
