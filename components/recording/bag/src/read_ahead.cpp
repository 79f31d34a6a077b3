// SPDX-License-Identifier: Apache-2.0
#include "read_ahead.hpp"

#include <exception>
#include <utility>

namespace pipescout {
namespace {

constexpr std::uint64_t kMaximumBytes = 256 * 1024 * 1024;

}  // namespace

ReadAhead::ReadAhead(std::unique_ptr<bags::BagReader> reader, std::size_t depth,
                     std::function<void()> news)
    : reader_(std::move(reader)), depth_(depth), news_(std::move(news)) {
  thread_ = std::thread([this] { run(); });
}

ReadAhead::~ReadAhead() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    changed_.notify_one();
  }
  thread_.join();
}

const BagItem* ReadAhead::next() {
  if (!front_) {
    const std::lock_guard lock(mutex_);
    if (items_.empty()) {
      is_asked_ = !at_end_;
      return nullptr;
    }
    front_ = std::move(items_.front());
    items_.pop_front();
    bytes_ -= front_->message->bytes().size();
    changed_.notify_one();
  }
  return &*front_;
}

void ReadAhead::pop() {
  front_.reset();
}

bool ReadAhead::at_end() const {
  const std::lock_guard lock(mutex_);
  return !front_ && items_.empty() && at_end_;
}

void ReadAhead::seek(Time time) {
  front_.reset();
  const std::lock_guard lock(mutex_);
  items_.clear();
  bytes_ = 0;
  at_end_ = false;
  seek_ = time;
  changed_.notify_one();
}

std::string ReadAhead::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void ReadAhead::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] {
      return ending_ || seek_ ||
             (!at_end_ && items_.size() < depth_ && (items_.empty() || bytes_ < kMaximumBytes));
    });
    if (ending_) {
      return;
    }
    const auto seek = std::exchange(seek_, std::nullopt);
    lock.unlock();
    std::optional<BagItem> item;
    std::string error;
    try {
      if (seek) {
        reader_->seek(seek->time_since_epoch().count());
      }
      if (const auto read = reader_->next()) {
        item = BagItem{read->topic, Time(Duration(read->log_time)),
                       std::make_shared<const SerializedMessage>(read->data)};
      }
    } catch (const std::exception& exception) {
      error = exception.what();
    }
    lock.lock();
    if (!error.empty()) {
      error_ = std::move(error);
    }
    if (seek_) {
      continue;  // what was read belongs to where nobody is any more
    }
    if (item) {
      bytes_ += item->message->bytes().size();
      items_.push_back(std::move(*item));
    } else {
      at_end_ = true;
    }
    if (std::exchange(is_asked_, false)) {
      lock.unlock();
      news_();
      lock.lock();
    }
  }
}

}  // namespace pipescout
