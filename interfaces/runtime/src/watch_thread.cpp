// SPDX-License-Identifier: Apache-2.0
#include "watch_thread.hpp"

namespace pipescout {

WatchThread::~WatchThread() {
  if (thread_.joinable()) {
    executor_.stop();
    thread_.join();
  }
}

std::shared_ptr<CallbackGroup> WatchThread::create_group() {
  std::call_once(started_, [this] { thread_ = std::thread([this] { executor_.spin(); }); });
  return executor_.create_callback_group();
}

}  // namespace pipescout
