// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/executor.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "pipescout/runtime/activity.hpp"

namespace pipescout {

namespace {

class PostedFunction final : public Waitable {
 public:
  explicit PostedFunction(std::function<void()> function) : function_(std::move(function)) {}
  void execute() override { function_(); }

 private:
  std::function<void()> function_;
};

}  // namespace

/// State shared by the executor and its groups, so that a group may outlive the executor.
///
/// `ready_` holds work in the order of arrival. Work of a group that is held, or exclusive and
/// busy, is parked in the group, and returns to its place in `ready_` by its arrival number, so the
/// oldest work that may run is always the next.
///
/// Idle workers sleep on `work_available_`, except for one, the timekeeper, which sleeps on
/// `time_due_` until the next timer. Work goes to a plain sleeper if there is one, so that the
/// timekeeper need not be replaced for each message.
///
/// A thread that leaves its spin hands over what it would have done: it may have been the one that
/// was woken for some work, or the timekeeper, while threads of other spins sleep on.
class Executor::Core final : public Activity::Source,
                             public std::enable_shared_from_this<Executor::Core> {
 public:
  class Group;
  struct Work {
    std::shared_ptr<Group> group;
    std::shared_ptr<Waitable> waitable;
    std::uint64_t arrival = 0;
  };
  /// A `spin` or `spin_until` in progress. Its members are guarded by the core's mutex.
  struct Spin {
    bool stopped = false;
    std::exception_ptr failure{};
  };

  explicit Core(std::size_t threads) : threads_(threads) {}

  void schedule(std::shared_ptr<Group> group, std::shared_ptr<Waitable> waitable);
  void schedule_at(const std::shared_ptr<Group>& group, SteadyTime when,
                   const std::shared_ptr<Waitable>& waitable);
  void cancel(const Waitable* waitable);
  void hold(Group& group);
  void release(Group& group);
  bool when_idle(Group& group, std::function<void()> idle);
  void close(Group& group);
  void join(Group& group, const std::shared_ptr<Activity>& activity, std::string node);

  void look(std::set<std::string>& busy_nodes, std::uint64_t& units_of_work) override;

  void begin_spin(Spin& spin);
  void end_spin(Spin& spin);
  void stop();
  /// Runs one callback. Within a spin it waits for one, until `until` if that is given, or until
  /// the spin is stopped. False when there was none.
  bool run_one(const Spin* spin, const SteadyTime* until);
  void work_until_stopped(Spin& spin);
  void fail(Spin& spin, std::exception_ptr error);

  const std::size_t threads_;

 private:
  struct Timed {
    std::weak_ptr<Group> group;
    std::weak_ptr<Waitable> waitable;
    const Waitable* key;
  };
  using Timeline = std::multimap<SteadyTime, Timed>;
  // References given up under the lock and dropped after it: they may be the last, and a destructor
  // may run anything.
  using Released = std::vector<std::shared_ptr<void>>;

  // All under mutex_.
  std::condition_variable* make_ready(std::shared_ptr<Group> group,
                                      std::shared_ptr<Waitable> waitable);
  std::condition_variable* pick_sleeper();
  std::condition_variable* pick_sleeper_for_what_is_left();
  void promote_due_timers(Released& released);
  bool take(Work& work, Released& released);
  void wait_for_work(std::unique_lock<std::mutex>& lock, const SteadyTime* until);
  /// Returns whom to tell that the group is idle, without the lock.
  std::vector<std::function<void()>> finish(Group& group);
  /// Activities that wait for this executor, if it has nothing to do.
  [[nodiscard]] std::vector<std::shared_ptr<Activity>> awaited_activities() const;

  void execute(const Work& work);

  std::mutex mutex_;
  std::condition_variable work_available_;
  std::condition_variable time_due_;
  std::condition_variable group_idle_;
  std::deque<Work> ready_;
  std::vector<std::weak_ptr<Activity>> activities_;
  std::vector<std::weak_ptr<Group>> joined_groups_;
  Timeline timeline_;
  std::unordered_map<const Waitable*, Timeline::iterator> timed_;
  std::uint64_t arrivals_ = 0;
  std::size_t sleepers_ = 0;
  std::size_t woken_sleepers_ = 0;  // notified, but not awake yet
  bool timekeeper_asleep_ = false;
  bool timekeeper_woken_ = false;
  std::vector<Spin*> spins_;
  bool stop_next_spin_ = false;  // stop() came while there was none
};

class Executor::Core::Group final : public CallbackGroup,
                                    public std::enable_shared_from_this<Executor::Core::Group> {
 public:
  Group(std::weak_ptr<Core> core, CallbackGroupType type) : core_(std::move(core)), type_(type) {}

  CallbackGroupType type() const noexcept override { return type_; }

  void set_exception_handler(ExceptionHandler handler) override {
    const std::lock_guard lock(handler_mutex_);
    handler_.swap(handler);
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

  void hold() override {
    if (const auto core = core_.lock()) {
      core->hold(*this);
    }
  }

  void release() override {
    if (const auto core = core_.lock()) {
      core->release(*this);
    }
  }

  bool when_idle(std::function<void()> idle) override {
    const auto core = core_.lock();
    return !core || core->when_idle(*this, std::move(idle));
  }

  void close() override {
    if (const auto core = core_.lock()) {
      core->close(*this);
    }
  }

  void join(const std::shared_ptr<Activity>& activity, std::string node) override {
    if (const auto core = core_.lock()) {
      core->join(*this, activity, std::move(node));
    }
  }

  ExceptionHandler handler() {
    const std::lock_guard lock(handler_mutex_);
    return handler_;
  }

  [[nodiscard]] bool is_busy() const {
    return held_ || (type_ == CallbackGroupType::kMutuallyExclusive && !running_.empty());
  }

  const std::weak_ptr<Core> core_;
  const CallbackGroupType type_;

  // Guarded by the core's mutex.
  std::vector<std::thread::id> running_;
  std::deque<Work> parked_;  // without `group`: it would own itself
  std::vector<std::function<void()>> when_idle_;
  std::string node_;  // empty: in no activity
  bool held_ = false;
  bool closed_ = false;

 private:
  std::mutex handler_mutex_;
  ExceptionHandler handler_;
};

namespace {

// Work mostly arrives in order; then this is a push_back.
template <class Work>
void insert_by_arrival(std::deque<Work>& queue, Work work) {
  if (queue.empty() || queue.back().arrival < work.arrival) {
    queue.push_back(std::move(work));
    return;
  }
  const auto later = std::upper_bound(
      queue.begin(), queue.end(), work.arrival,
      [](std::uint64_t arrival, const Work& other) { return arrival < other.arrival; });
  queue.insert(later, std::move(work));
}

}  // namespace

std::condition_variable* Executor::Core::make_ready(std::shared_ptr<Group> group,
                                                    std::shared_ptr<Waitable> waitable) {
  const std::uint64_t arrival = ++arrivals_;
  if (group->is_busy()) {
    group->parked_.push_back({nullptr, std::move(waitable), arrival});
    return nullptr;
  }
  ready_.push_back({std::move(group), std::move(waitable), arrival});
  return pick_sleeper();
}

std::condition_variable* Executor::Core::pick_sleeper() {
  if (sleepers_ > woken_sleepers_) {
    ++woken_sleepers_;
    return &work_available_;
  }
  if (timekeeper_asleep_ && !timekeeper_woken_) {
    timekeeper_woken_ = true;
    return &time_due_;
  }
  return nullptr;
}

/// For a thread that does not look for work next: ready work needs a worker, and the timeline a
/// timekeeper.
std::condition_variable* Executor::Core::pick_sleeper_for_what_is_left() {
  const bool has_work = !ready_.empty() || (!timeline_.empty() && !timekeeper_asleep_);
  return has_work ? pick_sleeper() : nullptr;
}

void Executor::Core::schedule(std::shared_ptr<Group> group, std::shared_ptr<Waitable> waitable) {
  std::condition_variable* sleeper = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (group->closed_) {
      return;
    }
    sleeper = make_ready(std::move(group), std::move(waitable));
  }
  if (sleeper != nullptr) {
    sleeper->notify_one();
  }
}

void Executor::Core::schedule_at(const std::shared_ptr<Group>& group, SteadyTime when,
                                 const std::shared_ptr<Waitable>& waitable) {
  std::condition_variable* sleeper = nullptr;
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
    if (position == timeline_.begin()) {
      if (!timekeeper_asleep_) {
        sleeper = pick_sleeper();  // becomes the timekeeper
      } else if (!timekeeper_woken_) {
        timekeeper_woken_ = true;
        sleeper = &time_due_;
      }
    }
  }
  if (sleeper != nullptr) {
    sleeper->notify_one();
  }
}

