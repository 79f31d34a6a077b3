// SPDX-License-Identifier: Apache-2.0
#include "wire_type.hpp"

#include <fastdds/rtps/common/SerializedPayload.h>

#include <cstddef>
#include <limits>
#include <span>
#include <string>

namespace pipescout::dds {
namespace {

constexpr std::uint32_t kEncapsulationBytes = 4;

}  // namespace

WireType::WireType(std::string_view dds_name) {
  setName(std::string(dds_name).c_str());
  m_typeSize = kEncapsulationBytes;  // the least; every type counts as unbounded
  m_isGetKeyDefined = false;
  // ROS 2 Humble announces neither, and matches on the type's name.
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool WireType::serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) {
  const auto& sample = *static_cast<const OutgoingSample*>(data);
  const std::span bytes(reinterpret_cast<std::byte*>(payload->data), payload->max_size);
  std::size_t written = 0;
  if (!sample.reference) {
    written = sample.type.serialize(sample.message, bytes);
  } else if (bytes.size() >= kReferenceBytes) {
    encode(*sample.reference, bytes.first<kReferenceBytes>());
    written = kReferenceBytes;
  }
  payload->length = static_cast<std::uint32_t>(written);
  // What a generic publisher sends may come from a machine of the other byte order.
  payload->encapsulation = written > 1 && bytes[1] == std::byte{0} ? CDR_BE : CDR_LE;
  return written >= kEncapsulationBytes;
}

bool WireType::deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) {
  auto& sample = *static_cast<IncomingSample*>(data);
  const auto bytes = std::as_bytes(
      std::span<const eprosima::fastrtps::rtps::octet>(payload->data, payload->length));
  if (sample.skip) {
    sample.unread.assign(bytes.begin(), bytes.end());
  } else {
    sample.read(bytes);
  }
  return true;
}

void IncomingSample::read(std::span<const std::byte> bytes) {
  malformed = false;
  lost = false;
  message.reset();
  const auto decode = [&](std::span<const std::byte> content) {
    try {
      message = type.create();
      malformed = !type.deserialize(content, message.get());
    } catch (...) {  // no memory for what it claims to hold
      malformed = true;
    }
  };
  if (const auto reference = decode_reference(bytes)) {
    lost = !payloads.take(*reference, decode);
  } else {
    decode(bytes);
  }
}

std::function<std::uint32_t()> WireType::getSerializedSizeProvider(void* data) {
  return [data]() -> std::uint32_t {
    const auto& sample = *static_cast<const OutgoingSample*>(data);
    const std::size_t size =
        sample.reference ? kReferenceBytes : sample.type.serialized_size(sample.message);
    // A size of 0 is refused by Fast DDS, which then reports that the sample cannot be written.
    return size > std::numeric_limits<std::uint32_t>::max() ? 0 : static_cast<std::uint32_t>(size);
  };
}

// For samples that Fast DDS would lend, which nobody asks it for.
void* WireType::createData() {
  return nullptr;
}

void WireType::deleteData(void*) {}

bool WireType::getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) {
  return false;
}

}  // namespace pipescout::dds
