// SPDX-License-Identifier: Apache-2.0
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <algorithm>
#include <exception>
#include <string>

#include "pipescout/idl/support/type_support.hpp"

namespace pipescout::idl {

namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// DDS pads a payload to a multiple of four bytes.
constexpr std::size_t kMostPadding = 3;

/// Plain CDR in either byte order; parameter lists and the encodings of XTypes are not.
bool is_plain_cdr(std::span<const std::byte> buffer) {
  return buffer.size() >= kEncapsulationSize && buffer[0] == std::byte{0} &&
         (buffer[1] == std::byte{Cdr::BIG_ENDIANNESS} ||
          buffer[1] == std::byte{Cdr::LITTLE_ENDIANNESS});
}

}  // namespace

void refuse_bound(std::size_t length, std::size_t bound) {
  throw CdrError("length " + std::to_string(length) + " exceeds the bound of " +
                 std::to_string(bound));
}

void refuse_short_buffer() {
  throw CdrError("the buffer is too small");
}

void refuse_truncated() {
  throw CdrError("the bytes end too early");
}

void refuse_truth_value(unsigned value) {
  throw CdrError(std::to_string(value) + " is no truth value");
}

void CdrWriter::put(const std::u16string& text, std::size_t bound) {
  check_bound(text.size(), bound);
  put_length(text.size());
  for (const char16_t c : text) {
    put(static_cast<std::uint32_t>(c));
  }
}

void CdrReader::swap_numbers(char* first, std::size_t size, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i, first += size) {
    std::reverse(first, first + size);
  }
}

void CdrReader::get(std::u16string& text, std::size_t bound) {
  const std::size_t length = get_length(kWideCharacterSize);
  check_bound(length, bound);
  text.resize(length);
  for (char16_t& c : text) {
    std::uint32_t character = 0;
    get(character);
    c = static_cast<char16_t>(character);
  }
}

void CdrReader::get(std::vector<bool>& sequence) {
  const std::size_t length = get_length(1);
  sequence.resize(length);
  for (std::size_t i = 0; i < length; ++i) {
    bool value = false;
    get(value);
    sequence[i] = value;
  }
}

std::size_t serialize(const void* message, std::span<std::byte> buffer, WriteFields write) {
  auto* const data = reinterpret_cast<char*>(buffer.data());
  FastBuffer bytes(data, buffer.size());
  Cdr stream(bytes, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  try {
    stream.serialize_encapsulation();
    CdrWriter writer(data + kEncapsulationSize, data + buffer.size());
    write(writer, message);
    return kEncapsulationSize + writer.written();
  } catch (const CdrError&) {
    return 0;
  } catch (const eprosima::fastcdr::exception::Exception&) {
    return 0;
  }
}

bool deserialize(std::span<const std::byte> buffer, void* message, ReadFields read) {
  if (!is_plain_cdr(buffer)) {
    return false;
  }
  // fastcdr reads through the same class as it writes; it does not write to these bytes.
  auto* const data = const_cast<char*>(reinterpret_cast<const char*>(buffer.data()));
  FastBuffer bytes(data, buffer.size());
  Cdr stream(bytes, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  try {
    stream.read_encapsulation();
    CdrReader reader(data + kEncapsulationSize, data + buffer.size(),
                     stream.endianness() != Cdr::DEFAULT_ENDIAN);
    read(reader, message);
    // More than padding: the sender means another type by this name.
    return reader.remaining() <= kMostPadding;
  } catch (const std::exception&) {
    // CdrError, fastcdr's own exceptions, and std::bad_alloc.
    return false;
  }
}

}  // namespace pipescout::idl
