// SPDX-License-Identifier: Apache-2.0
#include "field_storage.hpp"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipescout/idl/support/type_support.hpp"
#include "utf16.hpp"

namespace pipescout::idl {
namespace {

template <class T>
constexpr bool kIsText = std::is_same_v<T, std::string> || std::is_same_v<T, std::u16string>;

void check_room(std::size_t count, std::size_t bound) {
  if (bound != 0 && count > bound) {
    throw std::length_error("a sequence of at most " + std::to_string(bound) +
                            " elements was to hold " + std::to_string(count));
  }
}

/// The bytes that any message of the type takes on the wire at least, without padding: a length
/// that promises more elements than can follow is refused before memory is allocated for them.
std::size_t least_bytes(const MessageType& type) {
  std::size_t bytes = 0;
  for (const MessageField& field : type.fields) {
    if (field.shape == FieldShape::kSequence) {
      bytes += sizeof(std::uint32_t);
      continue;
    }
    const std::size_t element = field.kind == FieldKind::kMessage ? least_bytes(field.message())
                                : size_of(field.kind) != 0
                                    ? size_of(field.kind)
                                    : sizeof(std::uint32_t);  // the length of a string
    bytes += element * (field.shape == FieldShape::kArray ? field.length : 1);
  }
  return std::max<std::size_t>(bytes, 1);
}

/// A sequence of numbers or strings.
template <class T>
class ValueSequence {
 public:
  using value_type = T;

  ValueSequence(std::vector<T> elements, std::size_t bound)
      : elements_(std::move(elements)), bound_(bound) {}

  [[nodiscard]] std::size_t size() const noexcept { return elements_.size(); }
  void resize(std::size_t count) {
    check_room(count, bound_);
    elements_.resize(count);
  }
  [[nodiscard]] auto data() noexcept { return elements_.data(); }
  decltype(auto) operator[](std::size_t index) { return elements_[index]; }
  decltype(auto) operator[](std::size_t index) const { return elements_[index]; }

  [[nodiscard]] std::vector<T>& elements() noexcept { return elements_; }
  [[nodiscard]] const std::vector<T>& elements() const noexcept { return elements_; }

 private:
  std::vector<T> elements_;
  std::size_t bound_;
};

/// A sequence of messages, one behind the other.
class MessageSequence {
 public:
  using value_type = std::byte;

  MessageSequence(const ObjectType& type, std::size_t bound) : type_(&type), bound_(bound) {}
  MessageSequence(MessageSequence&& other) noexcept
      : type_(other.type_),
        bound_(other.bound_),
        memory_(std::exchange(other.memory_, nullptr)),
        size_(std::exchange(other.size_, 0)) {}
  MessageSequence& operator=(MessageSequence&&) = delete;
  ~MessageSequence() {
    shrink(0);
    release(memory_);
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] void* data() noexcept { return memory_; }
  [[nodiscard]] std::byte* element(std::size_t index) const noexcept {
    return memory_ + index * type_->size();
  }

  void resize(std::size_t count) {
    check_room(count, bound_);
    if (count <= size_) {
      shrink(count);
      return;
    }
    auto* const larger = static_cast<std::byte*>(
        ::operator new(count * type_->size(), std::align_val_t(type_->alignment())));
    std::size_t made = size_;
    try {
      for (; made < count; ++made) {
        type_->construct(larger + made * type_->size());
      }
    } catch (...) {
      while (made > size_) {
        type_->destroy(larger + --made * type_->size());
      }
      release(larger);
      throw;
    }
    for (std::size_t i = 0; i < size_; ++i) {
      type_->relocate(larger + i * type_->size(), element(i));
    }
    release(memory_);
    memory_ = larger;
    size_ = count;
  }

 private:
  void shrink(std::size_t count) noexcept {
    while (size_ > count) {
      type_->destroy(element(--size_));
    }
  }
  void release(std::byte* memory) const noexcept {
    ::operator delete(memory, std::align_val_t(type_->alignment()));
  }

