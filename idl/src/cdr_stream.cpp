// SPDX-License-Identifier: Apache-2.0
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <exception>
#include <limits>

#include "pipescout/idl/support/type_support.hpp"

namespace pipescout::idl {

namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastcdr::exception::BadParamException;
using eprosima::fastcdr::exception::NotEnoughMemoryException;

/// Plain CDR in either byte order; parameter lists and the encodings of XTypes are not.
bool is_plain_cdr(std::span<const std::byte> buffer) {
  return buffer.size() >= kEncapsulationSize && buffer[0] == std::byte{0} &&
         (buffer[1] == std::byte{Cdr::BIG_ENDIANNESS} ||
          buffer[1] == std::byte{Cdr::LITTLE_ENDIANNESS});
}

}  // namespace

void refuse_bound(std::size_t length, std::size_t bound) {
  throw BadParamException(
      ("length " + std::to_string(length) + " exceeds the bound of " + std::to_string(bound))
          .c_str());
}

void CdrWriter::put_length(std::size_t length) {
  check_bound(length, std::numeric_limits<std::uint32_t>::max());
  cdr_.serialize(static_cast<std::uint32_t>(length));
}

void CdrWriter::put(const std::string& text, std::size_t bound) {
  check_bound(text.size(), bound);
  cdr_.serialize(text.c_str());
}

void CdrWriter::put(const std::u16string& text, std::size_t bound) {
  check_bound(text.size(), bound);
  put_length(text.size());
  for (const char16_t c : text) {
    cdr_.serialize(static_cast<std::uint32_t>(c));
  }
}

std::size_t CdrReader::get_length(std::size_t element_size) {
  std::uint32_t length = 0;
  cdr_.deserialize(length);
  if (length > remaining() / element_size) {
    throw NotEnoughMemoryException(NotEnoughMemoryException::NOT_ENOUGH_MEMORY_MESSAGE_DEFAULT);
  }
  return length;
}

void CdrReader::check_next_length(std::size_t bound) {
  const Cdr::state start = cdr_.getState();
  std::uint32_t length = 0;
  cdr_.deserialize(length);
  check_bound(length, bound);
  Cdr::state restored{start};
  cdr_.setState(restored);
}

void CdrReader::get(std::string& text, std::size_t bound) {
  cdr_.deserialize(text);
  check_bound(text.size(), bound);
}

void CdrReader::get(std::u16string& text, std::size_t bound) {
  const std::size_t length = get_length(kWideCharacterSize);
  check_bound(length, bound);
  text.resize(length);
  for (char16_t& c : text) {
    std::uint32_t character = 0;
    cdr_.deserialize(character);
    c = static_cast<char16_t>(character);
  }
}

void CdrReader::get(std::vector<bool>& sequence) {
  const std::size_t length = get_length(1);
  sequence.resize(length);
  for (std::size_t i = 0; i < length; ++i) {
    bool value = false;
    cdr_.deserialize(value);
    sequence[i] = value;
  }
}

void CdrReader::get_bytes(std::vector<std::uint8_t>& sequence, std::size_t length) {
  // Copies in one pass, where resizing first would fill a new vector with zeros.
  const char* const first = cdr_.getCurrentPosition();
  sequence.assign(first, first + length);
  // A jump keeps no account of alignment, so the last byte is read for that.
  cdr_.jump(length - 1);
  cdr_.deserialize(sequence.back());
}

std::size_t serialize(const void* message, std::span<std::byte> buffer, WriteFields write) {
  FastBuffer bytes(reinterpret_cast<char*>(buffer.data()), buffer.size());
  Cdr stream(bytes, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  try {
    stream.serialize_encapsulation();
    CdrWriter writer(stream);
    write(writer, message);
  } catch (const eprosima::fastcdr::exception::Exception&) {
    return 0;
  }
  return stream.getSerializedDataLength();
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
    CdrReader reader(stream, data + buffer.size());
    read(reader, message);
  } catch (const std::exception&) {
    // fastcdr's own exceptions derive from it, and so does std::bad_alloc.
    return false;
  }
  return true;
}

}  // namespace pipescout::idl
