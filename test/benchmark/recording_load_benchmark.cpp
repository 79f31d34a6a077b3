// SPDX-License-Identifier: Apache-2.0
// A robot that is recorded: 640x512 images of 16 bits at 60 Hz, colour images of 6 MB at 10 Hz and
// 20 topics at 200 Hz, from one process to a listener in another, for a minute without a recorder
// and for a minute with `pipescout bag record` beside the listener. What the recording lacks, and
// what it costs the publisher.
//
//   recording_load_benchmark [--json FILE] [--seconds S] [--folder DIR]
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <deque>
#include <filesystem>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "figures.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/node.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

namespace fs = std::filesystem;

constexpr const char* kType = "load_msgs/msg/Blob";  // nobody needs to know it
constexpr std::size_t kSmallTopics = 20;
constexpr Duration kTick = std::chrono::milliseconds(5);
constexpr Duration kPatience = std::chrono::seconds(60);
/// In which the last messages arrive.
constexpr std::chrono::seconds kAfterwards{2};

enum Class { kSmall, kThermal, kColour, kClasses };
constexpr std::array<const char*, kClasses> kClassNames{"small, 200 Hz", "655 kB, 60 Hz",
                                                        "6 MB, 10 Hz"};

struct Source {
  Class kind;
  std::string name;
  std::size_t bytes;
};

std::vector<Source> sources() {
  std::vector<Source> all;
  for (std::size_t i = 0; i < kSmallTopics; ++i) {
    all.push_back({kSmall, "/load/small_" + std::to_string(i), 100 + 95 * i});
  }
  all.push_back({kThermal, "/load/thermal", std::size_t{640} * 512 * 2});
  all.push_back({kColour, "/load/colour", 6'000'000});
  return all;
}

std::shared_ptr<Context> join(const char* name) {
  auto options = DdsOptions::from_environment();
  options.name = name;
  return Context::create(create_dds_transport(options));
}