void Executor::Core::cancel(const Waitable* waitable) {
  const std::lock_guard lock(mutex_);
  if (const auto found = timed_.find(waitable); found != timed_.end()) {
    timeline_.erase(found->second);
    timed_.erase(found);
  }
}

void Executor::Core::promote_due_timers(Released& released) {
  if (timeline_.empty()) {
    return;
  }
  const SteadyTime now = steady_now();
  while (!timeline_.empty() && timeline_.begin()->first <= now) {
    const auto first = timeline_.begin();
    const Timed timed = std::move(first->second);
    timed_.erase(timed.key);
    timeline_.erase(first);
    auto group = timed.group.lock();
    auto waitable = timed.waitable.lock();
    if (group && waitable && !group->closed_) {
      ready_.push_back({std::move(group), std::move(waitable), ++arrivals_});
    } else {
      released.push_back(std::move(group));
      released.push_back(std::move(waitable));
    }
  }
}

bool Executor::Core::take(Work& work, Released& released) {
  while (!ready_.empty()) {
    work = std::move(ready_.front());
    ready_.pop_front();
    if (!work.group->is_busy()) {
      return true;
    }
    std::shared_ptr<Group> group = std::move(work.group);
    insert_by_arrival(group->parked_, std::move(work));
    if (group->running_.empty()) {
      released.push_back(std::move(group));  // no running work keeps a group that is held
    }
  }
  return false;
}

