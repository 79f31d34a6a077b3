// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "cli/message_text.hpp"
#include "cli/topic_commands.hpp"
#include "run/stop_signals.hpp"

namespace pipescout::host {
namespace {

struct Options {
  DiscoveryOptions discovery;
  std::string topic;
  std::string type;
  QosOptions qos;
  std::string field;
  std::size_t count = 0;  ///< 0: endless
  bool once = false;
  bool csv = false;
  bool full_length = false;
  MessageFormat format;
};

std::string shown(const Options& options, const DynamicMessage& message) {
  std::string out;
  if (!options.field.empty()) {
    const auto field = find_field(message, options.field);
    const auto* nested = std::get_if<std::shared_ptr<const DynamicMessage>>(field.value);
    if (!options.csv || nested == nullptr) {
      return to_text(field, options.format) + (options.csv ? "" : "---\n");
    }
    return to_csv(**nested, options.format) + "\n";
  }
  return options.csv ? to_csv(message, options.format) + "\n"
                     : to_yaml(message, options.format) + "---\n";
}

/// Fails before anything is waited for when the field does not exist.
void check_field(const std::shared_ptr<const MessageDescription>& description,
                 const MessageType& type, const std::string& path) {
  if (path.empty()) {
    return;
  }
  const auto message = type.create();
  std::vector<std::byte> bytes(type.serialized_size(message.get()));
  bytes.resize(type.serialize(message.get(), bytes));
  try {
    static_cast<void>(find_field(read_message(description, bytes), path));
  } catch (const std::invalid_argument& error) {
    throw CommandError("Invalid field '" + path + "': " + error.what());
  }
}

int echo(const Options& options) {
  const auto topic = topic_name(options.topic);
  StopSignals::block();
  Session session(options.discovery);
  const auto& type = topic_type(session, topic, options.type);
  const auto description = MessageDescriptions::installed().find(type.name);
  check_field(description, type, options.field);
  if (options.type.empty()) {
    // All publishers, before a QoS is chosen that must match them.
    session.settle(std::chrono::milliseconds(100));
  }
  const auto qos = choose_qos(session.graph(), topic, options.qos);

  const std::size_t wanted = options.once ? 1 : options.count;
  std::size_t seen = 0;
  SubscriptionEvents events;
  events.message_lost = [](EventCount lost) {
    std::cerr << "A message was lost!!!\n\ttotal count change:" << lost.change
              << "\n\ttotal count: " << lost.total << '\n';
  };
  events.incompatible_qos = [&](const IncompatibleQos& event) {
    std::cerr << "New publisher discovered on topic '" << topic
              << "', offering incompatible QoS. No messages will be received from it. Last "
                 "incompatible policy: "
              << to_string(event.policy) << '\n';
  };
  std::vector<std::byte> bytes;
  const auto subscription = session.node().create_untyped_subscription(
      topic, type, qos,
      [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
        if (wanted != 0 && seen == wanted) {
          return;
        }
        bytes.resize(type.serialized_size(message.get()));
        bytes.resize(type.serialize(message.get(), bytes));
        std::cout << shown(options, read_message(description, bytes)) << std::flush;
        if (++seen == wanted || !std::cout) {
          session.executor().stop();
        }
      },
      std::move(events), {});
  const StopSignals signals(
      std::chrono::seconds(2), [&](int) { session.executor().stop(); }, [] {});
  session.executor().spin();
  return kExitOk;
}

}  // namespace

void add_topic_echo(CLI::App& group, Action& action) {
  auto options = std::make_shared<Options>();
  auto* command = group.add_subcommand("echo", "Print the messages of a topic");
  command->add_option("topic", options->topic, "Name of the topic")->required();
  command->add_option("type", options->type, "Its type, when nobody publishes yet");
  command->add_option("--field", options->field, "Print only this field, such as pose.position.x");
  command->add_flag("--once", options->once, "Print one message and exit");
  command->add_option("-n,--count", options->count, "Print so many messages and exit")
      ->check(CLI::PositiveNumber);
  command->add_flag("--csv", options->csv, "Values separated by commas");
  command->add_flag("-f,--full-length", options->full_length,
                    "Print arrays and texts in full, however long");
  auto length = std::make_shared<std::size_t>(*options->format.truncate);
  command
      ->add_option("-l,--truncate-length", *length,
                   "Cut arrays and texts that are longer than this")
      ->capture_default_str();
  command->add_flag("--no-arr", options->format.no_arrays, "Print no arrays, only their length");
  command->add_flag("--no-str", options->format.no_strings, "Print no texts, only their length");
  command->add_flag("--flow-style", options->format.flow, "YAML in one line");
  options->qos.add_to(*command);
  options->discovery.add_to(*command, false);
  command->callback([=, &action] {
    options->format.truncate.reset();
    if (!options->full_length) {
      options->format.truncate = *length;
    }
    action = [=] { return echo(*options); };
  });
}

}  // namespace pipescout::host
