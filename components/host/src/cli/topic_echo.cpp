// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "cli/message_text.hpp"
#include "cli/topic_commands.hpp"
#include "cli/topic_source.hpp"

namespace pipescout::host {
namespace {

struct EchoOptions : ListenOptions {
  std::string field;
  std::size_t count = 0;  ///< 0: endless
  bool once = false;
  bool csv = false;
  bool full_length = false;
  std::size_t length = *MessageFormat{}.truncate;
  MessageFormat format;
};

std::string shown(const EchoOptions& options, const MessageFormat& format, MessageView message) {
  std::string out;
  if (!options.field.empty()) {
    const auto field = find_field(message, options.field);
    const bool is_message =
        field.field().kind == FieldKind::kMessage && field.field().shape == FieldShape::kSingle;
    if (!options.csv || !is_message) {
      return to_text(field, format) + (options.csv ? "" : "---\n");
    }
    return to_csv(field.message(), format) + "\n";
  }
  return options.csv ? to_csv(message, format) + "\n" : to_yaml(message, format) + "---\n";
}

/// Fails now, and not with the first message, when the field does not exist.
void check_field(const MessageType& type, const std::string& path) {
  if (path.empty()) {
    return;
  }
  const auto message = type.create();
  try {
    static_cast<void>(find_field({&type, message.get()}, path));
  } catch (const std::invalid_argument& error) {
    throw CommandError("Invalid field '" + path + "': " + error.what());
  }
}

int echo_topic(Session& session, const EchoOptions& options) {
  const auto source = find_source(session, options);
  const auto& type = *source.type;
  check_field(type, options.field);

  auto format = options.format;
  format.truncate.reset();
  if (!options.full_length) {
    format.truncate = options.length;
  }
  const std::size_t wanted = options.once ? 1 : options.count;
  std::size_t seen = 0;
  SubscriptionEvents events;
  events.message_lost = [](EventCount lost) {
    std::cerr << "A message was lost!!!\n\ttotal count change:" << lost.change
              << "\n\ttotal count: " << lost.total << '\n';
  };
  events.message_malformed = [&](EventCount malformed) {
    std::cerr << "A message on topic '" << source.topic << "' is no " << type.name
              << " as defined here, and is not printed; total count: " << malformed.total << '\n';
  };
  events.incompatible_qos = [&](const IncompatibleQos& event) {
    std::cerr << "New publisher discovered on topic '" << source.topic
              << "', offering incompatible QoS. No messages will be received from it. Last "
                 "incompatible policy: "
              << to_string(event.policy) << '\n';
  };
  const auto subscription = session.node().create_untyped_subscription(
      source.topic, type, source.qos,
      [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
        if (wanted != 0 && seen == wanted) {
          return;
        }
        std::cout << shown(options, format, {&type, message.get()}) << std::flush;
        if (++seen == wanted || !std::cout) {
          session.executor().stop();
        }
      },
      {.events = std::move(events)});
  const TypeConflict conflict(session, source.topic, std::string(type.name));
  session.spin();
  conflict.throw_if_any();
  return kExitOk;
}

}  // namespace

void add_topic_echo(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<EchoOptions>(
      group, action, "echo", "Print the messages of a topic", false, echo_topic);
  options->add_to(*command);
  command->add_option("--field", options->field, "Print only this field, such as pose.position.x");
  command->add_flag("--once", options->once, "Print one message and exit");
  command->add_option("-n,--count", options->count, "Print this many messages and exit")
      ->check(count_range());
  command->add_flag("--csv", options->csv, "Values separated by commas");
  command->add_flag("-f,--full-length", options->full_length, "Print arrays and texts in full");
  command->add_option("-l,--truncate-length", options->length, "Truncate longer arrays and texts")
      ->capture_default_str();
  command->add_flag("--no-arr", options->format.no_arrays, "Print no arrays, only their length");
  command->add_flag("--no-str", options->format.no_strings, "Print no texts, only their length");
  command->add_flag("--flow-style", options->format.flow, "YAML in one line");
}

}  // namespace pipescout::host