/// A process that ends with this object.
class Child {
 public:
  explicit Child(std::vector<std::string> command) {
    pid_ = fork();
    if (pid_ == 0) {
      std::vector<char*> arguments;
      for (auto& word : command) {
        arguments.push_back(word.data());
      }
      arguments.push_back(nullptr);
      execvp(arguments[0], arguments.data());
      _exit(127);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { static_cast<void>(end()); }

  /// Asks it to end, waits, and returns its exit code.
  int end() {
    if (pid_ > 0) {
      int status = 0;
      kill(pid_, SIGINT);
      waitpid(pid_, &status, 0);
      pid_ = -1;
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    return code_;
  }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
};

/// What a consumer costs, whatever it does with the messages.
int listen() {
  sigset_t stop;
  sigemptyset(&stop);
  sigaddset(&stop, SIGINT);
  pthread_sigmask(SIG_BLOCK, &stop, nullptr);
  Executor executor;
  Node node({.context = join("listener"), .executor = &executor, .name = {"/", "listener"}});
  std::vector<GenericSubscription> subscriptions;
  for (const Source& source : sources()) {
    subscriptions.push_back(node.create_generic_subscription(
        source.name, kType, QoS::reliable(), [](const SerializedMessage&) {}, {.at_once = true}));
  }
  const ExecutorThread thread(executor, {});
  int signal = 0;
  sigwait(&stop, &signal);
  return 0;
}

/// Publishes for a while, and keeps how long each call took.
class Publishing {
 public:
  Publishing() : node_({.context = join("load"), .executor = &executor_, .name = {"/", "load"}}) {
    for (const Source& source : sources()) {
      auto message = std::make_shared<SerializedMessage>(source.bytes);
      const auto bytes = message->bytes();
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::byte>(i * 31 + i / 251);
      }
      bytes[0] = std::byte{0};
      bytes[1] = std::byte{1};
      topics_.push_back({source, std::move(message),
                         node_.create_generic_publisher(source.name, kType, QoS::reliable())});
    }
  }

  /// False when so many readers do not come.
  bool await_readers(int readers) {
    return node_.context().graph().wait_until(
        [&] {
          return std::all_of(topics_.begin(), topics_.end(), [&](const Topic& topic) {
            return topic.publisher.untyped()->remote_subscription_count() >= readers;
          });
        },
        kPatience);
  }

  void run(std::chrono::seconds length) {
    times_ = {};
    counts_.clear();
    std::int64_t tick = 0;
    const std::int64_t ticks = length / kTick;
    const auto timer = node_.create_timer(kTick, [&] {
      for (Topic& topic : topics_) {
        const bool due = topic.source.kind == kSmall ||
                         (topic.source.kind == kColour && tick % 20 == 0) ||
                         (topic.source.kind == kThermal && tick * 3 / 10 != (tick + 1) * 3 / 10);
        if (due) {
          const auto begin = monotonic_nanoseconds();
          topic.publisher.publish(topic.message);
          times_[topic.source.kind].add(static_cast<double>(monotonic_nanoseconds() - begin) / 1e3);
          ++counts_[topic.source.name];
        }
      }
      if (++tick == ticks) {
        executor_.stop();
      }
    });
    executor_.spin();
  }

  [[nodiscard]] const std::array<Samples, kClasses>& times() const { return times_; }
  [[nodiscard]] const std::map<std::string, std::uint64_t>& counts() const { return counts_; }

 private:
  struct Topic {
    Source source;
    std::shared_ptr<const SerializedMessage> message;
    GenericPublisher publisher;
  };

  Executor executor_;
  Node node_;
  std::deque<Topic> topics_;
  std::array<Samples, kClasses> times_;
  std::map<std::string, std::uint64_t> counts_;
};

Figures measure(const std::string& self, std::chrono::seconds length, const fs::path& folder) {
  const fs::path bag = folder / "bag";
  Child listener({self, "--listen"});
  Publishing publishing;
  if (!publishing.await_readers(1)) {
    throw std::runtime_error("the listener does not come");
  }
  publishing.run(length);
  const auto alone = publishing.times();

  Child recorder({"pipescout", "bag", "record", "-s", "mcap", "-o", bag.string(), "-e", "^/load/"});
  if (!publishing.await_readers(2)) {
    throw std::runtime_error("the recorder does not come");
  }
  publishing.run(length);
  std::this_thread::sleep_for(kAfterwards);
  if (recorder.end() != 0) {
    throw std::runtime_error("the recorder has failed");
  }

  std::map<std::string, std::uint64_t> recorded;
  bags::BagReader reader(bag);
  while (const auto message = reader.next()) {
    ++recorded[reader.topics().at(message->topic).name];
  }
  double missing = 0.0;
  double published = 0.0;
  for (const auto& [topic, count] : publishing.counts()) {
    published += static_cast<double>(count);
    missing += static_cast<double>(count) - static_cast<double>(recorded[topic]);
  }

  Figures figures;
  double worst = 0.0;
  for (int kind = 0; kind < kClasses; ++kind) {
    const auto& before = alone[static_cast<std::size_t>(kind)];
    const auto& with = publishing.times()[static_cast<std::size_t>(kind)];
    const double ratio = with.quantile(0.99) / before.quantile(0.99);
    worst = std::max(worst, ratio);
    figures.add_row({{"case", kClassNames[static_cast<std::size_t>(kind)]},
                     {"publish_99_us", before.quantile(0.99)},
                     {"publish_99_us_recorded", with.quantile(0.99)},
                     {"publish_median_us", before.median()},
                     {"publish_median_us_recorded", with.median()},
                     {"ratio_99", ratio}});
  }
  figures.add("record_messages", published);
  figures.add("record_dropped", missing, Figures::Bound::kAtMost, 0.0);
  figures.add("record_publish_99_ratio", worst, Figures::Bound::kAtMost, 1.2);
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  using namespace pipescout::benchmarks;
  CLI::App app("What a recording lacks, and what it costs the publisher");
  std::string json;
  std::string folder;
  int seconds = 60;
  bool is_listener = false;
  app.add_option("--json", json, "Write the figures to this file");
  app.add_option("--seconds", seconds, "Of each of the two runs")->check(CLI::Range(1, 3600));
  app.add_option("--folder", folder, "Where the bag is written; default: the temporary folder");
  app.add_flag("--listen", is_listener)->group("");
  CLI11_PARSE(app, argc, argv);
  if (is_listener) {
    return listen();
  }
  const bool is_temporary = folder.empty();
  const std::filesystem::path path = is_temporary
                                         ? std::filesystem::temp_directory_path() /
                                               ("pipescout_recording_" + std::to_string(getpid()))
                                         : std::filesystem::path(folder);
  int code = 0;
  try {
    std::filesystem::create_directories(path);
    const auto figures = measure(std::filesystem::read_symlink("/proc/self/exe").string(),
                                 std::chrono::seconds(seconds), path);
    figures.print(std::cout);
    if (!json.empty()) {
      figures.write_json(json);
    }
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    code = 1;
  }
  if (is_temporary) {
    std::filesystem::remove_all(path);
  }
  return code;
}
