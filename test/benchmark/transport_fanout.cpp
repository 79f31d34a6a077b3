// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/component.hpp"
#include "transport_benchmark.hpp"

namespace pipescout::benchmarks {

namespace {

using rmw_dds_common::msg::ParticipantEntitiesInfo;
using sensor_msgs::msg::Image;

// One and ten subscriptions take turns, so that a slow spell of the machine hits both.
constexpr int kRounds = 4;
constexpr int kImages = 25;
constexpr Duration kImagePeriod = std::chrono::milliseconds(100);
constexpr int kComponents = 50;
constexpr int kTopicsOfEach = 4;
// Should another announcement follow, it does so sooner.
constexpr Duration kAfterTheLast = std::chrono::seconds(2);
constexpr Duration kPatience = std::chrono::seconds(60);

std::shared_ptr<Context> join(std::uint32_t domain) {
  return Context::create(create_dds_transport({.domain_id = domain, .localhost_only = true}));
}

/// A child process of the benchmark with a pipe to hear from it. Killed at the end.
class Child {
 public:
  Child(const std::string& task, const std::string& argument) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) {
      throw std::runtime_error("no pipe");
    }
    const std::string domain = std::to_string(benchmark_domain());
    const std::string out = std::to_string(ends[1]);
    process_ = fork();
    if (process_ == 0) {
      execl("/proc/self/exe", "transport_benchmark", task.c_str(), argument.c_str(), domain.c_str(),
            out.c_str(), nullptr);
      _exit(127);
    }
    close(ends[1]);
    pipe_ = ends[0];
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    close(pipe_);
  }
  template <class T>
  T hear() {
    T heard{};
    if (read(pipe_, &heard, sizeof heard) != sizeof heard) {
      throw std::runtime_error("a child process of the benchmark failed");
    }
    return heard;
  }

 private:
  int pipe_ = -1;
  pid_t process_ = -1;
};

template <class T>
bool say(int pipe, const T& value) {
  return write(pipe, &value, sizeof value) == sizeof value;
}

struct Received {
  std::uint64_t images;
  double processor_seconds;

  Received& operator+=(const Received& other) {
    images += other.images;
    processor_seconds += other.processor_seconds;
    return *this;
  }
};

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

int receive_images(int subscriptions, std::uint32_t domain, int pipe) {
  Executor executor;
  const auto context = join(domain);
  Node node({.context = context,
             .executor = &executor,
             .name = {"/", "fanout_receiver"},
             .standard_interfaces = false});
  Received received{};
  bool over = false;
  // What wakes the executor when it waits for matches.
  const NodeSubscriptionOptions options{.events = {.matched = [](std::size_t) {}}};
  std::vector<Subscription<Image>> all;
  for (int i = 0; i < subscriptions; ++i) {
    all.push_back(node.create_subscription<Image>(
        "fanout", QoS::reliable(), [&](const std::shared_ptr<const Image>&) { ++received.images; },
        options));
  }
  const auto end = node.create_subscription<Image>(
      "fanout_end", QoS::reliable(), [&](const Image&) { over = true; }, options);
  executor.spin_until(
      [&] {
        return end.publisher_count() == 1 &&
               std::all_of(all.begin(), all.end(), [](const auto& subscription) {
                 return subscription.publisher_count() == 1;
               });
      },
      kPatience);
  const double before = processor_seconds();
  say(pipe, true);
  executor.spin_until([&] { return over; }, kPatience);
  received.processor_seconds = processor_seconds() - before;
  return say(pipe, received) ? 0 : 1;
}

Received fan_out_to(int subscriptions) {
  Executor executor;
  const auto context = join(benchmark_domain());
  Node node({.context = context,
             .executor = &executor,
             .name = {"/", "fanout_sender"},
             .standard_interfaces = false});
  const NodePublisherOptions options{.events = {.matched = [](std::size_t) {}}};
  auto images = node.create_publisher<Image>("fanout", QoS::reliable(), options);
  auto end = node.create_publisher<Image>("fanout_end", QoS::reliable(), options);
  Child child("--fanout", std::to_string(subscriptions));
  child.hear<bool>();
  executor.spin_until(
      [&] { return images.subscription_count() >= 1 && end.subscription_count() == 1; }, kPatience);
  auto next = std::chrono::steady_clock::now();
  for (int i = 0; i < kImages; ++i) {
    // No event: the pace of a camera.
    std::this_thread::sleep_until(next += kImagePeriod);
    images.publish(make_image(kSixMegabytes));
  }
  // No event: the pace of a camera.
  std::this_thread::sleep_until(next + kImagePeriod);
  end.publish(make_image(kOneKilobyte));
  return child.hear<Received>();
}

