// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/node.hpp"
#include "plain_fastdds/plain_fastdds.hpp"
#include "samples.hpp"
#include "transport_benchmark.hpp"

namespace pipescout::benchmarks {

namespace {

using sensor_msgs::msg::Image;
using SharedImage = std::shared_ptr<const Image>;

constexpr int kIterations = 1000;
constexpr Duration kPatience = std::chrono::seconds(10);

/// Runs `once`, which measures one hand-over in microseconds, as a Google Benchmark case.
void register_case(const std::string& name, const std::function<void(benchmark::State&)>& run) {
  benchmark::RegisterBenchmark(name.c_str(), run)
      ->UseManualTime()
      ->Iterations(kIterations)
      ->Unit(benchmark::kMicrosecond);
}

/// False, and the case is an error, when the message did not arrive.
bool record(benchmark::State& state, const std::string& name, double microseconds) {
  if (microseconds < 0.0) {
    state.SkipWithError("a message was lost");
    return false;
  }
  state.SetIterationTime(microseconds / 1e6);
  all_samples()[name].add(microseconds);
  return true;
}

/// Gives out images as a driver does that keeps a few buffers. In all cases as many bytes are
/// written before an image goes out, those of the largest size: otherwise small images would meet
/// warmer caches than large ones, which is no property of a transport.
class Camera {
 public:
  explicit Camera(ImageSize size) {
    for (auto& buffer : buffers_) {
      buffer = make_image(size);
    }
  }
  /// An image that nobody holds any more, just stamped.
  std::shared_ptr<Image> next() {
    next_ = (next_ + 1) % buffers_.size();
    if (buffers_[next_].use_count() != 1) {
      throw std::runtime_error("an image is still held");
    }
    last_frame_->data = frame_->data;
    benchmark::ClobberMemory();
    stamp(*buffers_[next_]);
    return buffers_[next_];
  }

 private:
  std::array<std::shared_ptr<Image>, 4> buffers_;
  std::size_t next_ = 0;
  std::unique_ptr<Image> frame_ = make_image(kLargeImage);
  std::unique_ptr<Image> last_frame_ = make_image(kLargeImage);
};

/// Our participant is there, as in any process on a network.
std::shared_ptr<Context> networked_context() {
  return Context::create(
      create_dds_transport({.domain_id = in_process_domain(), .localhost_only = true}));
}

/// Publisher and subscriber in one executor.
void ours_one_executor(benchmark::State& state, const std::string& name, ImageSize size) {
  Executor executor;
  const auto context = networked_context();
  Node node({.context = context,
             .executor = &executor,
             .name = {"/", "bench"},
             .standard_interfaces = false});
  double latency = -1.0;
  const auto subscription = node.create_subscription<Image>(
      "in_process_image", QoS::reliable(),
      [&](const Image& image) { latency = microseconds_since_stamp(image); });
  auto publisher = node.create_publisher<Image>("in_process_image", QoS::reliable());
  Camera camera(size);
  for (auto _ : state) {
    publisher.publish(camera.next());
    executor.spin_ready();
    if (!record(state, name, std::exchange(latency, -1.0))) {
      return;
    }
  }
}

/// Somebody who waits until a latency was measured elsewhere.
class Measured {
 public:
  void put(double microseconds) {
    {
      const std::lock_guard lock(mutex_);
      value_ = microseconds;
    }
    there_.notify_one();
  }
  double take() {
    std::unique_lock lock(mutex_);
    if (!there_.wait_for(lock, kPatience, [&] { return value_ >= 0.0; })) {
      return -1.0;
    }
    return std::exchange(value_, -1.0);
  }

 private:
  std::mutex mutex_;
  std::condition_variable there_;
  double value_ = -1.0;
};

void plain_in_process(benchmark::State& state, const std::string& name, ImageSize size) {
  const auto participant = create_plain_participant(in_process_domain());
  Measured measured;
  const PlainReader reader(participant, "plain_image",
                           [&](Image& image) { measured.put(microseconds_since_stamp(image)); });
  PlainWriter writer(participant, "plain_image");
  while (writer.matched() == 0 || reader.matched() == 0) {
    std::this_thread::yield();
  }
  Camera camera(size);
  for (auto _ : state) {
    writer.write(*camera.next());
    if (!record(state, name, measured.take())) {
      return;
    }
  }
}

/// Publisher in this thread, subscriber on an executor of another.
void ours_two_threads(benchmark::State& state, const std::string& name) {
  Executor executor;
  const auto context = networked_context();
  Node node({.context = context,
             .executor = &executor,
             .name = {"/", "bench"},
             .standard_interfaces = false});
  Measured measured;
  const auto subscription = node.create_subscription<Image>(
      "in_process_image", QoS::reliable(),
      [&](const Image& image) { measured.put(microseconds_since_stamp(image)); });
  auto publisher = node.create_publisher<Image>("in_process_image", QoS::reliable());
  std::thread spinner([&] { executor.spin(); });
  Camera camera(kThermalImage);
  for (auto _ : state) {
    publisher.publish(camera.next());
    if (!record(state, name, measured.take())) {
      break;
    }
  }
  executor.stop();
  spinner.join();
}

/// The least that two threads can do: a queue, a mutex and a condition variable.
void bare_two_threads(benchmark::State& state, const std::string& name) {
  std::mutex mutex;
  std::condition_variable filled;
  std::deque<SharedImage> queue;
  bool stop = false;
  Measured measured;
  std::thread consumer([&] {
    std::unique_lock lock(mutex);
    while (true) {
      filled.wait(lock, [&] { return stop || !queue.empty(); });
      if (stop) {
        return;
      }
      const SharedImage image = std::move(queue.front());
      queue.pop_front();
      lock.unlock();
      measured.put(microseconds_since_stamp(*image));
      lock.lock();
    }
  });
  Camera camera(kThermalImage);
  for (auto _ : state) {
    SharedImage shared = camera.next();
    {
      const std::lock_guard lock(mutex);
      queue.push_back(std::move(shared));
    }
    filled.notify_one();
    if (!record(state, name, measured.take())) {
      break;
    }
  }
  {
    const std::lock_guard lock(mutex);
    stop = true;
  }
  filled.notify_one();
  consumer.join();
}

}  // namespace

void register_in_process() {
  const auto add = [](const std::string& name, auto run) {
    register_case(name, [name, run](benchmark::State& state) { run(state, name); });
  };
  add("in process, image, ours", [](benchmark::State& state, const std::string& name) {
    ours_one_executor(state, name, kThermalImage);
  });
  add("in process, 64x64, ours", [](benchmark::State& state, const std::string& name) {
    ours_one_executor(state, name, kSmallImage);
  });
  add("in process, 1920x1080, ours", [](benchmark::State& state, const std::string& name) {
    ours_one_executor(state, name, kLargeImage);
  });
  add("in process, image, plain Fast DDS", [](benchmark::State& state, const std::string& name) {
    plain_in_process(state, name, kThermalImage);
  });
  add("two threads, image, ours", ours_two_threads);
  add("two threads, image, bare hand-over", bare_two_threads);
}

}  // namespace pipescout::benchmarks
