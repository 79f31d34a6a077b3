// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <utility>

#include "cli/message_text.hpp"
#include "cli/topic_commands.hpp"
#include "cli/topic_source.hpp"
#include "cli/yaml_message.hpp"

namespace pipescout::host {
namespace {

struct PubOptions {
  DiscoveryOptions discovery;
  std::string topic;
  std::string type;
  std::string values;
  QosOptions qos;
  double rate = 1.0;      ///< Hz
  std::size_t print = 1;  ///< each so many-th message is printed
  std::size_t times = 0;  ///< 0: endless
  bool once = false;
  std::optional<std::size_t> wait_matching;
  double keep_alive = 0.1;  ///< s
};

QoS chosen_qos(const QosOptions& options) {
  // As `ros2 topic pub` has it: reliable, and for who comes later.
  QoS qos = QoS::reliable(1);
  qos.durability = Durability::kTransientLocal;
  if (options.profile == "sensor_data") {
    qos = QoS::sensor_data();
  } else if (options.profile == "services_default") {
    qos = QoS::services();
  } else if (options.profile == "parameters") {
    qos = QoS::parameters();
  } else if (!options.profile.empty()) {
    qos = QoS::reliable();
  }
  options.override(qos);
  return qos;
}

int publish(Session& session, const PubOptions& options) {
  const auto topic = topic_name(options.topic);
  const MessageType* type = nullptr;
  try {
    type = &load_message_type(full_type_name(options.type));
  } catch (const MessageTypeError& error) {
    throw CommandError(error.what());
  }
  const std::shared_ptr<void> message = type->create();
  try {
    set_from_yaml(options.values, *type, message.get());
  } catch (const YamlMessageError& error) {
    throw CommandError("Failed to populate field: " + std::string(error.what()));
  }
  // Told of a match, the executor looks again whether there are enough.
  const auto publisher = session.node().create_untyped_publisher(
      topic, *type, chosen_qos(options.qos), {.events = {.matched = [](std::size_t) {}}});
  const TypeConflict conflict(session, topic, std::string(type->name));
  const std::size_t times = options.once ? 1 : options.times;
  const auto matching = options.wait_matching.value_or(times != 0 ? 1 : 0);
  if (publisher->subscription_count() < matching) {
    std::cout << "Waiting for at least " << matching << " matching subscription(s)..." << std::endl;
    session.spin_until([&] { return publisher->subscription_count() >= matching; });
    conflict.throw_if_any();
  }
  const auto text = to_yaml({type, message.get()}, {.truncate = std::nullopt, .flow = true});
  std::cout << "publisher: beginning loop" << std::endl;
  std::size_t count = 0;
  const auto publish_one = [&] {
    if (count == times && times != 0) {
      return;
    }
    ++count;
    if (options.print != 0 && (count - 1) % options.print == 0) {
      std::cout << "publishing #" << count << ": " << text << std::flush;
    }
    publisher->publish(message, {});
  };
  publish_one();
  const auto timer = session.node().create_timer(from_seconds(1.0 / options.rate), publish_one);
  session.spin_until([&] { return (times != 0 && count == times) || !std::cout; });
  conflict.throw_if_any();
  if (times != 0) {
    // A message that is on its way when its publisher goes may not arrive.
    session.spin_for(from_seconds(options.keep_alive));
  }
  return kExitOk;
}

}  // namespace

void add_topic_pub(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<PubOptions>(
      group, action, "pub", "Publish a message to a topic", false, publish);
  command->add_option("topic", options->topic, "Name of the topic")->required();
  command->add_option("type", options->type, "Its type, such as std_msgs/msg/String")->required();
  command->add_option("values", options->values,
                      "Fields as YAML, such as \"{data: hello}\"; others keep their defaults");
  command->add_option("-r,--rate", options->rate, "Messages per second")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command->add_option("-p,--print", options->print, "Print every N-th message; 0: none")
      ->check(CLI::Range(0, 1000000000))
      ->capture_default_str();
  auto* const once = command->add_flag("-1,--once", options->once, "Publish one message and exit");
  command->add_option("-t,--times", options->times, "Publish this many messages and exit")
      ->check(count_range())
      ->excludes(once);
  command
      ->add_option("-w,--wait-matching-subscriptions", options->wait_matching,
                   "Wait for this many subscriptions first; 1 with --once or --times, else 0")
      ->check(CLI::Range(0, 1000000000));
  command
      ->add_option("--keep-alive", options->keep_alive,
                   "Seconds to stay after the last message of --once or --times")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  options->qos.add_to(*command);
}

}  // namespace pipescout::host