/// A component with topics of its own.
class Talker final : public Component {
 public:
  Talker(ComponentOptions options, int index) : Component(std::move(options)), index_(index) {}
  ~Talker() override { close(); }

 protected:
  CallbackReturn on_configure() override {
    for (int i = 0; i < kTopicsOfEach; ++i) {
      const std::string topic = "talk_" + std::to_string((index_ + i) % kComponents);
      if (i % 2 == 0) {
        publishers_.push_back(create_publisher<Image>(topic, QoS::reliable()));
      } else {
        subscriptions_.push_back(
            create_subscription<Image>(topic, QoS::reliable(), [](const Image&) {}));
      }
    }
    return CallbackReturn::kSuccess;
  }

 private:
  const int index_;
  std::vector<Publisher<Image>> publishers_;
  std::vector<Subscription<Image>> subscriptions_;
};

int start_components(int components, std::uint32_t domain, int pipe) {
  Executor executor;
  const auto context = join(domain);
  std::vector<std::unique_ptr<Talker>> talkers;
  for (int i = 0; i < components; ++i) {
    talkers.push_back(
        std::make_unique<Talker>(ComponentOptions{.context = context,
                                                  .executor = &executor,
                                                  .name = {"/", "talker_" + std::to_string(i)}},
                                 i));
    talkers.back()->request_transition(LifecycleTransition::kConfigure);
  }
  say(pipe, true);
  executor.spin();
  return 0;
}

}  // namespace

FanoutFigures measure_fanout() {
  Received one{};
  Received ten{};
  for (int round = 0; round < kRounds; ++round) {
    one += fan_out_to(1);
    ten += fan_out_to(10);
  }
  constexpr double kSent = kRounds * kImages;
  return {.delivered_percent = 100.0 * static_cast<double>(ten.images) / (10.0 * kSent),
          .cpu_ms_per_image_one = 1e3 * one.processor_seconds / kSent,
          .cpu_ms_per_image_ten = 1e3 * ten.processor_seconds / kSent};
}

DiscoveryFigures measure_discovery() {
  const auto context = join(benchmark_domain());
  const MessageType& type = message_type<ParticipantEntitiesInfo>();
  std::mutex mutex;
  std::map<Gid, DiscoveryFigures> heard;  // by writer: other processes of the benchmark speak too
  const auto subscription = context->create_subscription(
      {.topic = {"ros_discovery_info", &type},
       .qos = QoS::latched(1000),
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo& info) {
         const std::lock_guard lock(mutex);
         DiscoveryFigures& figures = heard[info.identity.writer];
         figures.announcements += 1.0;
         figures.last_kilobytes = static_cast<double>(type.serialized_size(message.get())) * 1e-3;
         figures.kilobytes += figures.last_kilobytes;
       }});
  Child child("--components", std::to_string(kComponents));
  child.hear<bool>();
  // The last announcement is there when everything that discovery shows has its node.
  const bool complete = context->graph().wait_until(
      [&] {
        const auto endpoints = context->graph().endpoints();
        return std::count_if(endpoints.begin(), endpoints.end(), [](const auto& endpoint) {
                 return endpoint.node && endpoint.wire_topic.starts_with("rt/talk_");
               }) == kComponents * kTopicsOfEach;
      },
      kPatience);
  if (!complete) {
    throw std::runtime_error("the 50 components were not seen");
  }
  // No event: nothing tells that no further announcement follows.
  std::this_thread::sleep_for(kAfterTheLast);
  const std::lock_guard lock(mutex);
  // That of the 50 components is by far the longest.
  return std::max_element(heard.begin(), heard.end(),
                          [](const auto& a, const auto& b) {
                            return a.second.last_kilobytes < b.second.last_kilobytes;
                          })
      ->second;
}

int run_as_peer(int argc, char** argv) {
  if (argc != 5) {
    return -1;
  }
  const std::string task = argv[1];
  if (task != "--fanout" && task != "--components") {
    return -1;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int number = std::stoi(argv[2]);
  const auto domain = static_cast<std::uint32_t>(std::stoul(argv[3]));
  const int pipe = std::stoi(argv[4]);
  return task == "--fanout" ? receive_images(number, domain, pipe)
                            : start_components(number, domain, pipe);
}

}  // namespace pipescout::benchmarks
