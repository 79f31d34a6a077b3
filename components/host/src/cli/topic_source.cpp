// SPDX-License-Identifier: Apache-2.0
#include "cli/topic_source.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::host {
namespace {

/// Waits for a topic to appear and returns the name of its type. `given`: what the user said, or
/// empty; then nothing is waited for.
std::string topic_type(Session& session, const std::string& topic, const std::string& given) {
  auto name = full_type_name(given);
  if (!name.empty()) {
    return name;
  }
  auto& graph = session.graph();
  if (!session.wait_for([&] { return graph.topics().contains(topic); })) {
    throw CommandError("WARNING: topic [" + topic +
                       "] does not appear to be published yet\n"
                       "Could not determine the type for the passed topic");
  }
  const auto types = graph.topics()[topic];
  if (types.size() > 1) {
    throw CommandError("Cannot echo topic '" + topic + "', as it contains more than one type: [" +
                       joined(types) + "]");
  }
  return types.empty() ? "" : *types.begin();
}

QoS choose_qos(Graph& graph, const std::string& topic, const QosOptions& options) {
  // Deep enough for a burst while a terminal scrolls.
  constexpr std::size_t kDepth = 100;
  QoS qos = QoS::sensor_data(kDepth);
  if (options.profile == "default" || options.profile == "system_default") {
    qos = QoS::reliable();
  } else if (options.profile == "services_default") {
    qos = QoS::services();
  } else if (options.profile == "parameters") {
    qos = QoS::parameters();
  } else if (options.profile.empty()) {
    std::vector<QoS> offered;
    for (const auto& publisher : endpoints_of(graph, topic, true)) {
      offered.push_back(publisher.qos);
    }
    if (!offered.empty()) {
      const QoS request = request_for(offered, qos.depth);
      const auto any = [&](auto test) { return std::any_of(offered.begin(), offered.end(), test); };
      if (request.reliability != Reliability::kReliable && options.reliability.empty() &&
          any([](const QoS& offer) { return offer.reliability == Reliability::kReliable; })) {
        std::cerr << "Some, but not all, publishers are offering QoSReliabilityPolicy.RELIABLE. "
                     "Falling back to QoSReliabilityPolicy.BEST_EFFORT as it will connect to all "
                     "publishers\n";
      }
      if (request.durability != Durability::kTransientLocal && options.durability.empty() &&
          any([](const QoS& offer) { return offer.durability == Durability::kTransientLocal; })) {
        std::cerr << "Some, but not all, publishers are offering "
                     "QoSDurabilityPolicy.TRANSIENT_LOCAL. Falling back to "
                     "QoSDurabilityPolicy.VOLATILE as it will connect to all publishers\n";
      }
      qos.reliability = request.reliability;
      qos.durability = request.durability;
    }
  }
  options.override(qos);
  return qos;
}

}  // namespace

std::string joined(const std::set<std::string>& texts) {
  std::string result;
  for (const auto& text : texts) {
    result += (result.empty() ? "" : ", ") + text;
  }
  return result;
}

std::vector<GraphEndpoint> endpoints_of(Graph& graph, const std::string& topic, bool publishers) {
  auto endpoints = graph.endpoints();
  const auto wire = mangle_topic_name(topic, DdsTopicKind::kTopic);
  std::erase_if(endpoints, [&](const GraphEndpoint& endpoint) {
    return endpoint.wire_topic != wire || endpoint.is_publisher != publishers;
  });
  return endpoints;
}

std::string topic_name(const std::string& name) {
  try {
    return expand_topic_name(name, {"/", "pipescout"});
  } catch (const InvalidName& error) {
    throw CommandError(error.what());
  }
}

void QosOptions::add_to(CLI::App& command) {
  command.add_option("--qos-profile", profile, "Start from this profile")
      ->check(CLI::IsMember(
          {"default", "system_default", "sensor_data", "services_default", "parameters"}));
  command.add_option("--qos-depth", depth, "Messages kept")->check(count_range());
  command.add_option("--qos-reliability", reliability, "")
      ->check(CLI::IsMember({"reliable", "best_effort"}));
  command.add_option("--qos-durability", durability, "")
      ->check(CLI::IsMember({"volatile", "transient_local"}));
}

void QosOptions::override(QoS& qos) const {
  if (depth) {
    qos.depth = *depth;
  }
  if (!reliability.empty()) {
    qos.reliability = reliability == "reliable" ? Reliability::kReliable : Reliability::kBestEffort;
  }
  if (!durability.empty()) {
    qos.durability = durability == "volatile" ? Durability::kVolatile : Durability::kTransientLocal;
  }
}

void ListenOptions::add_to(CLI::App& command) {
  command.add_option("topic", topic, "Name of the topic")->required();
  command.add_option("type", type, "Its type, if there is no publisher yet");
  qos.add_to(command);
}

RawSource find_raw_source(Session& session, const ListenOptions& options) {
  RawSource source{.topic = topic_name(options.topic)};
  source.type = topic_type(session, source.topic, options.type);
  if (options.type.empty()) {
    // All publishers, before a QoS is chosen that must match them: the type may be known from a
    // subscriber that was discovered first.
    session.wait_for([&] { return !endpoints_of(session.graph(), source.topic, true).empty(); });
    (void)session.discover(std::chrono::milliseconds(100));
  }
  source.qos = choose_qos(session.graph(), source.topic, options.qos);
  return source;
}

Source find_source(Session& session, const ListenOptions& options) {
  auto raw = find_raw_source(session, options);
  try {
    return {std::move(raw.topic), &load_message_type(raw.type), raw.qos};
  } catch (const MessageTypeError& error) {
    throw CommandError("The message type '" + raw.type +
                       "' is not one of this installation: " + error.what());
  }
}

TypeConflict::TypeConflict(Session& session, std::string topic, std::string type)
    : session_(session), topic_(std::move(topic)), type_(std::move(type)) {
  const auto look_soon = [this, group = session.node().default_group()] {
    group->post([this] { look(); });
  };
  watch_ = session.graph().on_changed(look_soon);
  look_soon();
}

void TypeConflict::look() {
  std::set<std::string> types;
  for (const bool publishers : {true, false}) {
    for (const auto& endpoint : endpoints_of(session_.graph(), topic_, publishers)) {
      if (!endpoint.in_this_process) {
        types.insert(demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type));
      }
    }
  }
  const bool is_shared = types.erase(type_) > 0;
  if (is_shared && !types.empty() && !warned_) {
    warned_ = true;
    std::cerr << "WARNING: topic '" << topic_ << "' is used as " << joined(types)
              << " too; nothing passes between these and " << type_ << '\n';
  }
  if (!is_shared && !types.empty()) {
    others_ = types;
    session_.executor().stop();
  }
}

void TypeConflict::throw_if_any() const {
  if (!others_.empty()) {
    throw CommandError("Topic '" + topic_ + "' is used as " + joined(others_) + ", not as " +
                       type_);
  }
}

}  // namespace pipescout::host
