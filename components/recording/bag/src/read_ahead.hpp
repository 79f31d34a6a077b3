// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/runtime/serialized_message.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// A message of a bag.
struct BagItem {
  bags::TopicIndex topic = 0;
  Time stamp{};  ///< log time
  std::shared_ptr<const SerializedMessage> message;
};

/// The next messages of a bag, read by a thread of its own: reading may take as long as the disk
/// likes, and a callback must not wait for it. The functions are for one thread.
class ReadAhead {
 public:
  /// `depth`: messages that wait at most; together they have no more than 256 MiB, but for a single
  /// one. `news` is called on the reading thread when there is something, or an end, after `next`
  /// had nothing to give; it must not call back.
  ReadAhead(std::unique_ptr<bags::BagReader> reader, std::size_t depth, std::function<void()> news);
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;
  ~ReadAhead();

  /// The next message, which stays until `pop`. Null: none yet, or at the end.
  [[nodiscard]] const BagItem* next();
  void pop();
  /// Nothing is left, nor will be.
  [[nodiscard]] bool at_end() const;
  /// Goes on with the first message at or after that time.
  void seek(Time time);
  /// What could not be read of the bag; empty so far.
  [[nodiscard]] std::string error() const;

 private:
  void run();

  const std::unique_ptr<bags::BagReader> reader_;  // the thread's own
  const std::size_t depth_;
  const std::function<void()> news_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<BagItem> items_;
  std::uint64_t bytes_ = 0;
  std::optional<Time> seek_;
  bool is_asked_ = false;  // somebody waits for news
  bool at_end_ = false;    // of what the reader has
  bool ending_ = false;
  std::string error_;
  std::optional<BagItem> front_;  // what `next` gave; without the lock

  std::thread thread_;
};

}  // namespace pipescout
