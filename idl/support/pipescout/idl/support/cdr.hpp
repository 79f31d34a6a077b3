// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/BadParamException.h>
#include <fastcdr/exceptions/NotEnoughMemoryException.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "pipescout/idl/bounded_vector.hpp"
#include "pipescout/idl/message_type.hpp"

/// What the generated code calls for the fields of a message; for that code only.
namespace pipescout::idl {

template <class T>
concept Number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

template <class T>
concept Structure = Message<T>;

/// The unsigned number of that many bytes, as which all numbers of that size are copied.
template <std::size_t Size>
using Word = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

/// Bytes of a character of a wide string, which CDR in ROS 2 has as a `wchar_t` of Linux.
inline constexpr std::size_t kWideCharacterSize = 4;

[[noreturn]] void refuse_bound(std::size_t length, std::size_t bound);

/// Throws what leads to a refusal of the message when `bound`, unless 0, is exceeded.
inline void check_bound(std::size_t length, std::size_t bound) {
  if (bound != 0 && length > bound) {
    refuse_bound(length, bound);
  }
}

/// Characters ahead of the first NUL, as CDR strings cannot hold one.
inline std::size_t text_length(const std::string& text) {
  return ::strnlen(text.data(), text.size());
}

/// Writes fields one behind the other. Throws exceptions of fastcdr when the buffer is too small or
/// a bound is exceeded.
class CdrWriter {
 public:
  explicit CdrWriter(eprosima::fastcdr::Cdr& cdr) : cdr_(cdr) {}

  /// Numbers of the same size that lie one behind the other in memory.
  template <std::size_t Size>
  void numbers(const void* first, std::size_t count) {
    cdr_.serializeArray(static_cast<const Word<Size>*>(first), count);
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { cdr_.serialize(value); }

  void put(const std::string& text, std::size_t bound = 0);
  void put(const std::u16string& text, std::size_t bound = 0);

  template <Structure T>
  void put(const T& message) {
    write_fields(*this, message);
  }

  /// Arrays and sequences; `bounds` of the strings in them.
  template <class T, std::size_t N, class... Bounds>
  void put(const std::array<T, N>& array, Bounds... bounds) {
    elements(array, bounds...);
  }

  template <class T, class... Bounds>
  void put(const std::vector<T>& sequence, Bounds... bounds) {
    put_length(sequence.size());
    elements(sequence, bounds...);
  }

  template <class T, std::size_t N, class... Bounds>
  void put(const BoundedVector<T, N>& sequence, Bounds... bounds) {
    put(sequence.vector(), bounds...);
  }

  /// A sequence of structures that are made of `count` numbers of the same size.
  template <std::size_t Size, class T>
  void put_uniform(const std::vector<T>& sequence, std::size_t count) {
    put_length(sequence.size());
    if (!sequence.empty()) {
      numbers<Size>(sequence.data(), sequence.size() * count);
    }
  }

  template <std::size_t Size, class T, std::size_t N>
  void put_uniform(const BoundedVector<T, N>& sequence, std::size_t count) {
    put_uniform<Size>(sequence.vector(), count);
  }

 private:
  void put_length(std::size_t length);

  template <class Container, class... Bounds>
  void elements(const Container& container, Bounds... bounds) {
    using T = typename Container::value_type;
    if constexpr (Number<T>) {
      if (!container.empty()) {
        numbers<sizeof(T)>(container.data(), container.size());
      }
    } else {
      for (const auto& element : container) {
        put(element, bounds...);
      }
    }
  }

  eprosima::fastcdr::Cdr& cdr_;
};

/// Elements of a variable size for which room is made before the first of them is read.
inline constexpr std::size_t kReservedElements = 64;

/// Reads fields one behind the other. Throws exceptions of fastcdr on truncated or malformed bytes.
///
/// A sequence announces its length ahead of its elements, and a hostile or broken peer may announce
/// any. Memory is taken only for what can follow in the bytes that are left, and of elements of a
/// variable size only as they arrive.
class CdrReader {
 public:
  CdrReader(eprosima::fastcdr::Cdr& cdr, const char* end) : cdr_(cdr), end_(end) {}

