// SPDX-License-Identifier: Apache-2.0
#include "recording_queue.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace pipescout {
namespace {

/// After the last message, until all is with the operating system: a kill costs no more than that.
constexpr std::chrono::milliseconds kFlushAfter{100};
/// Of the writing thread: half as much as it may be lowered.
constexpr int kNiceness = 10;

}  // namespace

RecordingQueue::RecordingQueue(std::unique_ptr<bags::BagWriter> writer, const Options& options,
                               Events events)
    : options_(options), events_(std::move(events)), writer_(std::move(writer)) {
  thread_ = std::thread([this] { run(); });
}

RecordingQueue::~RecordingQueue() {
  finish();
}

bags::TopicIndex RecordingQueue::add_topic(bags::BagTopic topic) {
  const std::lock_guard lock(mutex_);
  topics_.push_back(std::move(topic));
  work_.notify_one();
  return static_cast<bags::TopicIndex>(topics_.size() - 1);
}

bool RecordingQueue::has_room_for(const Item& item) const {
  return bytes_ == 0 || bytes_ + item.size() <= options_.limit;
}

void RecordingQueue::append(Item item) {
  if (options_.snapshot) {
    keep(std::move(item));
    return;
  }
  bytes_ += item.size();
  waiting_.push_back(std::move(item));
  work_.notify_one();
}

void RecordingQueue::keep(Item item) {
  while (!kept_.empty() && kept_bytes_ + item.size() > options_.limit) {
    kept_bytes_ -= kept_.front().size();
    kept_.pop_front();
  }
  kept_bytes_ += item.size();
  kept_.push_back(std::move(item));
}

void RecordingQueue::give_time_to_early(std::int64_t log_time) {
  has_time_ = true;
  for (Item& item : std::exchange(early_, {})) {
    bytes_ -= item.size();
    item.log_time = log_time;
    if (item.publish_time == 0) {
      item.publish_time = log_time;
    }
    append(std::move(item));
  }
}

bool RecordingQueue::push(bags::TopicIndex topic, std::int64_t log_time, std::int64_t publish_time,
                          std::shared_ptr<const SerializedMessage> message) {
  Item item{topic, log_time, publish_time, std::move(message)};
  std::unique_lock lock(mutex_);
  if (options_.repeatable) {
    room_.wait(lock, [&] { return has_room_for(item) || failed_ || ending_; });
  }
  if (ending_ || failed_) {
    counts_.lost += failed_ ? 1U : 0U;
    return true;  // nobody records any more; not for want of room
  }
  if (!options_.snapshot && !has_room_for(item)) {
    ++counts_.dropped;
    return false;
  }
  if (log_time == 0 && !has_time_) {
    bytes_ += item.size();
    early_.push_back(std::move(item));
    return true;
  }
  if (!has_time_) {
    give_time_to_early(log_time);
  }
  append(std::move(item));
  return true;
}

bool RecordingQueue::take_snapshot() {
  if (!options_.snapshot) {
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (bytes_ > 0) {
    return false;
  }
  waiting_ = std::exchange(kept_, {});
  bytes_ = std::exchange(kept_bytes_, 0);
  work_.notify_one();
  return true;
}

void RecordingQueue::finish() {
  {
    const std::lock_guard lock(mutex_);
    if (!has_time_) {
      give_time_to_early(0);
    }
    ending_ = true;
    work_.notify_one();
    room_.notify_all();
  }
  if (thread_.joinable()) {
    thread_.join();
  }
}

RecordingQueue::Counts RecordingQueue::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::string RecordingQueue::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

bool RecordingQueue::guarded(const std::function<void()>& step) {
  {
    const std::lock_guard lock(mutex_);
    if (failed_) {
      return false;
    }
  }
  std::string why;
  try {
    step();
    return true;
  } catch (const std::exception& error) {
    why = error.what();
  }
  {
    const std::lock_guard lock(mutex_);
    failed_ = true;
    counts_.lost += waiting_.size() + early_.size();
    waiting_.clear();
    kept_.clear();
    early_.clear();
    bytes_ = kept_bytes_ = 0;
    room_.notify_all();
  }
  try {
    writer_->close();
  } catch (const std::exception& error) {
    if (error.what() != why) {
      why += std::string("; and then ") + error.what();
    }
  }
  {
    const std::lock_guard lock(mutex_);
    const std::uint64_t given = counts_.written;
    counts_.written = std::min(given, writer_->metadata().messages);
    counts_.lost += given - counts_.written;
    error_ = why;
  }
  events_.failed(why);
  return false;
}

void RecordingQueue::add_new_topics() {
  std::vector<bags::BagTopic> added;
  {
    const std::lock_guard lock(mutex_);
    added.assign(topics_.begin() + static_cast<std::ptrdiff_t>(indices_.size()), topics_.end());
  }
  for (const auto& topic : added) {
    guarded([&] { indices_.push_back(writer_->add_topic(topic)); });
  }
}

void RecordingQueue::write(const Item& item) {
  const bool written = guarded([&] {
    writer_->write({.topic = indices_.at(item.topic),
                    .log_time = item.log_time,
                    .publish_time = item.publish_time,
                    .data = item.message->bytes()});
  });
  {
    const std::lock_guard lock(mutex_);
    if (written) {
      bytes_ -= item.size();
      ++counts_.written;
      counts_.bytes += item.size();
      room_.notify_all();
    } else {
      ++counts_.lost;
    }
  }
  const auto& files = writer_->metadata().files;
  if (written && files.size() > files_) {
    if (files_ > 0) {
      events_.split(writer_->folder() / files[files.size() - 2].path,
                    writer_->folder() / files.back().path);
    }
    files_ = files.size();
  }
}

void RecordingQueue::run() {
  if (!options_.repeatable) {
    // Where cores are short, those who publish and receive go first; the cache bridges the delay.
    // On Linux the niceness is the thread's own, and lowering it is always permitted.
    setpriority(PRIO_PROCESS, 0, kNiceness);
  }
  const auto has_work = [this] {
    return ending_ || !waiting_.empty() || (topics_.size() > indices_.size() && !failed_);
  };
  bool flushed = true;
  std::unique_lock lock(mutex_);
  for (;;) {
    if (flushed) {
      work_.wait(lock, has_work);
    } else if (!work_.wait_for(lock, kFlushAfter, has_work)) {
      lock.unlock();
      guarded([this] { writer_->flush(); });
      lock.lock();
      flushed = true;
      continue;
    }
    const auto batch = std::exchange(waiting_, {});
    const bool last = ending_ && batch.empty();
    lock.unlock();
    // The topics of a batch were added before it was taken.
    add_new_topics();
    if (last) {
      guarded([this] { writer_->close(); });
      return;
    }
    for (const Item& item : batch) {
      write(item);
    }
    flushed = options_.repeatable;
    lock.lock();
  }
}

}  // namespace pipescout
