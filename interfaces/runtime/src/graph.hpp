// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "broker.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout {

/// The graph with what only the process itself adds to it.
class OwnGraph : public Graph {
 public:
  using Graph::add_shared_endpoint;
  /// Assigns a publisher of the process to one more of the nodes for which it speaks. Does nothing
  /// where it is assigned to it already. Throws std::invalid_argument when the node is not in this
  /// process.
  virtual void add_shared_endpoint(const NodeName& node,
                                   const std::shared_ptr<UntypedPublisher>& publisher) = 0;
};

/// The graph of a process whose endpoints the broker matches. Must be made before any endpoint, and
/// must go before the broker's transport.
[[nodiscard]] std::unique_ptr<OwnGraph> create_graph(const std::shared_ptr<Broker>& broker);

}  // namespace pipescout
