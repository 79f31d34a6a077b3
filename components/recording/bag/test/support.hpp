// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <std_msgs/msg/string.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/runtime/serialized_message.hpp"

/// What the tests of recorder and player share.
namespace pipescout::bag_test {

inline std_msgs::msg::String text_message(const std::string& text) {
  std_msgs::msg::String message;
  message.data = text;
  return message;
}

inline std::shared_ptr<const SerializedMessage> text_bytes(const std::string& text) {
  const auto message = text_message(text);
  return serialize(message_type<std_msgs::msg::String>(), &message);
}

inline std::optional<std::string> text_of(std::span<const std::byte> bytes) {
  const auto message = deserialize(message_type<std_msgs::msg::String>(), bytes);
  if (!message) {
    return std::nullopt;
  }
  return static_cast<const std_msgs::msg::String*>(message.get())->data;
}

/// A message of a bag, copied.
struct Recorded {
  std::string topic;
  std::int64_t log_time = 0;
  std::int64_t publish_time = 0;
  std::vector<std::byte> bytes;

  [[nodiscard]] std::string text() const { return text_of(bytes).value_or("no text"); }
};

struct WholeBag {
  std::vector<bags::BagTopic> topics;
  std::vector<Recorded> messages;

  [[nodiscard]] const bags::BagTopic* topic(const std::string& name) const {
    for (const auto& topic : topics) {
      if (topic.name == name) {
        return &topic;
      }
    }
    return nullptr;
  }
  [[nodiscard]] std::vector<Recorded> of(const std::string& topic) const {
    std::vector<Recorded> found;
    for (const auto& message : messages) {
      if (message.topic == topic) {
        found.push_back(message);
      }
    }
    return found;
  }
  [[nodiscard]] std::vector<std::string> texts(const std::string& topic) const {
    std::vector<std::string> texts;
    for (const auto& message : messages) {
      if (message.topic == topic) {
        texts.push_back(message.text());
      }
    }
    return texts;
  }
};

inline WholeBag read_bag(const std::filesystem::path& folder) {
  bags::BagReader reader(folder);
  WholeBag bag{.topics = reader.topics()};
  while (const auto message = reader.next()) {
    bag.messages.push_back({bag.topics.at(message->topic).name,
                            message->log_time,
                            message->publish_time,
                            {message->data.begin(), message->data.end()}});
  }
  return bag;
}

/// A topic, a time in ms and a text.
struct Line {
  std::string topic;
  std::int64_t time = 0;
  std::string text;
};

inline void write_bag(const std::filesystem::path& folder, const std::vector<Line>& lines,
                      const std::string& type = "std_msgs/msg/String") {
  bags::BagWriter writer(folder);
  for (const Line& line : lines) {
    const auto topic = writer.add_topic(make_bag_topic(line.topic, type, {}));
    const auto bytes = text_bytes(line.text);
    constexpr std::int64_t kNanosecondsInMillisecond = 1'000'000;
    const auto time = line.time * kNanosecondsInMillisecond;
    writer.write({topic, time, time, bytes->bytes()});
  }
  writer.close();
}

/// Files of this process can become no larger while it lives, as if the disk were full.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace pipescout::bag_test
