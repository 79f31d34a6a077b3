// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"

/// What the tests of the DDS transport share.
namespace pipescout::dds_test {

constexpr auto kGenerous = std::chrono::seconds(30);

/// Waits for what other threads change; they call `change`.
class Monitor {
 public:
  template <class Change>
  void change(Change&& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    changed_.notify_all();
  }
  template <class Value>
  [[nodiscard]] Value copy(const Value& value) {
    const std::lock_guard lock(mutex_);
    return value;
  }
  /// False when the condition does not come true in a generous time.
  template <class Condition>
  [[nodiscard]] bool await(Condition&& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kGenerous, condition);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
};

struct ReceivedMessage {
  std::shared_ptr<const void> message;
  MessageInfo info;
};

struct ReaderRecord : TransportReaderListener {
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override {
    monitor.change([&] { messages.push_back({std::move(message), info}); });
  }
  void on_malformed_sample(const SampleIdentity&) override {
    monitor.change([&] { ++malformed; });
  }
  void on_overwritten_sample(const SampleIdentity&) override { on_samples_lost(1); }
  void on_samples_lost(int count) override {
    monitor.change([&] { lost += count; });
  }
  void on_remote_writers_changed(int matched) override {
    monitor.change([&] { matches.push_back(matched); });
  }
  void on_incompatible_remote_writer(QosPolicy policy) override {
    monitor.change([&] { incompatible.push_back(policy); });
  }
  void on_remote_liveliness_changed(LivelinessChange now) override {
    monitor.change([&] { liveliness.push_back(now); });
  }

  [[nodiscard]] bool await_messages(std::size_t count) {
    return monitor.await([&] { return messages.size() >= count; });
  }
  [[nodiscard]] bool await_matched(int count) {
    return monitor.await([&] { return !matches.empty() && matches.back() == count; });
  }
  [[nodiscard]] bool await_liveliness(int alive, int not_alive) {
    return monitor.await([&] {
      return !liveliness.empty() && liveliness.back().alive == alive &&
             liveliness.back().not_alive == not_alive;
    });
  }
  [[nodiscard]] ReceivedMessage message(std::size_t index) {
    return monitor.copy(messages).at(index);
  }
  [[nodiscard]] std::string text(std::size_t index) {
    return static_cast<const std_msgs::msg::String*>(message(index).message.get())->data;
  }

  Monitor monitor;
  std::vector<ReceivedMessage> messages;
  int malformed = 0;
  int lost = 0;
  std::vector<int> matches;
  std::vector<QosPolicy> incompatible;
  std::vector<LivelinessChange> liveliness;
};

struct WriterRecord : TransportWriterListener {
  void on_remote_readers_changed(int matched, const std::vector<Gid>&) override {
    monitor.change([&] { matches.push_back(matched); });
  }
  void on_incompatible_remote_reader(QosPolicy policy) override {
    monitor.change([&] { incompatible.push_back(policy); });
  }

  [[nodiscard]] bool await_matched(int count) {
    return monitor.await([&] { return !matches.empty() && matches.back() == count; });
  }

  Monitor monitor;
  std::vector<int> matches;
  std::vector<QosPolicy> incompatible;
};

inline std_msgs::msg::String make_text(const std::string& text) {
  std_msgs::msg::String message;
  message.data = text;
  return message;
}

/// A topic that no other process tests on at the same time.
inline WireTopic text_topic(const std::string& name, int process = getpid()) {
  return {"rt/" + name + "_" + std::to_string(process), &message_type<std_msgs::msg::String>()};
}

inline DdsOptions local_options() {
  DdsOptions options;
  options.domain_id = 100 + static_cast<std::uint32_t>(getpid()) % 100;
  options.localhost_only = true;
  options.shared_memory_segment_bytes = std::size_t{4} * 1024 * 1024;
  return options;
}

}  // namespace pipescout::dds_test
