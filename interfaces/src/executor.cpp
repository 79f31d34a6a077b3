// SPDX-License-Identifier: Apache-2.0
#include "pipescout/interfaces/executor.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pipescout {

namespace {

class PostedFunction final : public Waitable {
 public:
  explicit PostedFunction(std::function<void()> function) : function_(std::move(function)) {}
  void execute() override { function_(); }

 private:
  std::function<void()> function_;
};

SteadyTime steady_now() {
  return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now());
}

}  // namespace

/// State shared by the executor and its groups, so that a group may outlive the executor.
class Executor::Core : public std::enable_shared_from_this<Executor::Core> {
 public:
  class Group;
  struct Work {
    std::shared_ptr<Group> group;
    std::shared_ptr<Waitable> waitable;
  };
  enum class Wait { kNo, kUntilStopped };

  explicit Core(std::size_t threads) : threads_(threads) {}

  void schedule(const std::shared_ptr<Group>& group, std::shared_ptr<Waitable> waitable);
  void schedule_at(const std::shared_ptr<Group>& group, SteadyTime when,
                   const std::shared_ptr<Waitable>& waitable);
  void cancel(const Waitable* waitable);
  void close(Group& group);

  void stop();
  void end_spin();
  /// Runs one callback; waits for one until `until` if asked. False when there was none.
  bool run_one(Wait wait, const SteadyTime* until);
  void work_until_stopped();
  void fail(std::exception_ptr error);
  std::exception_ptr take_failure();

  const std::size_t threads_;

 private:
  struct Timed {
    std::weak_ptr<Group> group;
    std::weak_ptr<Waitable> waitable;
    const Waitable* key;
  };
  using Timeline = std::multimap<SteadyTime, Timed>;

  bool make_ready(Work work);  // under mutex_; true when a worker should be woken
  void promote_due_timers();   // under mutex_
  void finish(Group& group);   // under mutex_

  std::mutex mutex_;
  std::condition_variable work_available_;
  std::condition_variable group_idle_;
  std::deque<Work> ready_;
  Timeline timeline_;
  std::unordered_map<const Waitable*, Timeline::iterator> timed_;
  std::size_t waiting_ = 0;
  bool timer_watched_ = false;  // one waiting worker watches the timeline, the others just wait
  bool stopped_ = false;
  std::exception_ptr failure_;

  friend class Group;
};

class Executor::Core::Group final : public CallbackGroup,
                                    public std::enable_shared_from_this<Executor::Core::Group> {
 public:
  Group(std::weak_ptr<Core> core, CallbackGroupType type) : core_(std::move(core)), type_(type) {}

  CallbackGroupType type() const noexcept override { return type_; }

  void set_exception_handler(ExceptionHandler handler) override {
    const std::lock_guard lock(handler_mutex_);
    handler_ = std::move(handler);
  }

  void schedule(std::shared_ptr<Waitable> waitable) override {
    if (const auto core = core_.lock()) {
      core->schedule(shared_from_this(), std::move(waitable));
    }
  }

  void post(std::function<void()> function) override {
    schedule(std::make_shared<PostedFunction>(std::move(function)));
  }

  void schedule_at(SteadyTime when, const std::shared_ptr<Waitable>& waitable) override {
    if (const auto core = core_.lock()) {
      core->schedule_at(shared_from_this(), when, waitable);
    }
  }

  void cancel(const std::shared_ptr<Waitable>& waitable) override {
    if (const auto core = core_.lock()) {
      core->cancel(waitable.get());
    }
  }

  void close() override {
    if (const auto core = core_.lock()) {
      core->close(*this);
    }
  }

  ExceptionHandler handler() {
    const std::lock_guard lock(handler_mutex_);
    return handler_;
  }

  const std::weak_ptr<Core> core_;
  const CallbackGroupType type_;

  // Guarded by the core's mutex.
  std::vector<std::thread::id> running_;
  std::deque<std::shared_ptr<Waitable>> parked_;  // exclusive group: waits for the running callback
  bool queued_ = false;                           // exclusive group: it has an entry in `ready_`
  bool closed_ = false;

 private:
  std::mutex handler_mutex_;
  ExceptionHandler handler_;
};

