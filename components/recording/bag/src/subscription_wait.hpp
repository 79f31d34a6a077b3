// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/timer.hpp"

namespace pipescout {

/// Waits until every subscription that is known to want these publishers' messages is matched, and
/// neither the graph nor the matches have changed for a while: by then who ran before is found, and
/// has found the publishers. Who is still not matched after 5 s is logged, once.
///
/// For the node's default group.
class SubscriptionWait {
 public:
  /// `quiet`: for how long nothing changes, s by the steady clock. `ready` is called once, in the
  /// group, and may not destroy this.
  SubscriptionWait(Node& node, std::vector<std::shared_ptr<UntypedPublisher>> publishers,
                   Duration quiet, std::function<void()> ready);

  /// To be called after each change of the graph or of the matches.
  void look();

 private:
  /// Who is not matched yet, for people: "/listener to /chatter".
  [[nodiscard]] std::string missing() const;
  void end();

  Node& node_;
  std::vector<std::shared_ptr<UntypedPublisher>> publishers_;
  std::function<void()> ready_;
  Timer quiet_;
  Timer complaint_;
};

}  // namespace pipescout