  const ObjectType* type_;
  std::size_t bound_;
  std::byte* memory_ = nullptr;
  std::size_t size_ = 0;
};

/// A value of a definition as the type that holds it in memory.
template <class T>
T value_as(const generator::Value& value) {
  return std::visit(
      [](const auto& held) -> T {
        using Held = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<T, std::u16string> && std::is_same_v<Held, std::string>) {
          if (auto wide = to_utf16(held)) {
            return *std::move(wide);
          }
          throw std::invalid_argument("a default value is no UTF-8");
        } else if constexpr (std::is_same_v<T, Held>) {
          return held;
        } else if constexpr (std::is_arithmetic_v<T> && std::is_arithmetic_v<Held>) {
          return static_cast<T>(held);  // the parser has checked the range
        } else {
          throw std::invalid_argument("a default value is of another kind");
        }
      },
      value);
}

template <class T>
std::vector<T> default_values(const generator::Field& field) {
  std::vector<T> values;
  for (const auto& value : field.default_value.value_or(std::vector<generator::Value>{})) {
    values.push_back(value_as<T>(value));
  }
  return values;
}

/// Numbers, truth values and strings: a single one or an array.
template <class T>
class ValueStorage final : public FieldStorage {
 public:
  explicit ValueStorage(const generator::Field& field)
      : count_(field.type.shape == generator::Shape::kArray ? field.type.length : 1),
        text_bound_(field.type.text_length),
        defaults_(default_values<T>(field)) {
    defaults_.resize(count_);
  }

  [[nodiscard]] std::size_t size() const noexcept override { return count_ * sizeof(T); }
  [[nodiscard]] std::size_t element_size() const noexcept override { return sizeof(T); }
  [[nodiscard]] std::size_t alignment() const noexcept override { return alignof(T); }

  void construct(std::byte* memory) const override {
    std::uninitialized_copy_n(defaults_.begin(), count_, values(memory));
  }
  void relocate(std::byte* memory, std::byte* from) const noexcept override {
    std::uninitialized_move_n(values(from), count_, values(memory));
    destroy(from);
  }
  void destroy(std::byte* field) const noexcept override { std::destroy_n(values(field), count_); }

  void write(CdrWriter& cdr, const std::byte* field) const override {
    if constexpr (Number<T>) {
      cdr.numbers<sizeof(T)>(field, count_);
    } else {
      each(field, [&](const T& value) {
        if constexpr (kIsText<T>) {
          cdr.put(value, text_bound_);
        } else {
          cdr.put(value);
        }
      });
    }
  }
  void read(CdrReader& cdr, std::byte* field) const override {
    if constexpr (Number<T>) {
      cdr.numbers<sizeof(T)>(field, count_);
    } else {
      each(field, [&](T& value) {
        if constexpr (kIsText<T>) {
          cdr.get(value, text_bound_);
        } else {
          cdr.get(value);
        }
      });
    }
  }
  void measure(CdrSize& cdr, const std::byte* field) const override {
    each(field, [&](const T& value) { cdr.add(value); });
  }

 private:
  static T* values(std::byte* field) { return reinterpret_cast<T*>(field); }

  template <class Byte, class Function>
  void each(Byte* field, Function function) const {
    using Element = std::conditional_t<std::is_const_v<Byte>, const T, T>;
    std::for_each_n(reinterpret_cast<Element*>(field), count_, function);
  }

  std::size_t count_;
  std::size_t text_bound_;
  std::vector<T> defaults_;
};

/// A sequence of numbers, truth values or strings.
template <class T>
class ValueSequenceStorage final : public FieldStorage {
  using Sequence = ValueSequence<T>;

 public:
  explicit ValueSequenceStorage(const generator::Field& field)
      : bound_(field.type.length),
        text_bound_(field.type.text_length),
        defaults_(default_values<T>(field)) {}

