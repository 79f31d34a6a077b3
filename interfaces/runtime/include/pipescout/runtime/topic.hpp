// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "pipescout/runtime/qos.hpp"

namespace pipescout {

/// Handling of messages that arrive while the component of a subscription is not active.
enum class WhileInactive {
  kKeep,  ///< the last `depth` wait, and are delivered when it is activated: states, measurements
  kDrop,  ///< they are dropped and counted, and so is what still waits when it is deactivated:
          ///< commands, which are meant for the moment at which they are given
};

/// A topic of the catalogue: its name (relative to the robot's namespace unless it begins with
/// '/'), its type and its QoS.
template <class T>
struct Topic {
  using Message = T;
  std::string_view name;
  QoS qos;              ///< what publishers offer
  QoS requested = qos;  ///< what subscriptions ask for
  WhileInactive while_inactive = WhileInactive::kKeep;
};

}  // namespace pipescout
