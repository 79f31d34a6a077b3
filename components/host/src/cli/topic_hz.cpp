// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "cli/topic_commands.hpp"
#include "core/rate_window.hpp"

namespace pipescout::host {
namespace {

struct Options : ListenOptions {
  std::size_t window = 10000;
};

int hz(Session& session, const Options& options) {
  const auto source = find_source(session, options);
  RateWindow window(options.window);
  bool fresh = false;
  const auto subscription = session.node().create_untyped_subscription(
      source.topic, *source.type, source.qos,
      [&](const std::shared_ptr<const void>&, const MessageInfo&) {
        window.arrived(steady_now());
        fresh = true;
      });
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
  session.spin();
  return kExitOk;
}

}  // namespace

void add_topic_hz(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<Options>(
      group, action, "hz", "Print the rate at which messages arrive", false, hz);
  options->add_to(*command);
  command->add_option("-w,--window", options->window, "Number of messages in the average")
      ->check(count_range())
      ->capture_default_str();
}

}  // namespace pipescout::host
