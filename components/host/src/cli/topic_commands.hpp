// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/session.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout::host {

void add_topic_echo(CLI::App& group, Action& action);
void add_topic_pub(CLI::App& group, Action& action);
void add_topic_statistics(CLI::App& group, Action& action);

/// The topic that a user named, fully qualified. Throws CommandError.
[[nodiscard]] std::string topic_name(const std::string& name);

/// QoS from the command line.
struct QosOptions {
  std::string profile;
  std::optional<std::size_t> depth;
  std::string reliability;
  std::string durability;

  void add_to(CLI::App& command);
  /// Sets what the user named one by one, besides the profile.
  void override(QoS& qos) const;
};

/// A topic to listen to, from the command line.
struct ListenOptions {
  DiscoveryOptions discovery;
  std::string topic;
  std::string type;
  QosOptions qos;

  /// All but those of discovery.
  void add_to(CLI::App& command);
};

struct Source {
  std::string topic;
  const MessageType* type = nullptr;
  QoS qos;
};

/// Waits for the topic to appear unless its type is given, and for all its publishers. Its QoS is
/// what the options say; where they say nothing, what matches the publishers of the topic, as `ros2
/// topic echo` chooses it: reliable (transient local) if all of them are. Throws CommandError when
/// the topic is unknown, or its type ambiguous or not one of ours.
[[nodiscard]] Source find_source(Session& session, const ListenOptions& options);

}  // namespace pipescout::host
