// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "cli/topic_commands.hpp"
#include "core/rate_window.hpp"
#include "run/stop_signals.hpp"

namespace pipescout::host {
namespace {

struct Options {
  DiscoveryOptions discovery;
  std::string topic;
  std::string type;
  QosOptions qos;
  std::size_t window = 10000;
};

int hz(const Options& options) {
  const auto topic = topic_name(options.topic);
  StopSignals::block();
  Session session(options.discovery);
  const auto& type = topic_type(session, topic, options.type);
  if (options.type.empty()) {
    session.settle(std::chrono::milliseconds(100));
  }
  const auto qos = choose_qos(session.graph(), topic, options.qos);
  RateWindow window(options.window);
  bool fresh = false;
  const auto subscription = session.node().create_untyped_subscription(
      topic, type, qos,
      [&](const std::shared_ptr<const void>&, const MessageInfo&) {
        window.arrived(std::chrono::steady_clock::now());
        fresh = true;
      },
      {}, {});
  const auto timer = session.node().create_timer(std::chrono::seconds(1), [&] {
    const auto statistics = window.statistics();
    if (fresh && statistics) {
      std::cout << to_string(*statistics) << std::endl;
    }
    fresh = false;
    if (!std::cout) {
      session.executor().stop();
    }
  });
  const StopSignals signals(
      std::chrono::seconds(2), [&](int) { session.executor().stop(); }, [] {});
  session.executor().spin();
  return kExitOk;
}

}  // namespace

void add_topic_hz(CLI::App& group, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = group.add_subcommand("hz", "Print the rate at which messages arrive");
  command->add_option("topic", options->topic, "Name of the topic")->required();
  command->add_option("type", options->type, "Its type, when nobody publishes yet");
  command->add_option("-w,--window", options->window, "Messages to average over")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  options->qos.add_to(*command);
  options->discovery.add_to(*command, false);
  command->callback([=, &action] { action = [=] { return hz(*options); }; });
}

}  // namespace pipescout::host