  template <std::size_t Size>
  void numbers(void* first, std::size_t count) {
    cdr_.deserializeArray(static_cast<Word<Size>*>(first), count);
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void get(T& value) { cdr_.deserialize(value); }

  void get(std::string& text, std::size_t bound = 0);
  void get(std::u16string& text, std::size_t bound = 0);

  template <Structure T>
  void get(T& message) {
    read_fields(*this, message);
  }

  template <class T, std::size_t N, class... Bounds>
  void get(std::array<T, N>& array, Bounds... bounds) {
    if constexpr (Number<T>) {
      numbers<sizeof(T)>(array.data(), N);
    } else {
      for (T& element : array) {
        get(element, bounds...);
      }
    }
  }

  void get(std::vector<bool>& sequence);

  template <Number T>
  void get(std::vector<T>& sequence) {
    get_numbers<sizeof(T)>(sequence, 1);
  }

  template <class T, class... Bounds>
  requires std::is_class_v<T>
  void get(std::vector<T>& sequence, Bounds... bounds) {
    // No element is shorter than a byte; each read below checks for itself.
    get_elements(sequence, get_length(1), bounds...);
  }

  template <class T, std::size_t N, class... Bounds>
  void get(BoundedVector<T, N>& sequence, Bounds... bounds) {
    check_next_length(N);
    std::vector<T> elements;
    get(elements, bounds...);
    sequence = std::move(elements);
  }

  template <std::size_t Size, class T>
  void get_uniform(std::vector<T>& sequence, std::size_t count) {
    get_numbers<Size>(sequence, count);
  }

  template <std::size_t Size, class T, std::size_t N>
  void get_uniform(BoundedVector<T, N>& sequence, std::size_t count) {
    check_next_length(N);
    std::vector<T> elements;
    get_numbers<Size>(elements, count);
    sequence = std::move(elements);
  }

 private:
  [[nodiscard]] std::size_t remaining() const {
    return static_cast<std::size_t>(end_ - cdr_.getCurrentPosition());
  }

  /// The length of a sequence whose elements take at least `element_size` bytes each.
  std::size_t get_length(std::size_t element_size);
  /// Looks at the length that follows without taking it.
  void check_next_length(std::size_t bound);
  void get_bytes(std::vector<std::uint8_t>& sequence, std::size_t length);

  template <std::size_t Size, class T>
  void get_numbers(std::vector<T>& sequence, std::size_t count) {
    const std::size_t length = get_length(Size * count);
    if (length == 0) {
      sequence.clear();
    } else if constexpr (std::is_same_v<T, std::uint8_t>) {
      get_bytes(sequence, length);
    } else {
      sequence.resize(length);
      numbers<Size>(sequence.data(), length * count);
    }
  }

  template <class T, class... Bounds>
  void get_elements(std::vector<T>& sequence, std::size_t length, Bounds... bounds) {
    if (sequence.size() > length) {
      sequence.resize(length);
    }
    sequence.reserve(std::min(length, kReservedElements));
    for (std::size_t i = 0; i < length; ++i) {
      if (i == sequence.size()) {
        sequence.emplace_back();
      }
      get(sequence[i], bounds...);
    }
  }

  eprosima::fastcdr::Cdr& cdr_;
  const char* end_;
};

/// Adds up what fields take that CdrWriter writes one behind the other.
class CdrSize {
 public:
  /// Bytes so far, without the encapsulation header.
  [[nodiscard]] std::size_t bytes() const { return at_; }

  template <std::size_t Size>
  void numbers(std::size_t count) {
    at_ = ((at_ + Size - 1) & ~(Size - 1)) + Size * count;
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void add(const T&) { numbers<sizeof(T)>(1); }

  void add(const std::string& text) {
    numbers<4>(1);
    at_ += text_length(text) + 1;
  }

  void add(const std::u16string& text) {
    numbers<4>(1);
    at_ += kWideCharacterSize * text.size();
  }

  template <Structure T>
  void add(const T& message) {
    measure_fields(*this, message);
  }

  template <class T, std::size_t N>
  void add(const std::array<T, N>& array) {
    elements(array);
  }

  template <class T>
  void add(const std::vector<T>& sequence) {
    numbers<4>(1);
    elements(sequence);
  }

  template <class T, std::size_t N>
  void add(const BoundedVector<T, N>& sequence) {
    add(sequence.vector());
  }

  /// A sequence of `length` structures that are made of `count` numbers of the same size.
  template <std::size_t Size>
  void add_uniform(std::size_t length, std::size_t count) {
    numbers<4>(1);
    if (length != 0) {
      numbers<Size>(length * count);
    }
  }

 private:
  template <class Container>
  void elements(const Container& container) {
    using T = typename Container::value_type;
    if constexpr (std::is_arithmetic_v<T>) {
      if (!container.empty()) {
        numbers<sizeof(T)>(container.size());
      }
    } else {
      for (const auto& element : container) {
        add(element);
      }
    }
  }

  std::size_t at_ = 0;
};

}  // namespace pipescout::idl
