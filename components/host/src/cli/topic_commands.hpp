// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/session.hpp"
#include "pipescout/interfaces/graph.hpp"

namespace pipescout::host {

void add_topic_echo(CLI::App& group, Action& action);
void add_topic_hz(CLI::App& group, Action& action);

/// The topic that a user named, fully qualified. Throws CommandError.
[[nodiscard]] std::string topic_name(const std::string& name);

/// Publishers (or subscriptions) of a topic.
[[nodiscard]] std::vector<GraphEndpoint> endpoints_of(Graph& graph, const std::string& topic,
                                                      bool publishers);

/// Waits for a topic to appear and returns its type. `given`: what the user said, or empty; then
/// nothing is waited for. Throws CommandError when it is unknown, ambiguous, or not one of ours.
[[nodiscard]] const MessageType& topic_type(Session& session, const std::string& topic,
                                            const std::string& given);

/// QoS from the command line.
struct QosOptions {
  std::string profile;
  std::optional<std::size_t> depth;
  std::string reliability;
  std::string durability;

  void add_to(CLI::App& command);
};

/// What the options say; where they say nothing, what matches the publishers of the topic, as
/// `ros2 topic echo` chooses it: reliable (transient local) if all of them are.
[[nodiscard]] QoS choose_qos(Graph& graph, const std::string& topic, const QosOptions& options);

}  // namespace pipescout::host
