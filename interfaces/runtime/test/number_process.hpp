// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "pipescout/runtime/context.hpp"

/// What the tests of the broker publish, and the process in which they do it.
namespace pipescout {

/// A message that counts what is done to it.
struct Number {
  std::int64_t value = 0;

  Number() = default;
  explicit Number(std::int64_t number) : value(number) {}
  Number(const Number& other) : value(other.value) { ++copies; }
  Number& operator=(const Number& other) {
    value = other.value;
    ++copies;
    return *this;
  }

  static inline std::atomic<int> copies{0};
  static inline std::atomic<int> serialisations{0};
  static inline std::atomic<int> deserialisations{0};
};

inline const MessageType kNumber{
    .name = "test_msgs/msg/Number",
    .dds_name = "test_msgs::msg::dds_::Number_",
    .create = []() -> std::shared_ptr<void> { return std::make_shared<Number>(); },
    .serialized_size = [](const void*) { return sizeof(std::int64_t); },
    .serialize =
        [](const void* message, std::span<std::byte> buffer) {
          ++Number::serialisations;
          std::memcpy(buffer.data(), &static_cast<const Number*>(message)->value,
                      sizeof(std::int64_t));
          return sizeof(std::int64_t);
        },
    .deserialize =
        [](std::span<const std::byte> buffer, void* message) {
          ++Number::deserialisations;
          if (buffer.size() != sizeof(std::int64_t)) {
            return false;
          }
          std::memcpy(&static_cast<Number*>(message)->value, buffer.data(), sizeof(std::int64_t));
          return true;
        },
};

const MessageType kOther{
    .name = "test_msgs/msg/Other",
    .dds_name = "test_msgs::msg::dds_::Other_",
    .create = kNumber.create,
    .serialized_size = kNumber.serialized_size,
    .serialize = kNumber.serialize,
    .deserialize = kNumber.deserialize,
};

inline const WireTopic kTopic{"rt/number", &kNumber};

inline std::shared_ptr<const Number> number(std::int64_t value) {
  return std::make_shared<const Number>(value);
}

/// A process of its own: context, executor, and what its subscriptions received.
struct Process {
  explicit Process(std::unique_ptr<Transport> transport = nullptr)
      : context(Context::create(std::move(transport))) {}

  std::shared_ptr<UntypedPublisher> publisher(const QoS& qos, PublisherEvents events = {}) const {
    return context->create_publisher(
        {.topic = kTopic, .qos = qos, .events = std::move(events), .group = group});
  }
  std::shared_ptr<UntypedSubscription> subscription(const QoS& qos,
                                                    SubscriptionEvents events = {}) {
    return context->create_subscription(
        {.topic = kTopic,
         .qos = qos,
         .callback =
             [this](const std::shared_ptr<const void>& message, const MessageInfo& info) {
               received.push_back(static_cast<const Number*>(message.get())->value);
               last_message = message;
               last_info = info;
             },
         .events = std::move(events),
         .group = group});
  }
  std::vector<std::int64_t> spin() {
    received.clear();
    executor.spin_ready();
    return received;
  }

  Executor executor;
  std::shared_ptr<CallbackGroup> group = executor.create_callback_group();
  std::shared_ptr<Context> context;
  std::vector<std::int64_t> received;
  std::shared_ptr<const void> last_message;
  MessageInfo last_info;
};

}  // namespace pipescout
