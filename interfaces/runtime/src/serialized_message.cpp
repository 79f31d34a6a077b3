// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/serialized_message.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "pipescout/runtime/names.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kEncapsulationBytes = 4;

std::shared_ptr<void> create() {
  return std::make_shared<SerializedMessage>();
}

std::span<const std::byte> bytes_of(const void* message) {
  return static_cast<const SerializedMessage*>(message)->bytes();
}

/// Names and the type that refers to them.
struct NamedType {
  std::string name;
  std::string dds_name;
  MessageType type;
};

}  // namespace

SerializedMessage::SerializedMessage(std::span<const std::byte> bytes)
    : SerializedMessage(bytes.size()) {
  std::copy(bytes.begin(), bytes.end(), bytes_.get());
}

const MessageType& serialized_type(std::string_view name) {
  // Never destroyed: endpoints of static objects may refer to it.
  static auto& types = *new std::map<std::string, NamedType, std::less<>>;
  static auto& mutex = *new std::mutex;
  const std::lock_guard lock(mutex);
  if (const auto known = types.find(name); known != types.end()) {
    return known->second.type;
  }
  auto dds_name = mangle_type_name(name);
  NamedType& named =
      types.try_emplace(std::string(name), NamedType{std::string(name), std::move(dds_name), {}})
          .first->second;
  named.type = {.name = named.name,
                .dds_name = named.dds_name,
                .create = create,
                .serialized_size = [](const void* message) { return bytes_of(message).size(); },
                .serialize = [](const void* message, std::span<std::byte> buffer) -> std::size_t {
                  const auto bytes = bytes_of(message);
                  if (bytes.size() < kEncapsulationBytes || bytes.size() > buffer.size()) {
                    return 0;
                  }
                  std::copy(bytes.begin(), bytes.end(), buffer.begin());
                  return bytes.size();
                },
                .deserialize =
                    [](std::span<const std::byte> buffer, void* message) {
                      if (buffer.size() < kEncapsulationBytes) {
                        return false;
                      }
                      *static_cast<SerializedMessage*>(message) = SerializedMessage(buffer);
                      return true;
                    }};
  return named.type;
}

bool is_serialized(const MessageType& type) noexcept {
  return type.create == create;
}

std::shared_ptr<const SerializedMessage> serialize(const MessageType& type, const void* message) {
  auto serialized = std::make_shared<SerializedMessage>(type.serialized_size(message));
  const std::size_t written = type.serialize(message, serialized->bytes());
  return written == serialized->bytes().size() && written > 0 ? std::move(serialized) : nullptr;
}

std::shared_ptr<const void> deserialize(const MessageType& type, std::span<const std::byte> bytes) {
  auto message = type.create();
  return type.deserialize(bytes, message.get()) ? std::move(message) : nullptr;
}

}  // namespace pipescout
