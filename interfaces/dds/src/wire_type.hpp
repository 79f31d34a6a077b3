// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <memory>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::dds {

/// What a take fills in.
struct IncomingSample {
  bool skip = false;       ///< set by the taker: leave the bytes alone
  bool malformed = false;  ///< the bytes are no message of the type
  std::shared_ptr<void> message;
};

/// Fast DDS's view of any wire type. The `data` of a write is the message itself; the `data` of a
/// take is an `IncomingSample`.
class WireType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit WireType(const MessageType& type);

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  /// True for malformed bytes too, so that the taker learns of each such sample.
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override;
  void deleteData(void* data) override;
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle,
              bool force_md5) override;

 private:
  const MessageType& type_;
};

}  // namespace pipescout::dds
