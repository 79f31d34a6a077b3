// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/component.hpp"
#include "plain_fastdds/plain_fastdds.hpp"
#include "samples.hpp"
#include "transport_benchmark.hpp"

namespace pipescout::benchmarks {

namespace {

using sensor_msgs::msg::Image;

constexpr int kComponents = 20;
constexpr Duration kPeriod = std::chrono::milliseconds(20);
constexpr Duration kWarmUp = std::chrono::seconds(2);
constexpr Duration kMeasure = std::chrono::seconds(8);

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Percent of one core that the process takes while `run_for` works for the given time.
double load_while(const std::function<void(Duration)>& run_for) {
  run_for(kWarmUp);
  const double processor = processor_seconds();
  const std::int64_t wall = monotonic_nanoseconds();
  run_for(kMeasure);
  return 100.0 * (processor_seconds() - processor) /
         (static_cast<double>(monotonic_nanoseconds() - wall) * 1e-9);
}

/// Passes messages on. The first of a chain makes them.
class Link final : public Component {
 public:
  Link(ComponentOptions options, int index) : Component(std::move(options)), index_(index) {}

 protected:
  CallbackReturn on_configure() override {
    const std::string input = "chain_" + std::to_string(index_);
    const std::string output = "chain_" + std::to_string(index_ + 1);
    publisher_ = create_publisher<Image>(output, QoS::reliable());
    if (index_ == 0) {
      timer_ = create_timer(kPeriod, [this] { publisher_.publish(make_image(kOneKilobyte)); });
    } else {
      subscription_ = create_subscription<Image>(
          input, QoS::reliable(),
          [this](const std::shared_ptr<const Image>& image) { publisher_.publish(image); });
    }
    return CallbackReturn::kSuccess;
  }

 private:
  const int index_;
  Publisher<Image> publisher_;
  Subscription<Image> subscription_;
  std::shared_ptr<Timer> timer_;
};

double our_load(bool busy) {
  Executor executor;
  const auto context = Context::create(
      create_dds_transport({.domain_id = in_process_domain(), .localhost_only = true}));
  std::vector<ComponentPtr<>> components;
  for (int i = 0; i < kComponents; ++i) {
    const ComponentOptions options{
        .context = context, .executor = &executor, .name = {"/", "component_" + std::to_string(i)}};
    // An idle component has all that every component has, and nothing to do.
    components.push_back(busy ? ComponentPtr<>(make_component<Link>(options, i))
                              : make_component<Component>(options));
    components.back()->request_transition(LifecycleTransition::kConfigure);
    components.back()->request_transition(LifecycleTransition::kActivate);
  }
  return load_while([&](Duration time) { executor.spin_until([] { return false; }, time); });
}

/// The thread in which all plain components work. A component cannot write in its listener: each
/// write that is nested in another one holds a send buffer, and Fast DDS waits for ever once there
/// is none left. So the listener leaves the image here, which costs the least that it can.
class PlainWorker {
 public:
  void leave(PlainWriter& writer, Image image) {
    {
      const std::lock_guard lock(mutex_);
      left_.emplace_back(&writer, std::move(image));
    }
    there_.notify_one();
  }

  /// Writes what is left here, and an image to `first` each period.
  void work(PlainWriter& first, Duration time) {
    const auto end = std::chrono::steady_clock::now() + time;
    auto next = std::chrono::steady_clock::now();
    while (next < end) {
      first.write(*make_image(kOneKilobyte));
      next += kPeriod;
      std::unique_lock lock(mutex_);
      while (there_.wait_until(lock, next, [this] { return !left_.empty(); })) {
        auto [writer, image] = std::move(left_.front());
        left_.pop_front();
        lock.unlock();
        writer->write(image);
        lock.lock();
      }
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable there_;
  std::deque<std::pair<PlainWriter*, Image>> left_;
};

double plain_load() {
  const auto participant = create_plain_participant(in_process_domain());
  PlainWorker worker;
  std::vector<std::unique_ptr<PlainWriter>> writers;
  std::vector<std::unique_ptr<PlainReader>> readers;
  for (int i = 0; i < kComponents; ++i) {
    writers.push_back(std::make_unique<PlainWriter>(participant, "chain_" + std::to_string(i + 1)));
  }
  for (int i = 1; i < kComponents; ++i) {
    PlainWriter& writer = *writers[static_cast<std::size_t>(i)];
    readers.push_back(std::make_unique<PlainReader>(
        participant, "chain_" + std::to_string(i),
        [&worker, &writer](Image& image) { worker.leave(writer, std::move(image)); }));
  }
  return load_while([&](Duration time) { worker.work(*writers.front(), time); });
}

/// Measures in a process of its own, so that nothing of this one counts.
double in_child(const char* what) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) {
    throw std::runtime_error("no pipe");
  }
  const std::string out = std::to_string(ends[1]);
  const pid_t child = fork();
  if (child == 0) {
    execl("/proc/self/exe", "transport_benchmark", "--load", what, out.c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  double percent = 0.0;
  const bool answered = read(ends[0], &percent, sizeof percent) == sizeof percent;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!answered || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error(std::string("the process that measures the load '") + what +
                             "' failed");
  }
  return percent;
}

}  // namespace

LoadFigures measure_load() {
  return {.idle_percent = in_child("idle"),
          .busy_percent = in_child("busy"),
          .busy_plain_percent = in_child("plain")};
}

int run_as_child(int argc, char** argv) {
  if (argc == 4 && std::strcmp(argv[1], "--load") == 0) {
    const std::string what = argv[2];
    const double percent = what == "plain" ? plain_load() : our_load(what == "busy");
    return write(std::stoi(argv[3]), &percent, sizeof percent) == sizeof percent ? 0 : 1;
  }
  return run_as_receiver(argc, argv);
}

}  // namespace pipescout::benchmarks
