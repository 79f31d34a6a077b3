// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <tf2_msgs/msg/tf_message.hpp>

#include "cli/session.hpp"
#include "core/transform_text.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::host {
namespace {

using tf2_msgs::msg::TFMessage;

struct TransformOptions {
  DiscoveryOptions discovery;
  std::string ns = "/";  ///< of the robot
  std::string source;
  std::string target;
  double rate = 1.0;           ///< Hz
  std::size_t count = 0;       ///< 0: endless
  double gathering = 2.0;      ///< s
  double report_every = 10.0;  ///< s
};

/// A node in the namespace of the robot, whose transforms are its.
class Listener {
 public:
  Listener(Session& session, const TransformOptions& options)
      : node_({.context = session.node().context().shared_from_this(),
               .executor = &session.executor(),
               .name = {join_namespaces("/", options.ns), session.node().node_name().name + "_tf"},
               .standard_interfaces = false}) {}

  [[nodiscard]] Node& node() { return node_; }
  [[nodiscard]] Transforms& transforms() { return node_.transforms(); }

 private:
  Node node_;
};

std::string publisher_name(Session& session, const Gid& gid) {
  for (const GraphEndpoint& endpoint : session.graph().endpoints()) {
    if (endpoint.gid == gid && endpoint.node) {
      return endpoint.node->fully_qualified();
    }
  }
  return "an unknown node";
}

std::string tree(Session& session, Listener& listener) {
  return to_tree(listener.transforms().buffer().frames(),
                 [&session](const Gid& gid) { return publisher_name(session, gid); });
}

int echo(Session& session, const TransformOptions& options) {
  Listener listener(session, options);
  std::size_t printed = 0;
  bool failed = false;
  const auto print = [&] {
    // As tf2_echo: the frame named first is the one in which the other is shown.
    const TransformResult result = listener.transforms().lookup(options.source, options.target);
    if (result) {
      std::cout << to_echo(*result) << std::flush;
      failed = false;
      ++printed;
    } else if (!std::exchange(failed, true)) {
      std::cerr << result.failure().text << "\nKnown frames:\n" << tree(session, listener);
    }
    if ((options.count != 0 && printed == options.count) || !std::cout) {
      session.executor().stop();
    }
  };
  // The first one as soon as it is known; then at the rate.
  std::shared_ptr<Timer> timer;
  const auto begin = [&] {
    print();
    timer = listener.node().create_timer(from_seconds(1 / options.rate), print);
  };
  const auto wait = listener.transforms().wait_for(options.source, options.target, kLatestTransform,
                                                   from_seconds(options.discovery.spin_time),
                                                   [&](const TransformResult&) { begin(); });
  session.spin();
  return failed ? kExitError : kExitOk;
}

int show_tree(Session& session, const TransformOptions& options) {
  Listener listener(session, options);
  (void)listener.transforms();
  session.settle();
  session.spin_for(from_seconds(options.gathering));
  const std::string text = tree(session, listener);
  if (text.empty()) {
    throw CommandError("nobody sends transforms on " +
                       listener.node().resolve_topic(topics::kTf.name) + " or " +
                       listener.node().resolve_topic(topics::kTfStatic.name));
  }
  std::cout << text << std::flush;
  for (const auto& [fault, total] : listener.transforms().statistics().refused) {
    std::cerr << "refused, " << to_string(fault) << ": " << total << '\n';
  }
  if (const auto statistics = listener.transforms().statistics();
      !statistics.last_refused.empty()) {
    std::cerr << "the last one: " << statistics.last_refused << '\n';
  }
  return kExitOk;
}

/// Delays by frame and by publisher.
class Monitor {
 public:
  explicit Monitor(Session& session) : session_(session) {}

