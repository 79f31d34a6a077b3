// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cli/session.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout::host {

/// "a, b"
[[nodiscard]] std::string joined(const std::set<std::string>& texts);

/// Publishers (or subscriptions) of a topic.
[[nodiscard]] std::vector<GraphEndpoint> endpoints_of(Graph& graph, const std::string& topic,
                                                      bool publishers);

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

/// Unless its type is given, waits for the topic to appear, and for all its publishers: at least
/// one before the spin time is over. Its QoS is what the options say; where they say nothing, what
/// matches the publishers of the topic, as `ros2 topic echo` chooses it: reliable (transient local)
/// if all of them are. Throws CommandError when the topic is unknown, or its type ambiguous or not
/// one of ours.
[[nodiscard]] Source find_source(Session& session, const ListenOptions& options);

}  // namespace pipescout::host
