// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/NotEnoughMemoryException.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// Reading of single fields, called by the generated `deserialize` of each message.
///
/// A sequence announces its length ahead of its elements, and a hostile or broken peer may announce
/// any. fastcdr resizes the vector to it as soon as that many BYTES follow, however large an
/// element is: a message of 1 MB could claim 600 MB of markers. Here the memory of a sequence grows
/// only with elements that have arrived.
///
/// All functions throw eprosima::fastcdr::exception::Exception on truncated or malformed bytes.
namespace pipescout::idl {

using eprosima::fastcdr::Cdr;

/// Elements of a variable size for which room is made before the first of them is read.
inline constexpr std::size_t kReservedElements = 64;

/// Throws unless that many bytes follow the current position.
inline void require_bytes(Cdr& cdr, std::size_t count) {
  const Cdr::state start = cdr.getState();
  if (!cdr.jump(count)) {
    throw eprosima::fastcdr::exception::NotEnoughMemoryException(
        eprosima::fastcdr::exception::NotEnoughMemoryException::NOT_ENOUGH_MEMORY_MESSAGE_DEFAULT);
  }
  Cdr::state restored{start};
  cdr.setState(restored);
}

/// Reads the length of a sequence whose elements take at least `element_size` bytes each.
inline std::size_t read_length(Cdr& cdr, std::size_t element_size) {
  std::uint32_t length = 0;
  cdr >> length;
  require_bytes(cdr, std::size_t{length} * element_size);
  return length;
}

/// A number, string or structure, or an array of them: their memory does not depend on the bytes,
/// except for a string's, which fastcdr allocates after checking it.
template <class T>
void read(Cdr& cdr, T& value) {
  cdr >> value;
}

inline void read(Cdr& cdr, std::vector<bool>& sequence) {
  const std::size_t length = read_length(cdr, 1);
  sequence.resize(length);
  for (std::size_t i = 0; i < length; ++i) {
    bool value = false;
    cdr >> value;
    sequence[i] = value;
  }
}

template <class T>
requires std::is_arithmetic_v<T>
void read(Cdr& cdr, std::vector<T>& sequence) {
  const std::size_t length = read_length(cdr, sizeof(T));
  if (length == 0) {
    sequence.clear();
    return;
  }
  if constexpr (sizeof(T) == 1) {
    // Copies in one pass, where resizing first would fill a new vector with zeros.
    const char* const first = cdr.getCurrentPosition();
    sequence.assign(first, first + length);
    // A jump keeps no account of alignment, so the last byte is read for that.
    cdr.jump(length - 1);
    cdr >> sequence.back();
  } else {
    sequence.resize(length);
    cdr.deserializeArray(sequence.data(), length);
  }
}

template <class T>
requires std::is_class_v<T>
void read(Cdr& cdr, std::vector<T>& sequence) {
  // No element of ours is shorter than a byte; each read below checks for itself.
  const std::size_t length = read_length(cdr, 1);
  if (sequence.size() > length) {
    sequence.resize(length);
  }
  sequence.reserve(std::min(length, kReservedElements));
  for (std::size_t i = 0; i < length; ++i) {
    if (i == sequence.size()) {
      sequence.emplace_back();
    }
    read(cdr, sequence[i]);
  }
}

}  // namespace pipescout::idl