  void take(const TFMessage& message, const MessageInfo& info, Time now) {
    const SteadyTime arrival = steady_now();
    double sum = 0;
    for (const auto& transform : message.transforms) {
      const double delay = to_seconds(now - from_message(transform.header.stamp));
      sum += delay;
      Frame& frame = frames_[transform.child_frame_id];
      frame.delays.add(delay, arrival);
      frame.publisher = info.identity.writer;
    }
    if (!message.transforms.empty()) {
      publishers_[info.identity.writer].add(sum / static_cast<double>(message.transforms.size()),
                                            arrival);
    }
  }

  [[nodiscard]] std::string report() const {
    std::string out = "\nRESULTS: for all Frames\n\nFrames:\n";
    for (const auto& [name, frame] : frames_) {
      out += "Frame: " + name + ", published by " + publisher_name(session_, frame.publisher) +
             ", Average Delay: " + number(frame.delays.average()) +
             ", Max Delay: " + number(frame.delays.most()) + "\n";
    }
    out += "\nAll Broadcasters:\n";
    for (const auto& [gid, delays] : publishers_) {
      out += "Node: " + publisher_name(session_, gid) + " " + number(delays.rate()) +
             " Hz, Average Delay: " + number(delays.average()) +
             " Max Delay: " + number(delays.most()) + "\n";
    }
    return out;
  }

 private:
  struct Frame {
    DelayStatistics delays;
    Gid publisher;
  };

  static std::string number(double value) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value);
    return text.data();
  }

  Session& session_;
  std::map<std::string, Frame> frames_;
  std::map<Gid, DelayStatistics> publishers_;
};

int monitor(Session& session, const TransformOptions& options) {
  Listener listener(session, options);
  Monitor all(session);
  const auto take = [&](const TFMessage& message, const MessageInfo& info) {
    all.take(message, info, listener.node().now());
  };
  const auto tf = listener.node().create_subscription(topics::kTf, take);
  const auto tf_static = listener.node().create_subscription(topics::kTfStatic, take);
  std::size_t reports = 0;
  const auto timer = listener.node().create_timer(from_seconds(options.report_every), [&] {
    std::cout << all.report() << std::flush;
    if (++reports == options.count || !std::cout) {
      session.executor().stop();
    }
  });
  session.spin();
  return kExitOk;
}

}  // namespace

void add_tf_commands(CLI::App& app, Action& action) {
  auto* const group = app.add_subcommand("tf", "Transforms between frames");
  group->require_subcommand(1);
  const auto add_common = [](CLI::App* command, const std::shared_ptr<TransformOptions>& options) {
    command->add_option("--namespace", options->ns, "Of the robot, whose tf and tf_static are read")
        ->capture_default_str();
  };
  const auto add_count = [](CLI::App* command, const std::shared_ptr<TransformOptions>& options) {
    command->add_option("-n,--count", options->count, "Print so many and exit")
        ->check(count_range());
  };

  const auto [echo_command, echo_options] = add_session_command<TransformOptions>(
      *group, action, "echo", "Print the transform between two frames", false, echo);
  add_common(echo_command, echo_options);
  add_count(echo_command, echo_options);
  echo_command->add_option("source_frame", echo_options->source, "Frame in which it is shown")
      ->required();
  echo_command->add_option("target_frame", echo_options->target, "Frame that is shown")->required();
  echo_command->add_option("rate", echo_options->rate, "Hz")
      ->check(CLI::Range(0.001, 1000.0))
      ->capture_default_str();

  const auto [tree_command, tree_options] = add_session_command<TransformOptions>(
      *group, action, "tree", "Print the trees of frames, and who sends them", false, show_tree);
  add_common(tree_command, tree_options);
  tree_command->add_option("--gather", tree_options->gathering, "s for which to listen")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();

  const auto [monitor_command, monitor_options] = add_session_command<TransformOptions>(
      *group, action, "monitor", "Print rates and delays of transforms, and who sends them", false,
      monitor);
  add_common(monitor_command, monitor_options);
  add_count(monitor_command, monitor_options);
  monitor_command->add_option("--every", monitor_options->report_every, "s between two reports")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

}  // namespace pipescout::host