  [[nodiscard]] std::size_t size() const noexcept override { return sizeof(Sequence); }
  [[nodiscard]] std::size_t element_size() const noexcept override { return sizeof(T); }
  [[nodiscard]] std::size_t alignment() const noexcept override { return alignof(Sequence); }
  [[nodiscard]] const SequenceAccess* sequence() const noexcept override {
    return &kSequenceAccess<Sequence>;
  }

  void construct(std::byte* memory) const override { new (memory) Sequence(defaults_, bound_); }
  void relocate(std::byte* memory, std::byte* from) const noexcept override {
    new (memory) Sequence(std::move(of(from)));
    destroy(from);
  }
  void destroy(std::byte* field) const noexcept override { std::destroy_at(&of(field)); }

  void write(CdrWriter& cdr, const std::byte* field) const override {
    const auto& elements = of(field).elements();
    check_bound(elements.size(), bound_);
    if constexpr (kIsText<T>) {
      cdr.put(elements, text_bound_);
    } else {
      cdr.put(elements);
    }
  }
  void read(CdrReader& cdr, std::byte* field) const override {
    auto& elements = of(field).elements();
    if constexpr (kIsText<T>) {
      cdr.get(elements, text_bound_);
    } else {
      cdr.get(elements);
    }
    if (bound_ != 0 && elements.size() > bound_) {
      const std::size_t length = elements.size();
      elements.clear();
      refuse_bound(length, bound_);
    }
  }
  void measure(CdrSize& cdr, const std::byte* field) const override {
    cdr.add(of(field).elements());
  }

 private:
  static Sequence& of(std::byte* field) { return *reinterpret_cast<Sequence*>(field); }
  static const Sequence& of(const std::byte* field) {
    return *reinterpret_cast<const Sequence*>(field);
  }

  std::size_t bound_;
  std::size_t text_bound_;
  std::vector<T> defaults_;
};

/// A message, or an array of them.
class MessageStorage final : public FieldStorage {
 public:
  MessageStorage(const generator::Field& field, const ObjectType& type)
      : type_(type), count_(field.type.shape == generator::Shape::kArray ? field.type.length : 1) {}

  [[nodiscard]] std::size_t size() const noexcept override { return count_ * type_.size(); }
  [[nodiscard]] std::size_t element_size() const noexcept override { return type_.size(); }
  [[nodiscard]] std::size_t alignment() const noexcept override { return type_.alignment(); }

  void construct(std::byte* memory) const override {
    std::size_t made = 0;
    try {
      for (; made < count_; ++made) {
        type_.construct(memory + made * type_.size());
      }
    } catch (...) {
      while (made > 0) {
        type_.destroy(memory + --made * type_.size());
      }
      throw;
    }
  }
  void relocate(std::byte* memory, std::byte* from) const noexcept override {
    for (std::size_t i = 0; i < count_; ++i) {
      type_.relocate(memory + i * type_.size(), from + i * type_.size());
    }
  }
  void destroy(std::byte* field) const noexcept override {
    for (std::size_t i = 0; i < count_; ++i) {
      type_.destroy(field + i * type_.size());
    }
  }
  void write(CdrWriter& cdr, const std::byte* field) const override {
    for (std::size_t i = 0; i < count_; ++i) {
      type_.write(cdr, field + i * type_.size());
    }
  }
  void read(CdrReader& cdr, std::byte* field) const override {
    for (std::size_t i = 0; i < count_; ++i) {
      type_.read(cdr, field + i * type_.size());
    }
  }
  void measure(CdrSize& cdr, const std::byte* field) const override {
    for (std::size_t i = 0; i < count_; ++i) {
      type_.measure(cdr, field + i * type_.size());
    }
  }

 private:
  const ObjectType& type_;
  std::size_t count_;
};

class MessageSequenceStorage final : public FieldStorage {
 public:
  MessageSequenceStorage(const generator::Field& field, const ObjectType& type)
      : type_(type), bound_(field.type.length), least_bytes_(least_bytes(type.type())) {}

