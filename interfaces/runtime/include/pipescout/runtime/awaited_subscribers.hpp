// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/publisher.hpp"

namespace pipescout {

/// Nodes, named in parameters of a component, that must have subscribed to what it publishes before
/// it begins: none of them misses the first message, however they are spread over processes. Who
/// else listens, a recorder beside a mission for example, makes no difference. Who is still missing
/// after 5 s is logged, once.
///
/// To be used in the node's default group.
class AwaitedSubscribers {
 public:
  /// Declares the parameter `wait_for_subscribers`, a list of node names, and what is delayed in
  /// its description: "before the replay starts". Relative names are below the node's namespace.
  /// `topics`: with a name each, for a parameter `wait_for_subscribers.<topic>` for each of several
  /// publishers; empty: one publisher.
  AwaitedSubscribers(Node& node, std::string_view what,
                     const std::vector<std::string>& topics = {});
  AwaitedSubscribers(const AwaitedSubscribers&) = delete;
  AwaitedSubscribers& operator=(const AwaitedSubscribers&) = delete;
  ~AwaitedSubscribers();

  /// For PublisherEvents::matched of the publishers: a match is no change of the graph.
  [[nodiscard]] std::function<void(std::size_t)> on_matched();
  /// Reads the parameters. `arrived` is called once, as soon as all are there: at once, within this
  /// call, or later in the node's default group. `publishers`: one for each of the topics; null
  /// where it is not published, so that nobody is waited for there. Throws std::invalid_argument,
  /// with the name of the parameter, for an invalid node name.
  void watch(const std::vector<std::shared_ptr<UntypedPublisher>>& publishers,
             std::function<void()> arrived);
  /// `arrived` is not called any more.
  void stop();

  /// False before `watch` and after `stop`. Once true it stays so: who listened may go.
  [[nodiscard]] bool all_there() const;
  /// Who has not subscribed to what, for people: "/weld_locator to /eddy_current, ...".
  [[nodiscard]] std::string missing() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace pipescout
