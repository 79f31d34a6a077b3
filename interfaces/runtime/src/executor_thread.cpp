// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/executor_thread.hpp"

#include <exception>
#include <utility>

namespace pipescout {

ExecutorThread::ExecutorThread(Executor& executor, Callbacks callbacks)
    : executor_(executor), thread_([this, callbacks = std::move(callbacks)] { run(callbacks); }) {}

ExecutorThread::~ExecutorThread() {
  executor_.stop();
  thread_.join();
}

std::string ExecutorThread::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void ExecutorThread::run(const Callbacks& callbacks) {
  if (callbacks.before) {
    callbacks.before();
  }
  try {
    executor_.spin();
    return;
  } catch (const std::exception& error) {
    keep(error.what());
  } catch (...) {
    keep("an exception of unknown type");
  }
  if (callbacks.on_failure) {
    callbacks.on_failure();
  }
}

void ExecutorThread::keep(const char* what) {
  {
    const std::lock_guard lock(mutex_);
    failure_ = std::string("a callback of the process failed: ") + what;
  }
  failed_ = true;
}

}  // namespace pipescout
