// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/runtime/serialized_message.hpp"

namespace pipescout {

/// Between those who publish and the bag: a queue bounded in bytes, and the one thread of the
/// recorder, which writes. A component has no threads as a rule; this one has, since a write may
/// take as long as the disk likes, and a publisher that is recorded must not wait for it.
/// Thread-safe.
class RecordingQueue {
 public:
  struct Options {
    /// Bytes of the messages that wait, and as many of those that are kept for a snapshot; one
    /// message is taken however large it is.
    std::uint64_t limit = 100 * 1024 * 1024;
    /// Keep the last `limit` bytes, and write them only when `take_snapshot` asks for it.
    bool snapshot = false;
    /// A full queue makes the publisher wait, and nothing is written because of the time: for
    /// missions in simulated time, which must not depend on machine and disk. The same messages
    /// then give the same bytes.
    bool repeatable = false;
  };
  /// Called on the writing thread; must not call back.
  struct Events {
    /// The bag went on in another file.
    std::function<void(const std::filesystem::path& closed, const std::filesystem::path& opened)>
        split;
    /// The recording has ended early; the bag is closed, as far as that was possible.
    std::function<void(const std::string& why)> failed;
  };
  struct Counts {
    std::uint64_t written = 0;  ///< messages; after `finish`, and after an error, those in the bag
    std::uint64_t bytes = 0;    ///< of the messages that were given to the bag's writer
    std::uint64_t dropped = 0;  ///< messages that met a full queue
    std::uint64_t lost = 0;     ///< messages that are not in the bag because of an error
  };

  RecordingQueue(std::unique_ptr<bags::BagWriter> writer, const Options& options, Events events);
  RecordingQueue(const RecordingQueue&) = delete;
  RecordingQueue& operator=(const RecordingQueue&) = delete;
  /// As `finish`.
  ~RecordingQueue();

  /// A topic of its own for `push`; names must differ.
  [[nodiscard]] bags::TopicIndex add_topic(bags::BagTopic topic);
  /// False when the queue is full and the message dropped. `log_time` in ns; a message of time zero
  /// was received before there was any time, and gets that of the first one that has a time.
  bool push(bags::TopicIndex topic, std::int64_t log_time, std::int64_t publish_time,
            std::shared_ptr<const SerializedMessage> message);
  /// What is kept is to be written. False without `Options::snapshot`, and while the snapshot
  /// before is still being written.
  bool take_snapshot();
  /// Writes what waits and closes the bag; nothing is taken any more.
  void finish();

  [[nodiscard]] Counts counts() const;
  /// Why the recording has ended early; empty: it has not.
  [[nodiscard]] std::string error() const;

 private:
  struct Item {
    bags::TopicIndex topic = 0;
    std::int64_t log_time = 0;
    std::int64_t publish_time = 0;
    std::shared_ptr<const SerializedMessage> message;

    [[nodiscard]] std::uint64_t size() const { return message->bytes().size(); }
  };

  // Under mutex_.
  [[nodiscard]] bool has_room_for(const Item& item) const;
  void append(Item item);
  void keep(Item item);
  void give_time_to_early(std::int64_t log_time);

  void run();
  void write(const Item& item);
  void add_new_topics();
  /// Runs what may fail; false when it did, now or before.
  bool guarded(const std::function<void()>& step);

  const Options options_;
  const Events events_;

  mutable std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable room_;
  std::deque<Item> waiting_;  // for the thread
  std::deque<Item> kept_;     // for a snapshot
  std::vector<Item> early_;   // from before there was a time
  std::uint64_t bytes_ = 0;   // of what waits, is early, or was just taken by the thread
  std::uint64_t kept_bytes_ = 0;
  std::vector<bags::BagTopic> topics_;
  Counts counts_;
  std::string error_;
  bool has_time_ = false;
  bool ending_ = false;
  bool failed_ = false;

  // The thread's own.
  std::unique_ptr<bags::BagWriter> writer_;
  std::vector<bags::TopicIndex> indices_;
  std::size_t files_ = 0;

  std::thread thread_;
};

}  // namespace pipescout
