// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <rcl_interfaces/msg/log.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/message_text.hpp"
#include "cli/session.hpp"
#include "cli/yaml_message.hpp"
#include "core/actions.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::host {
namespace {

/// How long a goal may take to be cancelled after a signal: the program ends by force after two
/// seconds.
constexpr Duration kCancelPatience = std::chrono::milliseconds(1500);
/// How long the log of a server may take to be heard: it goes another way than the answer.
constexpr Duration kLogPatience = std::chrono::seconds(1);

/// Nothing is cut.
constexpr MessageFormat kFull{.truncate = std::nullopt};

struct ListOptions {
  DiscoveryOptions discovery;
  bool types = false;
  bool count = false;
};

struct InfoOptions {
  DiscoveryOptions discovery;
  std::string action;
  bool types = false;
  bool count = false;
};

struct SendOptions {
  DiscoveryOptions discovery;
  std::string action;
  std::string type;
  std::string goal;
  bool from_stdin = false;
  bool feedback = false;
};

void print_types(const std::set<std::string>& types) {
  const char* separator = " [";
  for (const auto& type : types) {
    std::cout << separator << type;
    separator = ", ";
  }
  std::cout << ']';
}

int list_actions(Session& session, const ListOptions& options) {
  session.settle();
  const NamesAndTypes actions = actions_in(session.graph().topics());
  if (options.count) {
    std::cout << actions.size() << '\n';
    return kExitOk;
  }
  for (const auto& [name, types] : actions) {
    std::cout << name;
    if (options.types) {
      print_types(types);
    }
    std::cout << '\n';
  }
  return kExitOk;
}

std::string resolved(const std::string& action) {
  try {
    return expand_topic_name(action, {"/", "pipescout"});
  } catch (const InvalidName& error) {
    throw CommandError(error.what());
  }
}

int action_info(Session& session, const InfoOptions& options) {
  const std::string action = resolved(options.action);
  session.settle();
  const auto endpoints = session.graph().endpoints();
  std::cout << "Action: " << options.action << '\n';
  for (const bool servers : {false, true}) {
    const auto nodes = nodes_of_action(endpoints, action, servers);
    std::cout << (servers ? "Action servers: " : "Action clients: ") << nodes.size() << '\n';
    if (options.count) {
      continue;
    }
    for (const auto& [node, types] : nodes) {
      std::cout << "    " << node.fully_qualified();
      if (options.types) {
        print_types(types);
      }
      std::cout << '\n';
    }
  }
  return kExitOk;
}

ActionTypes types_of(const std::string& name) {
  try {
    return load_action_types(name);
  } catch (const MessageTypeError& error) {
    throw CommandError("The passed action type is invalid: " + std::string(error.what()));
  }
}

std::shared_ptr<void> goal_request(const ActionTypes& types, const SendOptions& options) {
  std::string yaml = options.goal;
  if (options.from_stdin) {
    yaml.assign(std::istreambuf_iterator<char>(std::cin), {});
  }
  std::shared_ptr<void> request = types.send_goal_request->create();
  try {
    set_from_yaml(yaml, *goal_in(types, static_cast<const void*>(request.get())).type,
                  goal_in(types, request.get()));
  } catch (const YamlMessageError& error) {
    throw CommandError("Failed to populate message fields: " + std::string(error.what()));
  }
  return request;
}

/// Waits for a server of the type; one that serves another under the name is an error.
void wait_for_server(Session& session, const UntypedActionClient& client,
                     const ActionTypes& types) {
  // A change of the graph makes the executor look again.
  const auto watch =
      session.graph().on_changed([group = session.node().default_group()] { group->post([] {}); });
  std::set<std::string> others;
  session.spin_until([&] {
    if (client.is_ready()) {
      return true;
    }
    std::set<std::string> served;
    for (const auto& [node, of_node] :
         nodes_of_action(session.graph().endpoints(), client.name(), true)) {
      served.insert(of_node.begin(), of_node.end());
    }
    others = served.contains(std::string(types.name)) ? std::set<std::string>() : served;
    return !others.empty();
  });
  if (!others.empty()) {
    throw CommandError("The action '" + client.name() + "' is served as " + *others.begin() +
                       ", not as " + std::string(types.name));
  }
}

/// What the nodes that serve an action log as a warning or worse. The answer to a goal has no room
/// for a reason; that is where servers of ROS 2 tell it.
class ServerLog {
 public:
  ServerLog(Session& session, std::string action)
      : session_(session),
        action_(std::move(action)),
        subscription_(session.node().create_subscription<Log>(
            topics::kRosout.name, QoS::reliable(topics::kRosout.qos.depth),
            [this](const Log& message) { hear(message); })) {}

