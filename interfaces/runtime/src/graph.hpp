// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "broker.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout {

/// The graph of a process whose endpoints the broker matches. Must be made before any endpoint, and
/// must go before the broker's transport.
[[nodiscard]] std::unique_ptr<Graph> create_graph(const std::shared_ptr<Broker>& broker);

}  // namespace pipescout
