// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "pipescout/runtime/qos.hpp"

namespace pipescout {

/// A topic of the catalogue: its name (relative to the robot's namespace unless it begins with
/// '/'), its type and its QoS.
template <class T>
struct Topic {
  using Message = T;
  std::string_view name;
  QoS qos;              ///< what publishers offer
  QoS requested = qos;  ///< what subscriptions ask for
};

}  // namespace pipescout