bool Executor::Core::make_ready(Work work) {
  if (work.group->type_ == CallbackGroupType::kMutuallyExclusive) {
    if (work.group->queued_ || !work.group->running_.empty()) {
      work.group->parked_.push_back(std::move(work.waitable));
      return false;
    }
    work.group->queued_ = true;
  }
  ready_.push_back(std::move(work));
  return waiting_ > 0;
}

void Executor::Core::schedule(const std::shared_ptr<Group>& group,
                              std::shared_ptr<Waitable> waitable) {
  bool wake = false;
  {
    const std::lock_guard lock(mutex_);
    if (group->closed_) {
      return;
    }
    wake = make_ready({group, std::move(waitable)});
  }
  if (wake) {
    work_available_.notify_one();
  }
}

void Executor::Core::schedule_at(const std::shared_ptr<Group>& group, SteadyTime when,
                                 const std::shared_ptr<Waitable>& waitable) {
  bool earliest = false;
  {
    const std::lock_guard lock(mutex_);
    if (group->closed_) {
      return;
    }
    if (const auto found = timed_.find(waitable.get()); found != timed_.end()) {
      timeline_.erase(found->second);
      timed_.erase(found);
    }
    const auto position = timeline_.emplace(when, Timed{group, waitable, waitable.get()});
    timed_.emplace(waitable.get(), position);
    earliest = position == timeline_.begin() && waiting_ > 0;
  }
  if (earliest) {
    // Whoever watches the timeline must look again, and it is not known which worker that is.
    work_available_.notify_all();
  }
}

void Executor::Core::cancel(const Waitable* waitable) {
  const std::lock_guard lock(mutex_);
  if (const auto found = timed_.find(waitable); found != timed_.end()) {
    timeline_.erase(found->second);
    timed_.erase(found);
  }
}

void Executor::Core::promote_due_timers() {
  const SteadyTime now = steady_now();
  while (!timeline_.empty() && timeline_.begin()->first <= now) {
    const auto first = timeline_.begin();
    Timed timed = std::move(first->second);
    timed_.erase(timed.key);
    timeline_.erase(first);
    auto group = timed.group.lock();
    if (!group || group->closed_) {
      continue;
    }
    if (auto waitable = timed.waitable.lock()) {
      make_ready({std::move(group), std::move(waitable)});
    }
  }
}

void Executor::Core::finish(Group& group) {
  const auto self =
      std::find(group.running_.begin(), group.running_.end(), std::this_thread::get_id());
  group.running_.erase(self);
  if (group.closed_) {
    if (group.running_.empty()) {
      group_idle_.notify_all();
    }
  } else if (group.type_ == CallbackGroupType::kMutuallyExclusive && !group.parked_.empty()) {
    auto next = std::move(group.parked_.front());
    group.parked_.pop_front();
    group.queued_ = true;
    ready_.push_back({group.shared_from_this(), std::move(next)});
    if (waiting_ > 0) {
      work_available_.notify_one();
    }
  }
}

void Executor::Core::close(Group& group) {
  // Destroyed after the lock is released: a waitable's destructor may run anything.
  std::deque<std::shared_ptr<Waitable>> dropped_parked;
  std::vector<Work> dropped_ready;
  std::unique_lock lock(mutex_);
  group.closed_ = true;
  dropped_parked.swap(group.parked_);
  for (auto& work : ready_) {
    if (work.group.get() == &group) {
      dropped_ready.push_back(std::move(work));
    }
  }
  std::erase_if(ready_, [](const Work& work) { return work.group == nullptr; });
  group.queued_ = false;
  for (auto entry = timed_.begin(); entry != timed_.end();) {
    const auto owner = entry->second->second.group.lock();
    if (owner == nullptr || owner.get() == &group) {
      timeline_.erase(entry->second);
      entry = timed_.erase(entry);
    } else {
      ++entry;
    }
  }
  const auto self = std::this_thread::get_id();
  group_idle_.wait(lock, [&] {
    return std::all_of(group.running_.begin(), group.running_.end(),
                       [&](std::thread::id id) { return id == self; });
  });
}

