// SPDX-License-Identifier: Apache-2.0
#include "cdr_stream.hpp"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <exception>

namespace pipescout::idl {

namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// Plain CDR in either byte order; parameter lists and the encodings of XTypes are not.
bool is_plain_cdr(std::span<const std::byte> buffer) {
  return buffer.size() >= kEncapsulationSize && buffer[0] == std::byte{0} &&
         (buffer[1] == std::byte{Cdr::BIG_ENDIANNESS} ||
          buffer[1] == std::byte{Cdr::LITTLE_ENDIANNESS});
}

}  // namespace

std::size_t serialize(const void* message, std::span<std::byte> buffer, WriteFields write) {
  FastBuffer bytes(reinterpret_cast<char*>(buffer.data()), buffer.size());
  Cdr stream(bytes, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  try {
    stream.serialize_encapsulation();
    write(message, stream);
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
    read(message, stream);
  } catch (const std::exception&) {
    // fastcdr's own exceptions derive from it, and so does std::bad_alloc.
    return false;
  }
  return true;
}

}  // namespace pipescout::idl
