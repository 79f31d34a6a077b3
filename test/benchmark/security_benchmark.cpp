// SPDX-License-Identifier: Apache-2.0
// What DDS Security costs: the round trip of a message to another process and back, on a plain and
// on a secured network in turns, in the same run.
//
//   security_benchmark [--json FILE] [--round-trips N]
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "figures.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/keystore/keystore.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/node.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

using sensor_msgs::msg::Image;
namespace fs = std::filesystem;

constexpr auto kPatience = std::chrono::seconds(20);
constexpr auto kPause = std::chrono::milliseconds(2);  // messages come at the pace of a sensor
constexpr int kWarmUp = 20;

struct Network {
  std::uint32_t domain = 0;
  fs::path keystore;  // empty: plain
};

std::shared_ptr<Context> join(const Network& network, const char* enclave) {
  DdsOptions options{.domain_id = network.domain, .localhost_only = true, .enclave = enclave};
  options.security.enabled = !network.keystore.empty();
  options.security.enforce = true;
  options.security.keystore = network.keystore;
  return Context::create(create_dds_transport(options));
}

/// Sends back what it gets, until its parent ends.
int echo(const Network& network) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Executor executor;
  Node node({.context = join(network, "/echo"),
             .executor = &executor,
             .name = {"/", "echo"},
             .standard_interfaces = false});
  auto back = node.create_publisher<Image>("back", QoS::reliable());
  const auto there = node.create_subscription<Image>(
      "there", QoS::reliable(), [&](const Image& image) { back.publish(Image(image)); });
  executor.spin();
  return 0;
}

/// This process and one that echoes.
class Link {
 public:
  explicit Link(const Network& network) {
    const std::string domain = std::to_string(network.domain);
    const std::string keystore = network.keystore.string();
    child_ = fork();
    if (child_ == 0) {
      execl("/proc/self/exe", "security_benchmark", "--echo", domain.c_str(), "--keystore",
            keystore.c_str(), nullptr);
      _exit(127);
    }
    node_ = std::make_unique<Node>(NodeOptions{.context = join(network, "/source"),
                                               .executor = &executor_,
                                               .name = {"/", "source"},
                                               .standard_interfaces = false});
    there_ = node_->create_publisher<Image>("there", QoS::reliable());
    back_ = node_->create_subscription<Image>("back", QoS::reliable(), [this](const Image& image) {
      const std::lock_guard lock(mutex_);
      last_ = image.header.stamp.nanosec;
      arrived_.notify_all();
    });
    thread_ = std::make_unique<ExecutorThread>(executor_, ExecutorThread::Callbacks{});
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (round_trip(1, std::chrono::milliseconds(200)) < 0.0) {
      if (std::chrono::steady_clock::now() > deadline) {
        throw std::runtime_error("the other process does not answer");
      }
    }
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  ~Link() {
    thread_.reset();
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }

  /// In microseconds; negative when nothing came back in time.
  double round_trip(std::size_t bytes, std::chrono::nanoseconds at_most = kPatience) {
    auto image = std::make_unique<Image>();
    image->data = std::vector<std::uint8_t>(bytes, 0x5A);
    std::unique_lock lock(mutex_);
    image->header.stamp.nanosec = ++sent_;
    const auto start = monotonic_nanoseconds();
    lock.unlock();
    there_.publish(std::move(image));
    lock.lock();
    if (!arrived_.wait_for(lock, at_most, [&] { return last_ == sent_; })) {
      return -1.0;
    }
    return static_cast<double>(monotonic_nanoseconds() - start) * 1e-3;
  }

 private:
  pid_t child_ = -1;
  Executor executor_;
  std::unique_ptr<Node> node_;
  Publisher<Image> there_;
  Subscription<Image> back_;
  std::unique_ptr<ExecutorThread> thread_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::uint32_t sent_ = 0;
  std::uint32_t last_ = 0;
};

struct Case {
  const char* name;
  std::size_t bytes;
  const char* figure;
  double target;
};

Figures measure(const fs::path& folder, int round_trips) {
  const auto domain = static_cast<std::uint32_t>(1 + getpid() % 100);
  const Network plain{domain, {}};
  const Network secured{domain + 100, folder / "keystore"};
  const std::time_t now = std::time(nullptr);
  keystore::create_keystore(secured.keystore, secured.domain, 1, now);
  for (const char* const enclave : {"/source", "/echo"}) {
    keystore::create_enclave(secured.keystore,
                             {.name = enclave, .domain = secured.domain, .days = 1}, now);
  }
  Link plain_link(plain);
  Link secured_link(secured);
  Figures figures;
  for (const Case& one : {Case{"1 kB", 1024, "security_round_trip_1k_ratio", 1.5},
                          Case{"640x512 of 16 bits", std::size_t{640} * 512 * 2,
                               "security_round_trip_image_ratio", 2.0}}) {
    std::array<Samples, 2> samples;
    for (int turn = -kWarmUp; turn < round_trips; ++turn) {
      for (std::size_t kind = 0; kind < samples.size(); ++kind) {
        // No event: the pace of a sensor.
        std::this_thread::sleep_for(kPause);
        const double time = (kind == 0 ? plain_link : secured_link).round_trip(one.bytes);
        if (time < 0.0) {
          throw std::runtime_error(std::string(one.name) + ": a message was lost");
        }
        if (turn >= 0) {
          samples[kind].add(time);
        }
      }
    }
    for (std::size_t kind = 0; kind < samples.size(); ++kind) {
      figures.add_row({{"case", std::string(one.name) + (kind == 0 ? ", plain" : ", secured")},
                       {"median_us", samples[kind].median()},
                       {"p99_us", samples[kind].quantile(0.99)},
                       {"samples", samples[kind].size()}});
    }
    figures.add(one.figure, samples[1].median() / samples[0].median(), Figures::Bound::kAtMost,
                one.target);
  }
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  using namespace pipescout::benchmarks;
  CLI::App app("What DDS Security costs: round trips between two processes");
  std::string json;
  int round_trips = 500;
  Network echoed;
  std::string keystore;
  app.add_option("--json", json, "Write the figures to this file");
  app.add_option("--round-trips", round_trips, "Of each kind")->check(CLI::Range(1, 100'000));
  auto* const is_echo = app.add_option("--echo", echoed.domain)->group("");
  app.add_option("--keystore", keystore)->group("");
  CLI11_PARSE(app, argc, argv);
  if (is_echo->count() > 0) {
    echoed.keystore = keystore;
    return echo(echoed);
  }
  const fs::path folder =
      fs::temp_directory_path() / ("pipescout_security_" + std::to_string(getpid()));
  int code = 0;
  try {
    const Figures figures = measure(folder, round_trips);
    figures.print(std::cout);
    if (!json.empty()) {
      figures.write_json(json);
    }
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    code = 1;
  }
  fs::remove_all(folder);
  return code;
}
