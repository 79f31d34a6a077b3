// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
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

/// A topic that is listened to as messages of its type.
struct Source {
  std::string topic;
  const MessageType* type = nullptr;
  QoS qos;
};

/// A topic that is listened to as bytes.
struct RawSource {
  std::string topic;
  std::string type;  ///< name
  QoS qos;
};

/// Unless its type is given, waits for the topic to appear, and for all its publishers: at least
/// one before the spin time is over. Its QoS is what the options say; where they say nothing, what
/// matches the publishers of the topic, as `ros2 topic echo` chooses it: reliable (transient local)
/// if all of them are. Throws CommandError when the topic is unknown, or its type ambiguous or not
/// one of ours.
[[nodiscard]] Source find_source(Session& session, const ListenOptions& options);
/// The same for a type of which nothing but its name need be known.
[[nodiscard]] RawSource find_raw_source(Session& session, const ListenOptions& options);

/// Ends a command when others use its topic, and none of them with the type that the command has it
/// with: nothing ever passes between them.
class TypeConflict {
 public:
  /// From now on stops the session's executor once there is a conflict, which it looks for while
  /// the session spins. What has another type beside some with this one is told on standard error,
  /// once.
  TypeConflict(Session& session, std::string topic, std::string type);
  TypeConflict(const TypeConflict&) = delete;
  TypeConflict& operator=(const TypeConflict&) = delete;

  /// Throws CommandError, which names both types, when there is one.
  void throw_if_any() const;

 private:
  void look();

  Session& session_;
  const std::string topic_;
  const std::string type_;
  std::set<std::string> others_;  ///< of the conflict
  bool warned_ = false;
  std::shared_ptr<void> watch_;
};

}  // namespace pipescout::host
