// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "pipescout/idl/bounded_vector.hpp"
#include "pipescout/idl/message_type.hpp"

/// Serialisation of the fields of a message, called by the generated code only.
namespace pipescout::idl {

template <class T>
concept Number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

template <class T>
concept Structure = Message<T>;

/// Bytes of a character of a wide string: CDR in ROS 2 uses the `wchar_t` of Linux.
inline constexpr std::size_t kWideCharacterSize = 4;

static_assert(std::endian::native == std::endian::little,
              "what is copied at once is little-endian");

/// The data is not a message of the type, or the message cannot be written.
class CdrError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void refuse_bound(std::size_t length, std::size_t bound);
[[noreturn]] void refuse_short_buffer();
[[noreturn]] void refuse_truncated();
[[noreturn]] void refuse_truth_value(unsigned value);

/// Bytes from `at` to the next multiple of `Size`, which is a power of two.
template <std::size_t Size>
constexpr std::size_t padding(std::size_t at) {
  return (Size - at) & (Size - 1);
}

/// Throws CdrError when `bound`, unless 0, is exceeded.
inline void check_bound(std::size_t length, std::size_t bound) {
  if (bound != 0 && length > bound) {
    refuse_bound(length, bound);
  }
}

/// The bytes of a whole message: what is copied at once reaches beyond the first field of a run.
template <Structure T>
const char* bytes_of(const T& message) {
  return reinterpret_cast<const char*>(&message);
}

template <Structure T>
char* bytes_of(T& message) {
  return reinterpret_cast<char*>(&message);
}

/// Characters before the first NUL, as CDR strings cannot contain one.
inline std::size_t text_length(const std::string& text) {
  const void* const end = std::memchr(text.data(), 0, text.size());
  return end == nullptr ? text.size()
                        : static_cast<std::size_t>(static_cast<const char*>(end) - text.data());
}

/// Writes consecutive fields as little-endian CDR. Throws CdrError when the buffer is too small or
/// a bound is exceeded.
///
/// fastcdr writes the encapsulation header. The fields are written by inline functions, because
/// fastcdr's calls took twice the time of Cyclone's generated code for messages of short strings.
class CdrWriter {
 public:
  /// Alignment counts from `begin`.
  CdrWriter(char* begin, char* end) : begin_(begin), at_(begin), end_(end) {}

  [[nodiscard]] std::size_t written() const { return static_cast<std::size_t>(at_ - begin_); }

  /// Contiguous numbers of the same size in memory.
  template <std::size_t Size>
  void numbers(const void* first, std::size_t count) {
    if (count != 0) {
      std::memcpy(make_room<Size>(count * Size), first, count * Size);
    }
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { std::memcpy(make_room<sizeof(T)>(sizeof(T)), &value, sizeof(T)); }

  void put(const std::string& text, std::size_t bound = 0) {
    check_bound(text.size(), bound);
    const std::size_t length = text_length(text) + 1;
    put_length(length);
    char* const to = make_room<1>(length);
    std::memcpy(to, text.c_str(), length - 1);
    to[length - 1] = '\0';
  }
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

  /// A sequence of structures that consist of `count` numbers of the same size.
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
  void put_length(std::size_t length) {
    check_bound(length, std::numeric_limits<std::uint32_t>::max());
    put(static_cast<std::uint32_t>(length));
  }

  /// Reserves `size` bytes after zero padding to the alignment.
  template <std::size_t Alignment>
  char* make_room(std::size_t size) {
    const std::size_t zeros = padding<Alignment>(written());
    const auto left = static_cast<std::size_t>(end_ - at_);
    if (left < zeros || left - zeros < size) {
      refuse_short_buffer();
    }
    for (std::size_t i = 0; i < zeros; ++i) {
      at_[i] = '\0';
    }
    char* const room = at_ + zeros;
    at_ = room + size;
    return room;
  }

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

  char* begin_;
  char* at_;
  char* end_;
};

/// Elements of variable size for which memory is allocated before the first one is read.
inline constexpr std::size_t kReservedElements = 64;

/// Reads consecutive fields, in either byte order. Throws CdrError on truncated or malformed bytes.
///
/// The length of a sequence precedes its elements, and a hostile or faulty peer may send any value.
/// Memory is allocated only for elements that fit into the remaining bytes, and for elements of
/// variable size only as they are read.
class CdrReader {
 public:
  /// Alignment counts from `begin`. `swap`: the bytes are big-endian.
  CdrReader(const char* begin, const char* end, bool swap)
      : begin_(begin), at_(begin), end_(end), swap_(swap) {}

  [[nodiscard]] std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

  /// Contiguous numbers of the same size in memory.
  template <std::size_t Size>
  void numbers(void* first, std::size_t count) {
    if (count == 0) {
      return;
    }
    std::memcpy(first, take<Size>(count * Size), count * Size);
    if (Size > 1 && swap_) {
      swap_numbers(static_cast<char*>(first), Size, count);
    }
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      const auto byte = static_cast<unsigned char>(*take<1>(1));
      if (byte > 1) {
        refuse_truth_value(byte);
      }
      value = byte != 0;
    } else {
      numbers<sizeof(T)>(&value, 1);
    }
  }

  void get(std::string& text, std::size_t bound = 0) {
    const std::size_t length = get_length(1);
    if (length == 0) {  // instead of a NUL, as some writers do
      text.clear();
      return;
    }
    const char* const first = take<1>(length);
    const std::size_t characters = first[length - 1] == '\0' ? length - 1 : length;
    check_bound(characters, bound);
    text.assign(first, characters);
  }
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
    // Each element takes at least one byte; the reads below check the rest.
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
  /// Takes `size` bytes after the padding to the alignment.
  template <std::size_t Alignment>
  const char* take(std::size_t size) {
    const std::size_t skipped = padding<Alignment>(static_cast<std::size_t>(at_ - begin_));
    if (remaining() < skipped || remaining() - skipped < size) {
      refuse_truncated();
    }
    const char* const first = at_ + skipped;
    at_ = first + size;
    return first;
  }

  static void swap_numbers(char* first, std::size_t size, std::size_t count);

  /// The length of a sequence whose elements take at least `element_size` bytes each.
  std::size_t get_length(std::size_t element_size) {
    std::uint32_t length = 0;
    get(length);
    if (length > remaining() / element_size) {
      refuse_truncated();
    }
    return length;
  }

  /// Returns the next length without consuming it.
  void check_next_length(std::size_t bound) {
    CdrReader ahead(*this);
    std::uint32_t length = 0;
    ahead.get(length);
    check_bound(length, bound);
  }

  template <std::size_t Size, class T>
  void get_numbers(std::vector<T>& sequence, std::size_t count) {
    const std::size_t length = get_length(Size * count);
    if (length == 0) {
      sequence.clear();
    } else if constexpr (std::is_same_v<T, std::uint8_t>) {
      // Copies in one pass; resizing first would fill the new elements with zeros.
      const auto* const first = reinterpret_cast<const std::uint8_t*>(take<1>(length));
      sequence.assign(first, first + length);
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

  const char* begin_;
  const char* at_;
  const char* end_;
  bool swap_;
};

/// Adds up the size of consecutive fields as CdrWriter writes them.
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

  /// A sequence of `length` structures that consist of `count` numbers of the same size.
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
