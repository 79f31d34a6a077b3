// SPDX-License-Identifier: Apache-2.0
#include <builtin_interfaces/msg/time.hpp>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "cli/topic_commands.hpp"
#include "core/size_window.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::host {
namespace {

struct BandwidthOptions : ListenOptions {
  std::size_t window = 100;
};

struct DelayOptions : ListenOptions {
  std::size_t window = 10000;
};

/// Calls `report` each second, and prints what it returns; ends when nobody reads any more.
template <class Report>
std::shared_ptr<Timer> print_each_second(Session& session, Report report) {
  return session.node().create_timer(std::chrono::seconds(1), [&session, report] {
    const std::string text = report();
    if (!text.empty()) {
      std::cout << text << std::endl;
    }
    if (!std::cout) {
      session.executor().stop();
    }
  });
}

int bandwidth(Session& session, const BandwidthOptions& options) {
  const auto source = find_source(session, options);
  SizeWindow window(options.window);
  std::cout << "Subscribed to [" << source.topic << ']' << std::endl;
  const auto subscription = session.node().create_untyped_subscription(
      source.topic, *source.type, source.qos,
      [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
        window.arrived(steady_now(), source.type->serialized_size(message.get()));
      });
  const auto timer = print_each_second(session, [&] {
    const auto statistics = window.statistics(steady_now());
    return statistics ? to_string(*statistics) : std::string();
  });
  session.spin();
  return kExitOk;
}

int delay(Session& session, const DelayOptions& options) {
  const auto source = find_source(session, options);
  const auto example = source.type->create();
  try {
    const auto stamp = find_field({source.type, example.get()}, "header.stamp");
    if (stamp.field().kind != FieldKind::kMessage ||
        stamp.field().message().name != message_type<builtin_interfaces::msg::Time>().name) {
      throw std::invalid_argument("no time");
    }
  } catch (const std::invalid_argument&) {
    throw CommandError("msg does not have header: " + std::string(source.type->name));
  }
  DelayWindow window(options.window);
  bool fresh = false;
  const auto subscription = session.node().create_untyped_subscription(
      source.topic, *source.type, source.qos,
      [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
        const auto stamp = find_field({source.type, message.get()}, "header.stamp");
        const auto& time =
            *static_cast<const builtin_interfaces::msg::Time*>(stamp.message().message);
        window.arrived(session.node().now() - from_message(time));
        fresh = true;
      });
  const auto timer = print_each_second(session, [&] {
    const auto statistics = std::exchange(fresh, false) ? window.statistics() : std::nullopt;
    return statistics ? to_string(*statistics) : std::string();
  });
  session.spin();
  return kExitOk;
}

}  // namespace

void add_topic_statistics(CLI::App& group, Action& action) {
  const auto [bw_command, bw_options] = add_session_command<BandwidthOptions>(
      group, action, "bw", "Print the bytes that a topic carries per second", false, bandwidth);
  bw_options->add_to(*bw_command);
  bw_command->add_option("-w,--window", bw_options->window, "Messages to average over")
      ->check(count_range())
      ->capture_default_str();

  const auto [delay_command, delay_options] = add_session_command<DelayOptions>(
      group, action, "delay", "Print how much later than stamped messages arrive", false, delay);
  delay_options->add_to(*delay_command);
  delay_command->add_option("-w,--window", delay_options->window, "Messages to average over")
      ->check(count_range())
      ->capture_default_str();
}

}  // namespace pipescout::host