void Executor::Core::wait_for_work(std::unique_lock<std::mutex>& lock, const SteadyTime* until) {
  if (!timeline_.empty() && !timekeeper_asleep_) {
    SteadyTime deadline = timeline_.begin()->first;
    if (until != nullptr) {
      deadline = std::min(deadline, *until);
    }
    timekeeper_asleep_ = true;
    timekeeper_woken_ = false;
    time_due_.wait_until(lock, deadline);
    timekeeper_asleep_ = false;
    return;
  }
  ++sleepers_;
  if (until != nullptr) {
    work_available_.wait_until(lock, *until);
  } else {
    work_available_.wait(lock);
  }
  --sleepers_;
  if (woken_sleepers_ > 0) {
    --woken_sleepers_;
  }
}

std::vector<std::function<void()>> Executor::Core::finish(Group& group) {
  group.running_.erase(
      std::find(group.running_.begin(), group.running_.end(), std::this_thread::get_id()));
  if (group.closed_) {
    group_idle_.notify_all();
  } else if (!group.is_busy() && !group.parked_.empty()) {
    // No need to wake anybody: this thread looks for work next.
    Work next = std::move(group.parked_.front());
    group.parked_.pop_front();
    next.group = group.shared_from_this();
    insert_by_arrival(ready_, std::move(next));
  }
  std::vector<std::function<void()>> told;
  if (group.running_.empty()) {
    told.swap(group.when_idle_);
  }
  return told;
}

