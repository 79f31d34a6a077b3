// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "doctor/checks.hpp"

namespace pipescout::host::doctor {
namespace {

/// The ROS name of a topic, and nothing for endpoints of services and of plain DDS programs.
std::optional<std::string> topic_of(const GraphEndpoint& endpoint) {
  const auto topic = demangle_topic_name(endpoint.wire_topic);
  return topic && topic->kind == DdsTopicKind::kTopic ? std::optional(topic->name) : std::nullopt;
}

std::string owner(const GraphEndpoint& endpoint) {
  return endpoint.node ? endpoint.node->fully_qualified() : "a program without a node";
}

std::string type_of(const GraphEndpoint& endpoint) {
  return demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type);
}

/// Publishers and subscriptions of each topic.
struct Topic {
  std::vector<const GraphEndpoint*> publishers;
  std::vector<const GraphEndpoint*> subscriptions;
};

std::map<std::string, Topic> topics_of(const Observation& seen) {
  std::map<std::string, Topic> topics;
  for (const auto& endpoint : seen.endpoints) {
    if (const auto name = topic_of(endpoint)) {
      auto& topic = topics[*name];
      (endpoint.is_publisher ? topic.publishers : topic.subscriptions).push_back(&endpoint);
    }
  }
  return topics;
}

const char* advice_for(QosPolicy policy) {
  switch (policy) {
    case QosPolicy::kReliability:
      return "Let the publisher be reliable, or the subscription best effort.";
    case QosPolicy::kDurability:
      return "Let the publisher be transient local, or the subscription volatile.";
    default:
      return "Let the publisher promise at least what the subscription asks for.";
  }
}

std::string joined(const std::set<std::string>& names) {
  std::string text;
  for (const auto& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

std::string joined(const std::set<NodeName>& nodes) {
  std::set<std::string> names;
  for (const auto& node : nodes) {
    names.insert(node.fully_qualified());
  }
  return joined(names);
}

/// Topics that any node may listen to without anyone being there to speak.
bool may_be_silent(const std::string& topic) {
  return topic == "/clock" || topic == "/parameter_events" || topic == "/rosout";
}

/// "/front/image_raw" -> "/front/camera_info", as image_transport has it.
std::string camera_info_of(const std::string& image_topic) {
  return image_topic.substr(0, image_topic.rfind('/')) + "/camera_info";
}

}  // namespace

std::vector<Finding> check_discovery(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& sentence : seen.undiscovered) {
    findings.push_back({Severity::kWarning, "Not everything has been discovered: " + sentence + ".",
                        "See whether that process hangs, speaks another ROS_LOCALHOST_ONLY, or is "
                        "kept apart by DDS Security or another discovery server; whether a topic "
                        "has publishers and a camera its calibration was not looked at."});
  }
  return findings;
}

std::vector<Finding> check_localhost_only(const Observation& seen) {
  const auto mixed = [](const std::string& alone, const std::string& beyond) {
    return Finding{Severity::kError,
                   "ROS_LOCALHOST_ONLY is not the same for all: " + alone + " with it, " + beyond +
                       " without: they may not find each other, and what "
                       "is sent may arrive one way alone.",
                   "Set it to 1 for all of them, or for none."};
  };
  if (!seen.nodes_on_loopback_alone.empty() && !seen.nodes_beyond_loopback.empty()) {
    return {mixed(joined(seen.nodes_on_loopback_alone), joined(seen.nodes_beyond_loopback))};
  }
  if (seen.machine && seen.machine->localhost_only && !seen.nodes_beyond_loopback.empty()) {
    return {mixed("this command", joined(seen.nodes_beyond_loopback))};
  }
  if (seen.machine && !seen.machine->localhost_only && seen.machine->has_network() &&
      !seen.nodes_on_loopback_alone.empty()) {
    return {mixed(joined(seen.nodes_on_loopback_alone), "this command")};
  }
  return {};
}

std::vector<Finding> check_quality_of_service(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [name, topic] : topics_of(seen)) {
    std::set<std::string> told;
    for (const auto* publisher : topic.publishers) {
      for (const auto* subscription : topic.subscriptions) {
        const auto policy = publisher->wire_type == subscription->wire_type
                                ? incompatibility(publisher->qos, subscription->qos)
                                : std::nullopt;
        if (policy && told.insert(owner(*publisher) + ' ' + owner(*subscription)).second) {
          findings.push_back({Severity::kError,
                              owner(*subscription) + " gets nothing from " + owner(*publisher) +
                                  " on " + name + ": it asks for more than is offered (" +
                                  to_string(*policy) + ").",
                              advice_for(*policy)});
        }
      }
    }
  }
  return findings;
}

