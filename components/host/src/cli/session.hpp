// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/command.hpp"
#include "cli/daemon.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/stop_signals.hpp"

/// The place of a command on the network: a node of its own, hidden and short-lived.
namespace pipescout::host {

/// The options that every command on the network has.
struct DiscoveryOptions {
  double spin_time = 5.0;    ///< s, how long to look for others at most
  double timeout = 5.0;      ///< s, how long to wait for the answer of a service
  bool asks_daemon = false;  ///< the command needs nothing but the graph

  void add_to(CLI::App& command, bool with_services);
};

class Session {
 public:
  /// Joins the network. Throws TransportError, std::invalid_argument.
  explicit Session(DiscoveryOptions options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] Node& node() { return *node_; }
  [[nodiscard]] Graph& graph() { return context_->graph(); }
  [[nodiscard]] Executor& executor() { return executor_; }
  /// Runs the callbacks of `node` until a signal, or `executor().stop()`.
  void spin() { executor_.spin(); }
  /// Runs them until `done`, asked after each; throws CommandInterrupted after a signal.
  void spin_until(const std::function<bool()>& done);
  /// Runs them for that time; throws CommandInterrupted after a signal.
  void spin_for(Duration time);

  // All that wait for others end with the spin time, which begins with the session or the command,
  // and throw CommandInterrupted after SIGINT, SIGTERM or SIGHUP.

  /// The next command of a session that serves several.
  void begin(const DiscoveryOptions& options);

  /// Returns once all participants of this machine are discovered, and everything that these and
  /// others announce; what other machines have is known to nobody, so unless there are none
  /// (ROS_LOCALHOST_ONLY) somebody must be discovered, and nothing new have come for the `quiet`
  /// time. After the spin time returns what is still missing, a sentence each.
  [[nodiscard]] std::vector<std::string> discover(Duration quiet = std::chrono::milliseconds(500));
  /// The same before a list is printed: warns of what is missing.
  void settle();
  /// Returns as soon as `found` holds; false after the spin time.
  bool wait_for(const std::function<bool()>& found);

  /// Nodes of others, sorted; a name that two bear appears twice. Hidden ones begin with '_'.
  [[nodiscard]] std::vector<NodeName> nodes(bool hidden);
  /// Waits for a node that the user named, "/ns/name" or "name". Throws CommandError.
  [[nodiscard]] NodeName find_node(const std::string& name);
  /// Whether the node has a server of `~/service` with that type ("lifecycle_msgs/srv/GetState").
  [[nodiscard]] bool serves(const NodeName& node, std::string_view service, std::string_view type);

  /// Calls a service and waits for its answer. Throws CommandError when none comes.
  template <class S>
  std::shared_ptr<const typename S::Response> call(const std::string& service,
                                                   typename S::Request request = {}) {
    const auto client = create_client(service, message_type<typename S::Request>(),
                                      message_type<typename S::Response>());
    return std::static_pointer_cast<const typename S::Response>(
        call(*client, std::make_shared<const typename S::Request>(std::move(request)), service));
  }
  /// The same with types known at run time.
  [[nodiscard]] std::shared_ptr<UntypedClient> create_client(const std::string& service,
                                                             const MessageType& request,
                                                             const MessageType& response);
  [[nodiscard]] std::shared_ptr<const void> call(UntypedClient& client,
                                                 std::shared_ptr<const void> request,
                                                 const std::string& service);

 private:
  struct Missing {
    std::vector<std::string> sentences;
    bool may_come = false;  ///< some of it
    /// Endpoints are there of which no node has been told; that may be all that there is.
    bool nodes_may_follow = false;
  };
  [[nodiscard]] Missing what_is_missing();
  /// Whether there may be somebody who is known by nothing but what he sends.
  [[nodiscard]] bool may_be_others() const;
  void note_change();
  void interrupt(int signal);
  void throw_if_interrupted() const;

  DiscoveryOptions options_;
  std::condition_variable changed_;
  mutable std::mutex mutex_;
  int stop_signal_ = 0;                    ///< guarded by mutex_, as the next
  SteadyTime last_change_ = steady_now();  ///< of the graph
  bool is_alone_ = false;                  ///< this machine: there are no others
  Executor executor_;
  StopSignals signals_;
  const SteadyTime begin_ = steady_now();
  SteadyTime end_of_discovery_;
  std::shared_ptr<Context> context_;
  std::unique_ptr<Node> node_;
  std::shared_ptr<void> graph_changes_;
};

/// Adds a command that runs `body` in a session. `Options` has a member `discovery`.
template <class Options>
std::pair<CLI::App*, std::shared_ptr<Options>> add_session_command(
    CLI::App& group, Action& action, const char* name, const char* description, bool with_services,
    std::function<int(Session&, const Options&)> body) {
  auto options = std::make_shared<Options>();
  auto* command = group.add_subcommand(name, description);
  options->discovery.add_to(*command, with_services);
  command->callback([options, body = std::move(body), &action] {
    action = [options, body, &action] {
      if (action.resident != nullptr) {
        action.resident->begin(options->discovery);
        return body(*action.resident, *options);
      }
      if (options->discovery.asks_daemon) {
        if (const auto code =
                ask_daemon(action.words, from_seconds(options->discovery.spin_time))) {
          return *code;
        }
      }
      Session session(options->discovery);
      return body(session, *options);
    };
  });
  return {command, options};
}

/// The same for one that only looks at the graph: the daemon answers it where it runs.
template <class Options>
std::pair<CLI::App*, std::shared_ptr<Options>> add_graph_command(
    CLI::App& group, Action& action, const char* name, const char* description,
    std::function<int(Session&, const Options&)> body) {
  auto added =
      add_session_command<Options>(group, action, name, description, false, std::move(body));
  added.second->discovery.asks_daemon = true;
  added.first->add_flag("!--no-daemon", added.second->discovery.asks_daemon,
                        "Join the network, also where the daemon runs");
  return added;
}

/// A topic or service "/a/_b/c" is hidden, as every one with a part that begins with '_'.
[[nodiscard]] bool is_hidden(std::string_view name);

/// "/name" for "name".
[[nodiscard]] std::string absolute_name(const std::string& name);

/// "robot_1.fusion": the logger of a node, as its messages on /rosout name it.
[[nodiscard]] std::string logger_of(const NodeName& node);

/// "std_msgs/msg/String" for "std_msgs/String" too.
[[nodiscard]] std::string full_type_name(const std::string& name);

}  // namespace pipescout::host
