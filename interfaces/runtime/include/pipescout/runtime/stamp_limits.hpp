// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// What is wrong with the stamp of a message, as `Component::report_fault` takes it.
struct StampFault {
  bool in_future = false;  ///< else it is stale
  std::string counter;     ///< INPUT.header.stamp.stale or INPUT.header.stamp.in_future
  std::string text;
};

/// Which stamps an input may have: the parameters `maximum_age` and `maximum_lead` of components.
struct StampLimits {
  double maximum_age = 0;   ///< s; 0: any age is right
  double maximum_lead = 0;  ///< s ahead of the clock

  /// Pure. `input` is what the message is called in counters and texts.
  [[nodiscard]] std::optional<StampFault> find_fault(std::string_view input, Time stamp,
                                                     Time now) const;
};

}  // namespace pipescout
