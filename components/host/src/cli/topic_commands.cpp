// SPDX-License-Identifier: Apache-2.0
#include "cli/topic_commands.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <set>
#include <vector>

#include "cli/name_commands.hpp"
#include "cli/topic_source.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::host {
namespace {

struct TopicOptions {
  DiscoveryOptions discovery;
  std::string topic;
  bool types = false;
  bool hidden = false;
  bool count = false;
  bool verbose = false;
};

std::size_t count_of(Graph& graph, const std::string& topic, bool publishers) {
  return endpoints_of(graph, topic, publishers).size();
}

void print_counted(Graph& graph, const NamesAndTypes& topics, bool publishers) {
  std::cout << (publishers ? "Published" : "Subscribed") << " topics:\n";
  for (const auto& [name, types] : topics) {
    const auto count = count_of(graph, name, publishers);
    if (count > 0) {
      std::cout << " * " << name << " [" << joined(types) << "] " << count << ' '
                << (publishers ? "publisher" : "subscriber") << (count > 1 ? "s" : "") << '\n';
    }
  }
  std::cout << '\n';
}

int list_topics(Session& session, const TopicOptions& options) {
  session.settle();
  auto topics = session.graph().topics();
  std::erase_if(topics,
                [&](const auto& entry) { return !options.hidden && is_hidden(entry.first); });
  if (options.count) {
    std::cout << topics.size() << '\n';
    return kExitOk;
  }
  if (options.verbose) {
    if (!topics.empty()) {
      print_counted(session.graph(), topics, true);
      print_counted(session.graph(), topics, false);
    }
    return kExitOk;
  }
  for (const auto& [name, types] : topics) {
    std::cout << name;
    if (options.types) {
      std::cout << " [" << joined(types) << ']';
    }
    std::cout << '\n';
  }
  return kExitOk;
}

std::string duration_text(const std::optional<Duration>& duration) {
  return duration ? std::to_string(duration->count()) + " nanoseconds" : "Infinite";
}

void print_endpoint(const GraphEndpoint& endpoint) {
  const auto node =
      endpoint.node.value_or(NodeName{"_NODE_NAMESPACE_UNKNOWN_", "_NODE_NAME_UNKNOWN_"});
  std::string gid;
  // 24 bytes in ROS 2 Humble: a GUID and zeros.
  constexpr std::size_t kGidSize = 24;
  for (std::size_t i = 0; i < kGidSize; ++i) {
    std::array<char, 4> hex{};
    const unsigned byte = i < endpoint.gid.bytes.size() ? endpoint.gid.bytes[i] : 0U;
    std::snprintf(hex.data(), hex.size(), "%02x", byte);
    gid += (i == 0 ? "" : ".") + std::string(hex.data());
  }
  const auto& qos = endpoint.qos;
  std::cout << "Node name: " << node.name << "\nNode namespace: " << node.ns << "\nTopic type: "
            << demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type)
            << "\nEndpoint type: " << (endpoint.is_publisher ? "PUBLISHER" : "SUBSCRIPTION")
            << "\nGID: " << gid << "\nQoS profile:\n  Reliability: "
            << (qos.reliability == Reliability::kReliable ? "RELIABLE" : "BEST_EFFORT")
            << "\n  History (Depth): "
            << (qos.depth == 0 ? "UNKNOWN" : "KEEP_LAST (" + std::to_string(qos.depth) + ")")
            << "\n  Durability: "
            << (qos.durability == Durability::kTransientLocal ? "TRANSIENT_LOCAL" : "VOLATILE")
            << "\n  Lifespan: " << duration_text(qos.lifespan)
            << "\n  Deadline: " << duration_text(qos.deadline) << "\n  Liveliness: "
            << (qos.liveliness == Liveliness::kAutomatic ? "AUTOMATIC" : "MANUAL_BY_TOPIC")
            << "\n  Liveliness lease duration: " << duration_text(qos.liveliness_lease) << "\n\n";
}

int topic_info(Session& session, const TopicOptions& options) {
  const auto topic = topic_name(options.topic);
  auto& graph = session.graph();
  if (!session.wait_for([&] { return graph.topics().contains(topic); })) {
    throw CommandError("Unknown topic '" + options.topic + "'");
  }
  session.settle();
  const auto types = graph.topics()[topic];
  const char* line_end = options.verbose ? "\n\n" : "\n";
  if (types.size() == 1) {
    std::cout << "Type: " << *types.begin() << line_end;
  } else {
    std::cout << "Type: ['";
    std::string list;
    for (const auto& type : types) {
      list += (list.empty() ? "" : "', '") + type;
    }
    std::cout << list << "']" << line_end;
  }
  for (const bool publishers : {true, false}) {
    const auto endpoints = endpoints_of(graph, topic, publishers);
    std::cout << (publishers ? "Publisher count: " : "Subscription count: ") << endpoints.size()
              << line_end;
    if (options.verbose) {
      std::for_each(endpoints.begin(), endpoints.end(), print_endpoint);
    }
  }
  return kExitOk;
}

}  // namespace

void add_topic_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("topic", "Topics on the network");
  group->require_subcommand(1);

  const auto [list, list_options] =
      add_graph_command<TopicOptions>(*group, action, "list", "List the topics", list_topics);
  list->add_flag("-t,--show-types", list_options->types, "Show the types too");
  list->add_flag("-c,--count-topics", list_options->count, "Print only the count");
  list->add_flag("-a,--include-hidden-topics", list_options->hidden, "Hidden topics too");
  list->add_flag("-v,--verbose", list_options->verbose, "Show types and numbers of endpoints");

  const auto [info, info_options] = add_graph_command<TopicOptions>(
      *group, action, "info", "Show type and endpoints of a topic", topic_info);
  info->add_option("topic", info_options->topic, "Name of the topic")->required();
  info->add_flag("-v,--verbose", info_options->verbose, "Show each endpoint, its node and its QoS");

  add_topic_echo(*group, action);
  add_topic_pub(*group, action);
  add_topic_statistics(*group, action);
  add_name_commands(*group, action, "topic",
                    [](Session& session) { return session.graph().topics(); });
}

}  // namespace pipescout::host