  /// Hears from now on, of the servers that are known.
  void begin() {
    wait_for([this] { return is_connected(); });
    lines_.clear();
  }

  /// "navigator: action '/a': goal ID rejected: why", of ours that of the goal; else the first that
  /// came; nothing when none does.
  [[nodiscard]] std::optional<std::string> why_rejected(const GoalId& id) {
    const auto is_of_goal = [name = to_string(id)](const std::string& line) {
      return line.find(name) != std::string::npos;
    };
    wait_for([&] { return std::ranges::any_of(lines_, is_of_goal); });
    const auto found = std::ranges::find_if(lines_, is_of_goal);
    return found != lines_.end() ? *found
           : lines_.empty()      ? std::nullopt
                                 : std::optional(lines_.front());
  }

 private:
  using Log = rcl_interfaces::msg::Log;

  void wait_for(const std::function<bool()>& done) {
    if (!done()) {
      session_.executor().spin_until(done, kLogPatience);
    }
  }

  [[nodiscard]] std::set<NodeName> servers() const {
    std::set<NodeName> names;
    for (const auto& [node, types] : nodes_of_action(session_.graph().endpoints(), action_, true)) {
      names.insert(node);
    }
    return names;
  }

  [[nodiscard]] bool is_connected() const {
    const auto nodes = servers();
    const auto endpoints = session_.graph().endpoints();
    return !nodes.empty() && std::ranges::all_of(endpoints, [&](const GraphEndpoint& endpoint) {
      return !endpoint.is_publisher || !endpoint.node || !nodes.contains(*endpoint.node) ||
             endpoint.wire_topic != subscription_.untyped()->topic().name ||
             subscription_.untyped()->is_matched(endpoint.gid);
    });
  }

  void hear(const Log& message) {
    const auto is_of = [&](const NodeName& node) { return logger_of(node) == message.name; };
    if (message.level >= Log::WARN && std::ranges::any_of(servers(), is_of)) {
      lines_.push_back(message.name + ": " + message.msg);
    }
  }

