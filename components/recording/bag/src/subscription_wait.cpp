// SPDX-License-Identifier: Apache-2.0
#include "subscription_wait.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/names.hpp"

namespace pipescout {
namespace {

/// Longer than processes need to find each other.
constexpr Duration kUsualWait = std::chrono::seconds(5);

bool wants(const GraphEndpoint& endpoint, const UntypedPublisher& publisher) {
  return !endpoint.is_publisher && endpoint.wire_topic == publisher.topic().name &&
         endpoint.wire_type == publisher.topic().type->dds_name &&
         !incompatibility(publisher.qos(), endpoint.qos);
}

}  // namespace

SubscriptionWait::SubscriptionWait(Node& node,
                                   std::vector<std::shared_ptr<UntypedPublisher>> publishers,
                                   Duration quiet, std::function<void()> ready)
    : node_(node),
      publishers_(std::move(publishers)),
      ready_(std::move(ready)),
      quiet_(node.default_group(), quiet, [this] { end(); }),
      complaint_(node.default_group(), kUsualWait, [this] {
        complaint_.set_enabled(false);
        const std::string names = missing();
        node_.logger().warn("before it plays it waits for " +
                            (names.empty() ? "the nodes of the network to come to rest"
                                           : "the subscriptions of " + names));
      }) {}

void SubscriptionWait::look() {
  if (ready_) {
    quiet_.reset();
  }
}

std::string SubscriptionWait::missing() const {
  std::set<std::string> names;
  for (const GraphEndpoint& endpoint : node_.context().graph().endpoints()) {
    for (const auto& publisher : publishers_) {
      if (!endpoint.in_this_process && wants(endpoint, *publisher) &&
          !publisher->is_matched_remotely(endpoint.gid)) {
        const auto topic = demangle_topic_name(endpoint.wire_topic);
        names.insert((endpoint.node ? endpoint.node->fully_qualified() : "somebody") + " to " +
                     (topic ? topic->name : endpoint.wire_topic));
      }
    }
  }
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

void SubscriptionWait::end() {
  if (!ready_ || !missing().empty()) {
    return;  // its match comes, and with it a look
  }
  quiet_.set_enabled(false);
  complaint_.set_enabled(false);
  std::set<std::string> silent;
  std::size_t subscriptions = 0;
  for (const auto& publisher : publishers_) {
    const std::size_t count = publisher->subscription_count();
    subscriptions += count;
    if (count == 0) {
      const auto topic = demangle_topic_name(publisher->topic().name);
      silent.insert(topic ? topic->name : publisher->topic().name);
    }
  }
  std::string text = "it plays; matched subscriptions: " + std::to_string(subscriptions);
  for (const std::string& topic : silent) {
    text += (topic == *silent.begin() ? "; nobody listens to " : ", ") + topic;
  }
  node_.logger().info(text);
  std::exchange(ready_, nullptr)();
}

}  // namespace pipescout
