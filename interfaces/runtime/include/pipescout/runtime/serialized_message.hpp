// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "pipescout/idl/message_type.hpp"

/// Messages as bytes: what generic publishers and subscriptions take and give, for topics whose
/// type need not be known in this process.
namespace pipescout {

/// A message of any type as CDR behind its 4-byte encapsulation header, as it goes over the wire
/// and into a bag.
class SerializedMessage {
 public:
  SerializedMessage() = default;
  /// `size` bytes, not initialised.
  explicit SerializedMessage(std::size_t size)
      : bytes_(std::make_unique_for_overwrite<std::byte[]>(size)), size_(size) {}
  /// A copy of the bytes.
  explicit SerializedMessage(std::span<const std::byte> bytes);

  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return {bytes_.get(), size_}; }
  [[nodiscard]] std::span<std::byte> bytes() noexcept { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0;
};

/// What stands for the type of that ROS name ("sensor_msgs/msg/Image") where messages are
/// SerializedMessage. It lives until the process ends. The type need not exist here. Throws
/// InvalidName unless the name has the form package/kind/Type. Thread-safe.
const MessageType& serialized_type(std::string_view name);

/// True for what `serialized_type` returns.
[[nodiscard]] bool is_serialized(const MessageType& type) noexcept;

/// Null when the message exceeds a bound of its type.
[[nodiscard]] std::shared_ptr<const SerializedMessage> serialize(const MessageType& type,
                                                                 const void* message);
/// Null when the bytes are no message of the type.
[[nodiscard]] std::shared_ptr<const void> deserialize(const MessageType& type,
                                                      std::span<const std::byte> bytes);

}  // namespace pipescout