void Executor::Core::hold(Group& group) {
  const std::lock_guard lock(mutex_);
  group.held_ = true;
}

void Executor::Core::release(Group& group) {
  std::condition_variable* sleeper = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(group.held_, false) || group.parked_.empty()) {
      return;
    }
    for (Work& work : group.parked_) {
      work.group = group.shared_from_this();
      insert_by_arrival(ready_, std::move(work));
    }
    group.parked_.clear();
    sleeper = pick_sleeper();
  }
  if (sleeper != nullptr) {
    sleeper->notify_one();
  }
}

bool Executor::Core::when_idle(Group& group, std::function<void()> idle) {
  const std::lock_guard lock(mutex_);
  if (group.running_.empty()) {
    return true;
  }
  group.when_idle_.push_back(std::move(idle));
  return false;
}

void Executor::Core::close(Group& group) {
  // Destroyed after the lock is released, see Released.
  std::deque<Work> dropped_parked;
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
  const std::weak_ptr<Group> self = group.weak_from_this();
  for (auto entry = timeline_.begin(); entry != timeline_.end();) {
    const auto& owner = entry->second.group;
    if (!owner.owner_before(self) && !self.owner_before(owner)) {
      timed_.erase(entry->second.key);
      entry = timeline_.erase(entry);
    } else {
      ++entry;
    }
  }
  const auto& running = group.running_;
  if (std::find(running.begin(), running.end(), std::this_thread::get_id()) == running.end()) {
    group_idle_.wait(lock, [&] { return running.empty(); });
  }
  const auto activities = awaited_activities();
  lock.unlock();
  for (const auto& activity : activities) {
    activity->check();
  }
}

void Executor::Core::join(Group& group, const std::shared_ptr<Activity>& activity,
                          std::string node) {
  activity->add(shared_from_this());
  const std::lock_guard lock(mutex_);
  group.node_ = std::move(node);
  std::erase_if(joined_groups_, [](const auto& weak) { return weak.expired(); });
  joined_groups_.push_back(group.weak_from_this());
  const auto known = [&](const auto& weak) { return weak.lock() == activity; };
  if (std::none_of(activities_.begin(), activities_.end(), known)) {
    activities_.push_back(activity);
  }
}

void Executor::Core::look(std::set<std::string>& busy_nodes, std::uint64_t& units_of_work) {
  std::vector<std::shared_ptr<Group>> groups;  // released after the lock
  const std::lock_guard lock(mutex_);
  for (const auto& weak : joined_groups_) {
    if (auto group = weak.lock()) {
      if (!group->running_.empty() || !group->parked_.empty()) {
        busy_nodes.insert(group->node_);
      }
      groups.push_back(std::move(group));
    }
  }
  for (const Work& work : ready_) {
    if (!work.group->node_.empty()) {
      busy_nodes.insert(work.group->node_);
    }
  }
  units_of_work = arrivals_;
}

std::vector<std::shared_ptr<Activity>> Executor::Core::awaited_activities() const {
  std::vector<std::shared_ptr<Activity>> awaited;
  if (!ready_.empty()) {
    return awaited;
  }
  for (const auto& weak : activities_) {
    if (auto activity = weak.lock(); activity && activity->is_awaited()) {
      awaited.push_back(std::move(activity));
    }
  }
  return awaited;
}

void Executor::Core::begin_spin(Spin& spin) {
  const std::lock_guard lock(mutex_);
  spin.stopped = std::exchange(stop_next_spin_, false);
  spins_.push_back(&spin);
}

void Executor::Core::end_spin(Spin& spin) {
  std::condition_variable* sleeper = nullptr;
  {
    const std::lock_guard lock(mutex_);
    std::erase(spins_, &spin);
    sleeper = pick_sleeper_for_what_is_left();
  }
  if (sleeper != nullptr) {
    sleeper->notify_one();
  }
}