  Session& session_;
  const std::string action_;
  std::vector<std::string> lines_;
  Subscription<Log> subscription_;
};

/// A goal on its way, as far as the command knows.
struct SentGoal {
  std::optional<GoalResponse> response;
  std::optional<GoalEnd> end;
  std::shared_ptr<const void> result;
};

void cancel(Session& session, UntypedActionClient& client, const GoalId& id) {
  std::cout << "Canceling goal..." << std::endl;
  // Shared with the client, which answers what is left when it goes.
  const auto answer = std::make_shared<std::optional<CancelResponse>>();
  client.cancel(
      {.id = id}, [answer](const CancelResponse& told) { *answer = told; }, kCancelPatience);
  const SteadyTime deadline = steady_now() + kCancelPatience;
  // A second signal, or the first one's echo, stops the executor; it ends the program by itself.
  while (!answer->has_value() && steady_now() < deadline) {
    session.executor().spin_until([&] { return answer->has_value(); }, deadline - steady_now());
  }
  if (!answer->has_value() || (*answer)->error || (*answer)->canceling.empty()) {
    std::cerr << "Failed to cancel goal\n";
    return;
  }
  std::cout << "Goal canceled." << std::endl;
}

const char* status_text(GoalEnd end) {
  switch (end) {
    case GoalEnd::kSucceeded:
      return "SUCCEEDED";
    case GoalEnd::kCanceled:
      return "CANCELED";
    case GoalEnd::kAborted:
      return "ABORTED";
    default:
      return "UNKNOWN";
  }
}

int send_goal(Session& session, const SendOptions& options) {
  const std::string action = resolved(options.action);
  const ActionTypes types = types_of(options.type);
  const std::shared_ptr<void> request = goal_request(types, options);
  const auto client = session.node().create_untyped_action_client(action, types);
  ServerLog log(session, action);
  std::cout << "Waiting for an action server to become available..." << std::endl;
  wait_for_server(session, *client, types);
  log.begin();
  std::cout << "Sending goal:\n     "
            << to_yaml(goal_in(types, static_cast<const void*>(request.get())), kFull) << std::endl;
  // Shared with the client, as above.
  const auto goal = std::make_shared<SentGoal>();
  UntypedGoalCallbacks callbacks;
  callbacks.response = [goal](const GoalResponse& told) {
    goal->response = told;
    if (told.accepted) {
      std::cout << "Goal accepted with ID: " << to_string(told.id) << '\n' << std::endl;
    }
  };
  callbacks.result = [goal](const GoalId&, GoalEnd end, const std::shared_ptr<const void>& told) {
    goal->end = end;
    goal->result = told;
  };
  if (options.feedback) {
    callbacks.feedback = [types](const std::shared_ptr<const void>& message) {
      std::cout << "Feedback:\n    " << to_yaml(feedback_in(types, message.get()), kFull)
                << std::endl;
    };
  }
  const GoalId id =
      client->send_goal(request, std::move(callbacks), from_seconds(options.discovery.timeout));
  try {
    // A change of the graph makes the executor look again.
    const auto watch = session.graph().on_changed(
        [group = session.node().default_group()] { group->post([] {}); });
    session.spin_until([&] {
      return goal->end || (goal->response && (!goal->response->accepted || !client->is_ready()));
    });
  } catch (const CommandInterrupted&) {
    // Also when no answer has come yet: the server may have the goal.
    cancel(session, *client, id);
    throw;
  }
  if (!goal->end) {
    if (goal->response->accepted) {
      throw CommandError("The server of the action '" + action +
                         "' has gone; the result is not known");
    }
    if (goal->response->error) {
      throw CommandError("Exception while sending goal: " +
                         std::string(to_string(*goal->response->error)));
    }
    std::cout << "Goal was rejected.\n";
    const auto why = log.why_rejected(id);
    std::cerr << (why ? "The log of the server says: " + *why
                      : "The server has logged no reason on " + std::string(topics::kRosout.name) +
                            '.')
              << '\n';
    return kExitError;
  }
  if (goal->result) {
    std::cout << "Result:\n    " << to_yaml(result_in(types, goal->result.get()), kFull) << '\n';
  } else {
    std::cerr << "There is no result: the goal is " << to_string(*goal->end) << '\n';
  }
  std::cout << "Goal finished with status: " << status_text(*goal->end) << '\n';
  return *goal->end == GoalEnd::kSucceeded ? kExitOk : kExitError;
}

}  // namespace

void add_action_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("action", "Actions on the network");
  group->require_subcommand(1);

  const auto [list, list_options] =
      add_graph_command<ListOptions>(*group, action, "list", "List the actions", list_actions);
  list->add_flag("-t,--show-types", list_options->types, "Show the types too");
  list->add_flag("-c,--count-actions", list_options->count, "Print only how many there are");

  const auto [info, info_options] = add_graph_command<InfoOptions>(
      *group, action, "info", "Show the servers and clients of an action", action_info);
  info->add_option("action", info_options->action, "Name of the action")->required();
  info->add_flag("-t,--show-types", info_options->types, "Show the types too");
  info->add_flag("-c,--count", info_options->count, "Print only how many there are");

  const auto [send, send_options] = add_session_command<SendOptions>(
      *group, action, "send_goal", "Send a goal and wait for its result", true, send_goal);
  send->add_option("action", send_options->action, "Name of the action")->required();
  send->add_option("type", send_options->type,
                   "Its type, such as example_interfaces/action/Fibonacci")
      ->required();
  auto* const goal = send->add_option(
      "goal", send_options->goal, "Fields as YAML, such as \"{order: 10}\"; others keep defaults");
  send->add_flag("--stdin", send_options->from_stdin, "Read the goal from standard input")
      ->excludes(goal);
  send->add_flag("-f,--feedback", send_options->feedback, "Print the feedback too");
}

}  // namespace pipescout::host
