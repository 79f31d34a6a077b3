// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pipescout/idl/message_type.hpp"
#include "shared_payloads.hpp"

namespace pipescout::dds {

/// What is written: a message, or the reference to where it lies in shared memory.
struct OutgoingSample {
  const MessageType& type;
  const void* message = nullptr;
  std::optional<PayloadReference> reference;
};

/// What a take fills in.
struct IncomingSample {
  const MessageType& type;  ///< of what is to be made of the bytes
  PayloadReader& payloads;  ///< for references
  bool skip = false;        ///< set by the taker: only keep the bytes, in `unread`
  bool malformed = false;   ///< the bytes are no message of the type
  bool lost = false;        ///< a reference to what is not there any more
  std::shared_ptr<void> message = nullptr;
  std::vector<std::byte> unread{};

  /// Makes of the bytes what `type` asks for, or says why not.
  void read(std::span<const std::byte> bytes);
};

/// Fast DDS's view of any wire type, of which it has one for each name in a participant: endpoints
/// of objects and of bytes share it, so that each sample says what it is. The `data` of a write is
/// an `OutgoingSample`, that of a take an `IncomingSample`.
class WireType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit WireType(std::string_view dds_name);

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  /// True for malformed bytes too, so that the taker learns of each such sample.
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override;
  void deleteData(void* data) override;
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle,
              bool force_md5) override;
};

}  // namespace pipescout::dds
