// SPDX-License-Identifier: Apache-2.0
#include "transform_cases.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/transform_buffer.hpp"
#include "samples.hpp"
#include "tf2_peer.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr std::uint64_t kSeed = 1101;
constexpr std::int64_t kHistory = 10'000'000'000;  // ns
constexpr std::int64_t kPeriod = 10'000'000;       // ns, each frame moves at 100 Hz
constexpr std::int64_t kStart = 1'000'000'000'000;
constexpr std::size_t kLookups = 2000;  // of a repetition
constexpr std::size_t kMessages = 2000;
constexpr int kTransformsOfMessage = 10;

/// When lookups ask for a transform.
enum class Asked {
  kLatest,  ///< the latest common one, as most programs ask
  kRecent,  ///< in the last 200 ms: a picture that was just taken
  kAny      ///< anywhere in the history
};

struct Case {
  std::string name;
  int depth = 0;
  Asked asked{};
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> result;
    for (const int depth : {3, 10}) {
      for (const auto& [asked, text] :
           {std::pair(Asked::kLatest, "latest"), std::pair(Asked::kRecent, "last 200 ms"),
            std::pair(Asked::kAny, "any time")}) {
        result.push_back(
            {"transform lookup, depth " + std::to_string(depth) + ", " + text, depth, asked});
      }
    }
    return result;
  }();
  return all;
}

std::string link(int number) {
  return "link_" + std::to_string(number);
}

/// Both buffers with one chain of joints that swing.
struct Chain {
  explicit Chain(int depth) : target(link(0)), source(link(depth)), theirs(kHistory) {
    for (std::int64_t time = 0; time <= kHistory; time += kPeriod) {
      for (int joint = 0; joint < depth; ++joint) {
        const double angle = 0.3 * std::sin(1e-9 * static_cast<double>(time) + joint);
        const Tf2Peer::Pose pose{{angle, 1, 0}, {0, 0, std::sin(angle), std::cos(angle)}};
        theirs.insert(link(joint), link(joint + 1), kStart + time, pose, false);
        geometry_msgs::msg::TransformStamped message;
        message.header.stamp = to_message(Time(Duration(kStart + time)));
        message.header.frame_id = link(joint);
        message.child_frame_id = link(joint + 1);
        message.transform.translation.x = angle;
        message.transform.translation.y = 1;
        message.transform.rotation.z = std::sin(angle);
        message.transform.rotation.w = std::cos(angle);
        ours.insert(message, false);
      }
    }
  }

  const std::string target;
  const std::string source;
  TransformBuffer ours;
  Tf2Peer theirs;
};

std::vector<std::int64_t> times(Asked asked) {
  std::mt19937_64 engine(kSeed);
  const auto within =
      asked == Asked::kRecent ? std::uint64_t{200'000'000} : std::uint64_t{kHistory};
  std::vector<std::int64_t> result;
  for (std::size_t i = 0; i < kLookups; ++i) {
    const auto before = static_cast<std::int64_t>(engine() % within);
    result.push_back(asked == Asked::kLatest ? 0 : kStart + kHistory - before);
  }
  return result;
}

/// One sample a repetition: ns of this thread's processor for a lookup.
template <class Lookup>
void register_lookups(const std::string& name, Asked asked, Lookup lookup) {
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    const std::vector<std::int64_t> asked_times = times(asked);
    for (auto _ : state) {
      const std::int64_t begin = thread_cpu_nanoseconds();
      for (const std::int64_t time : asked_times) {
        benchmark::DoNotOptimize(lookup(time));
      }
      all_samples()[name].add(static_cast<double>(thread_cpu_nanoseconds() - begin) /
                              static_cast<double>(kLookups));
    }
  });
}

std::string components_case(int components) {
  return "tf messages, " + std::to_string(components) + " components that use transforms";
}

/// What it takes to publish transforms to a process of so many components: the callbacks that take
/// them run on the publisher's thread, so no cost of the network hides the difference.
void register_components(int components) {
  const std::string name = components_case(components);
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    Executor executor;
    const auto context = Context::create_in_process();
    std::vector<std::unique_ptr<Node>> nodes;
    for (int i = 0; i < components; ++i) {
      nodes.push_back(std::make_unique<Node>(
          NodeOptions{.context = context, .executor = &executor, .name = {"/", link(i)}}));
      (void)nodes.back()->transforms();
    }
    Node source({.context = context, .executor = &executor, .name = {"/", "source"}});
    const auto publisher = source.create_publisher(topics::kTf);
    std::int64_t time = kStart;
    for (auto _ : state) {
      std::vector<std::shared_ptr<const tf2_msgs::msg::TFMessage>> messages;
      for (std::size_t i = 0; i < kMessages; ++i) {
        auto message = std::make_shared<tf2_msgs::msg::TFMessage>();
        time += kPeriod;
        for (int joint = 0; joint < kTransformsOfMessage; ++joint) {
          auto& transform = message->transforms.emplace_back();
          transform.header.stamp = to_message(Time(Duration(time)));
          transform.header.frame_id = link(joint);
          transform.child_frame_id = link(joint + 1);
          transform.transform.rotation.w = 1;
        }
        messages.push_back(std::move(message));
      }
      const std::int64_t begin = thread_cpu_nanoseconds();
      for (const auto& message : messages) {
        publisher.untyped()->publish(message, {});
      }
      all_samples()[name].add(static_cast<double>(thread_cpu_nanoseconds() - begin) /
                              static_cast<double>(kMessages));
    }
  });
}

constexpr int kManyComponents = 20;

}  // namespace

void register_transform_cases() {
  for (const Case& each : cases()) {
    const auto chain = std::make_shared<Chain>(each.depth);
    register_lookups(each.name, each.asked, [chain](std::int64_t time) {
      return chain->ours.lookup(chain->target, chain->source, Time(Duration(time)));
    });
    register_lookups(each.name + ", tf2", each.asked, [chain](std::int64_t time) {
      Tf2Peer::Pose pose;
      (void)chain->theirs.lookup(chain->target, chain->source, time, pose);
      return pose;
    });
  }
  register_components(1);
  register_components(kManyComponents);
}

void add_transform_figures(Figures& figures) {
  auto& samples = all_samples();
  double worst = 0;
  for (const Case& each : cases()) {
    const double ours = samples[each.name].median();
    const double theirs = samples[each.name + ", tf2"].median();
    figures.add_row(
        {{"case", each.name}, {"ns", ours}, {"tf2 ns", theirs}, {"ratio", ours / theirs}});
    worst = std::max(worst, ours / theirs);
  }
  const double one = samples[components_case(1)].median();
  const double many = samples[components_case(kManyComponents)].median();
  figures.add_row({{"case", components_case(1)}, {"ns a message", one}});
  figures.add_row({{"case", components_case(kManyComponents)}, {"ns a message", many}});
  // The worst of depths and times.
  figures.add("transform_lookup_ratio", worst, Figures::Bound::kAtMost, 0.5);
  figures.add("transform_components_cpu_ratio", many / one, Figures::Bound::kAtMost, 1.2);
  figures.add_seed(kSeed);
}

}  // namespace pipescout::benchmarks