std::vector<Finding> check_types(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [name, topic] : topics_of(seen)) {
    std::set<std::string> types;
    for (const auto* list : {&topic.publishers, &topic.subscriptions}) {
      for (const auto* endpoint : *list) {
        types.insert(type_of(*endpoint));
      }
    }
    if (types.size() > 1) {
      findings.push_back({Severity::kError,
                          name + " is used with several types: " + joined(types) + ".",
                          "Rename the topic in one of the nodes, or give it the other's type."});
    }
  }
  return findings;
}

std::vector<Finding> check_inputs(const Observation& seen) {
  std::vector<Finding> findings;
  if (!seen.undiscovered.empty()) {
    return findings;  // the publisher may be among what is missing
  }
  for (const auto& [name, topic] : topics_of(seen)) {
    std::set<std::string> listeners;
    for (const auto* subscription : topic.subscriptions) {
      if (subscription->node && !subscription->node->name.starts_with('_')) {
        listeners.insert(subscription->node->fully_qualified());
      }
    }
    if (topic.publishers.empty() && !listeners.empty() && !may_be_silent(name)) {
      findings.push_back({Severity::kWarning,
                          "Nobody publishes " + name + " (" +
                              type_of(*topic.subscriptions.front()) + "), to which " +
                              joined(listeners) +
                              (listeners.size() == 1 ? " subscribes." : " subscribe."),
                          "Start what publishes it, or remap the name; an input that the node "
                          "can do without needs nothing."});
    }
  }
  return findings;
}

std::vector<Finding> check_node_names(const Observation& seen) {
  std::vector<Finding> findings;
  auto nodes = seen.nodes;
  std::sort(nodes.begin(), nodes.end());
  for (auto node = nodes.begin(); node != nodes.end();) {
    const auto next = std::upper_bound(node, nodes.end(), *node);
    if (next - node > 1) {
      findings.push_back(
          {Severity::kError,
           std::to_string(next - node) + " nodes have the name " + node->fully_qualified() + ".",
           "Give each a name or a namespace of its own: parameters and services "
           "reach only one of them."});
    }
    node = next;
  }
  return findings;
}

std::vector<Finding> check_clock_publishers(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [name, topic] : topics_of(seen)) {
    if (topic.publishers.size() < 2 ||
        type_of(*topic.publishers.front()) != "rosgraph_msgs/msg/Clock") {
      continue;
    }
    std::set<std::string> owners;
    for (const auto* publisher : topic.publishers) {
      owners.insert(owner(*publisher));
    }
    findings.push_back(
        {Severity::kError,
         std::to_string(topic.publishers.size()) + " publishers drive " + name + " (" +
             joined(owners) + "): time jumps between them.",
         "Stop all but one simulator or player, or give each a clock topic or a ROS_DOMAIN_ID of "
         "its own."});
  }
  return findings;
}

std::vector<Finding> check_camera_calibration(const Observation& seen) {
  std::vector<Finding> findings;
  const auto topics = topics_of(seen);
  const auto is_published = [&topics](const std::string& name) {
    const auto topic = topics.find(name);
    return topic != topics.end() && !topic->second.publishers.empty();
  };
  for (const auto& [name, topic] : topics) {
    const bool image =
        !topic.publishers.empty() && type_of(*topic.publishers.front()) == "sensor_msgs/msg/Image";
    if (image && seen.undiscovered.empty() && !topic.subscriptions.empty() &&
        !is_published(camera_info_of(name))) {
      findings.push_back({Severity::kWarning,
                          "The images on " + name +
                              " come without a calibration: nobody publishes " +
                              camera_info_of(name) + ".",
                          "Let the driver publish it, or start a node that does; what only shows "
                          "images needs none."});
    }
  }
  for (const auto& [name, camera] : seen.cameras) {
    if (!(camera.focal_length > 0.0)) {
      findings.push_back({Severity::kError,
                          "The camera of " + name + " is not calibrated: its focal length is 0.",
                          "Calibrate it, and give the file to its driver."});
    }
  }
  return findings;
}

}  // namespace pipescout::host::doctor