void Executor::Core::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  work_available_.notify_all();
}

void Executor::Core::end_spin() {
  const std::lock_guard lock(mutex_);
  stopped_ = false;
}

bool Executor::Core::run_one(Wait wait, const SteadyTime* until) {
  Work work;
  {
    std::unique_lock lock(mutex_);
    while (true) {
      if (stopped_ && wait != Wait::kNo) {
        return false;
      }
      promote_due_timers();
      if (!ready_.empty()) {
        break;
      }
      if (wait == Wait::kNo) {
        return false;
      }
      if (until != nullptr && steady_now() >= *until) {
        return false;
      }
      ++waiting_;
      const bool watch_timers = !timer_watched_ && !timeline_.empty();
      if (watch_timers || until != nullptr) {
        SteadyTime deadline = until != nullptr ? *until : timeline_.begin()->first;
        if (watch_timers) {
          deadline = std::min(deadline, timeline_.begin()->first);
          timer_watched_ = true;
        }
        work_available_.wait_until(lock, deadline);
        if (watch_timers) {
          timer_watched_ = false;
        }
      } else {
        work_available_.wait(lock);
      }
      --waiting_;
    }
    work = std::move(ready_.front());
    ready_.pop_front();
    work.group->queued_ = false;
    work.group->running_.push_back(std::this_thread::get_id());
    // The timeline needs a watcher, and further work a worker, while this thread is busy.
    if (waiting_ > 0 && (!ready_.empty() || (!timer_watched_ && !timeline_.empty()))) {
      work_available_.notify_one();
    }
  }
  std::exception_ptr error;
  try {
    work.waitable->execute();
  } catch (...) {
    error = std::current_exception();
  }
  if (error) {
    if (const auto handler = work.group->handler()) {
      try {
        handler(error);
        error = nullptr;
      } catch (...) {
        error = std::current_exception();
      }
    }
  }
  work.waitable.reset();
  {
    const std::lock_guard lock(mutex_);
    finish(*work.group);
  }
  if (error) {
    std::rethrow_exception(error);
  }
  return true;
}

void Executor::Core::work_until_stopped() {
  try {
    while (run_one(Wait::kUntilStopped, nullptr)) {
    }
  } catch (...) {
    fail(std::current_exception());
  }
}

void Executor::Core::fail(std::exception_ptr error) {
  {
    const std::lock_guard lock(mutex_);
    if (!failure_) {
      failure_ = std::move(error);
    }
    stopped_ = true;
  }
  work_available_.notify_all();
}

std::exception_ptr Executor::Core::take_failure() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failure_, nullptr);
}

Executor::Executor(std::size_t threads) {
  if (threads == 0 || threads > 256) {
    throw std::invalid_argument("Executor: threads = " + std::to_string(threads) +
                                " is not in [1, 256]");
  }
  core_ = std::make_shared<Core>(threads);
}

Executor::~Executor() {
  stop();
}

std::shared_ptr<CallbackGroup> Executor::create_callback_group(CallbackGroupType type) {
  return std::make_shared<Core::Group>(core_, type);
}

void Executor::spin() {
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < core_->threads_; ++i) {
    others.emplace_back([core = core_] { core->work_until_stopped(); });
  }
  core_->work_until_stopped();
  for (auto& thread : others) {
    thread.join();
  }
  core_->end_spin();
  if (const auto failure = core_->take_failure()) {
    std::rethrow_exception(failure);
  }
}

std::size_t Executor::spin_ready() {
  std::size_t ran = 0;
  while (core_->run_one(Core::Wait::kNo, nullptr)) {
    ++ran;
  }
  return ran;
}

bool Executor::spin_until(const std::function<bool()>& done, Duration timeout) {
  const SteadyTime until = steady_now() + timeout;
  bool satisfied = done();
  while (!satisfied && core_->run_one(Core::Wait::kUntilStopped, &until)) {
    satisfied = done();
  }
  core_->end_spin();
  return satisfied;
}

void Executor::stop() {
  core_->stop();
}

std::size_t Executor::threads() const noexcept {
  return core_->threads_;
}

}  // namespace pipescout