void Executor::Core::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_next_spin_ = spins_.empty();
    for (Spin* spin : spins_) {
      spin->stopped = true;
    }
  }
  work_available_.notify_all();
  time_due_.notify_all();
}

bool Executor::Core::run_one(const Spin* spin, const SteadyTime* until) {
  Work work;
  Released released;
  std::condition_variable* sleeper = nullptr;
  {
    std::unique_lock lock(mutex_);
    while (true) {
      if (spin != nullptr && spin->stopped) {
        return false;
      }
      promote_due_timers(released);
      if (take(work, released)) {
        break;
      }
      if (!released.empty()) {
        lock.unlock();
        released.clear();
        lock.lock();
        continue;
      }
      if (spin == nullptr || (until != nullptr && steady_now() >= *until)) {
        return false;
      }
      wait_for_work(lock, until);
    }
    work.group->running_.push_back(std::this_thread::get_id());
    sleeper = pick_sleeper_for_what_is_left();
  }
  if (sleeper != nullptr) {
    sleeper->notify_one();
  }
  released.clear();

  std::exception_ptr error;
  try {
    execute(work);
  } catch (...) {
    error = std::current_exception();
  }
  work.waitable.reset();
  std::vector<std::function<void()>> idle;
  std::vector<std::shared_ptr<Activity>> activities;
  {
    const std::lock_guard lock(mutex_);
    idle = finish(*work.group);
    activities = awaited_activities();
  }
  for (const auto& tell : idle) {
    tell();
  }
  for (const auto& activity : activities) {
    activity->check();
  }
  if (error) {
    std::rethrow_exception(error);
  }
  return true;
}

void Executor::Core::execute(const Work& work) {
  try {
    work.waitable->execute();
  } catch (...) {
    const auto handler = work.group->handler();
    if (!handler) {
      throw;
    }
    handler(std::current_exception());
  }
}

void Executor::Core::work_until_stopped(Spin& spin) {
  try {
    while (run_one(&spin, nullptr)) {
    }
  } catch (...) {
    fail(spin, std::current_exception());
  }
}

void Executor::Core::fail(Spin& spin, std::exception_ptr error) {
  {
    const std::lock_guard lock(mutex_);
    if (!spin.failure) {
      spin.failure = std::move(error);
    }
    spin.stopped = true;
  }
  work_available_.notify_all();
  time_due_.notify_all();
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
  Core::Spin spin;
  core_->begin_spin(spin);
  std::vector<std::thread> others;
  try {
    for (std::size_t i = 1; i < core_->threads_; ++i) {
      others.emplace_back([core = core_, &spin] { core->work_until_stopped(spin); });
    }
  } catch (...) {
    core_->fail(spin, std::current_exception());
  }
  core_->work_until_stopped(spin);
  for (auto& thread : others) {
    thread.join();
  }
  core_->end_spin(spin);
  if (spin.failure) {
    std::rethrow_exception(spin.failure);
  }
}

std::size_t Executor::spin_ready() {
  std::size_t ran = 0;
  while (core_->run_one(nullptr, nullptr)) {
    ++ran;
  }
  return ran;
}

bool Executor::spin_until(const std::function<bool()>& done, Duration timeout) {
  struct Spinning {
    explicit Spinning(Core& given) : core(given) { core.begin_spin(spin); }
    Spinning(const Spinning&) = delete;
    Spinning& operator=(const Spinning&) = delete;
    ~Spinning() { core.end_spin(spin); }
    Core& core;
    Core::Spin spin;
  };
  const Spinning spinning(*core_);
  const SteadyTime until = add_saturated(steady_now(), timeout);
  while (!done()) {
    if (!core_->run_one(&spinning.spin, &until)) {
      return done();
    }
  }
  return true;
}

void Executor::stop() {
  core_->stop();
}

std::size_t Executor::threads() const noexcept {
  return core_->threads_;
}

}  // namespace pipescout