  [[nodiscard]] std::size_t size() const noexcept override { return sizeof(MessageSequence); }
  [[nodiscard]] std::size_t element_size() const noexcept override { return type_.size(); }
  [[nodiscard]] std::size_t alignment() const noexcept override { return alignof(MessageSequence); }
  [[nodiscard]] const SequenceAccess* sequence() const noexcept override {
    return &kSequenceAccess<MessageSequence>;
  }

  void construct(std::byte* memory) const override { new (memory) MessageSequence(type_, bound_); }
  void relocate(std::byte* memory, std::byte* from) const noexcept override {
    new (memory) MessageSequence(std::move(of(from)));
    destroy(from);
  }
  void destroy(std::byte* field) const noexcept override { std::destroy_at(&of(field)); }

  void write(CdrWriter& cdr, const std::byte* field) const override {
    const auto& sequence = of(field);
    check_bound(sequence.size(), bound_);
    check_bound(sequence.size(), std::numeric_limits<std::uint32_t>::max());
    cdr.put(static_cast<std::uint32_t>(sequence.size()));
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      type_.write(cdr, sequence.element(i));
    }
  }
  void read(CdrReader& cdr, std::byte* field) const override {
    std::uint32_t length = 0;
    cdr.get(length);
    check_bound(length, bound_);
    if (length > cdr.remaining() / least_bytes_) {
      refuse_truncated();
    }
    auto& sequence = of(field);
    sequence.resize(length);
    for (std::size_t i = 0; i < length; ++i) {
      type_.read(cdr, sequence.element(i));
    }
  }
  void measure(CdrSize& cdr, const std::byte* field) const override {
    const auto& sequence = of(field);
    cdr.add(std::uint32_t{});
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      type_.measure(cdr, sequence.element(i));
    }
  }

 private:
  static MessageSequence& of(std::byte* field) {
    return *reinterpret_cast<MessageSequence*>(field);
  }
  static const MessageSequence& of(const std::byte* field) {
    return *reinterpret_cast<const MessageSequence*>(field);
  }

  const ObjectType& type_;
  std::size_t bound_;
  std::size_t least_bytes_;
};

template <class T>
std::unique_ptr<FieldStorage> value_storage(const generator::Field& field) {
  if (field.type.shape == generator::Shape::kSequence) {
    return std::make_unique<ValueSequenceStorage<T>>(field);
  }
  return std::make_unique<ValueStorage<T>>(field);
}

}  // namespace

std::unique_ptr<FieldStorage> make_field_storage(const generator::Field& field,
                                                 const ObjectType* nested) {
  using generator::Kind;
  switch (field.type.kind) {
    case Kind::kBool:
      return value_storage<bool>(field);
    case Kind::kOctet:
    case Kind::kChar:
    case Kind::kUInt8:
      return value_storage<std::uint8_t>(field);
    case Kind::kInt8:
      return value_storage<std::int8_t>(field);
    case Kind::kInt16:
      return value_storage<std::int16_t>(field);
    case Kind::kUInt16:
      return value_storage<std::uint16_t>(field);
    case Kind::kInt32:
      return value_storage<std::int32_t>(field);
    case Kind::kUInt32:
      return value_storage<std::uint32_t>(field);
    case Kind::kInt64:
      return value_storage<std::int64_t>(field);
    case Kind::kUInt64:
      return value_storage<std::uint64_t>(field);
    case Kind::kFloat32:
      return value_storage<float>(field);
    case Kind::kFloat64:
      return value_storage<double>(field);
    case Kind::kString:
      return value_storage<std::string>(field);
    case Kind::kWString:
      return value_storage<std::u16string>(field);
    case Kind::kMessage:
      break;
  }
  if (nested == nullptr) {
    throw std::invalid_argument(field.name + ": its message type is missing");
  }
  if (field.type.shape == generator::Shape::kSequence) {
    return std::make_unique<MessageSequenceStorage>(field, *nested);
  }
  return std::make_unique<MessageStorage>(field, *nested);
}

}  // namespace pipescout::idl
