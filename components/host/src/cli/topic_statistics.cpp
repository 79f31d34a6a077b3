// SPDX-License-Identifier: Apache-2.0
#include <builtin_interfaces/msg/time.hpp>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "cli/topic_commands.hpp"
#include "cli/topic_source.hpp"
#include "core/rate_window.hpp"
#include "core/size_window.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::host {
namespace {

struct BandwidthOptions : ListenOptions {
  std::size_t window = 100;
};

/// Of `hz` and `delay`.
struct MessageOptions : ListenOptions {
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
  const auto source = find_raw_source(session, options);
  SizeWindow window(options.window);
  std::cout << "Subscribed to [" << source.topic << ']' << std::endl;
  const auto subscription = session.node().create_generic_subscription(
      source.topic, source.type, source.qos,
      [&](const std::shared_ptr<const SerializedMessage>& message, const MessageInfo&) {
        window.arrived(steady_now(), message->bytes().size());
      });
  const auto timer = print_each_second(session, [&] {
    const auto statistics = window.statistics(steady_now());
    return statistics ? to_string(*statistics) : std::string();
  });
  session.spin();
  return kExitOk;
}

int hz(Session& session, const MessageOptions& options) {
  const auto source = find_raw_source(session, options);
  RateWindow window(options.window);
  bool fresh = false;
  const auto subscription = session.node().create_generic_subscription(
      source.topic, source.type, source.qos,
      [&](const std::shared_ptr<const SerializedMessage>&, const MessageInfo&) {
        window.arrived(steady_now());
        fresh = true;
      });
  const auto timer = print_each_second(session, [&] {
    const auto statistics = std::exchange(fresh, false) ? window.statistics() : std::nullopt;
    return statistics ? to_string(*statistics) : std::string();
  });
  session.spin();
  return kExitOk;
}

int delay(Session& session, const MessageOptions& options) {
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

template <class Options>
void add_command(CLI::App& group, Action& action, const char* name, const char* description,
                 const char* window, int (*run)(Session&, const Options&)) {
  const auto [command, options] =
      add_session_command<Options>(group, action, name, description, false, run);
  options->add_to(*command);
  command->add_option("-w,--window", options->window, window)
      ->check(count_range())
      ->capture_default_str();
}

}  // namespace

void add_topic_statistics(CLI::App& group, Action& action) {
  add_command(group, action, "hz", "Print the rate at which messages arrive",
              "Number of messages in the average", hz);
  add_command(group, action, "bw", "Print the bytes that a topic carries per second",
              "Messages to average over", bandwidth);
  add_command(group, action, "delay", "Print how much later than stamped messages arrive",
              "Messages to average over", delay);
}

}  // namespace pipescout::host
