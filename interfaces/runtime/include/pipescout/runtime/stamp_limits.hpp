// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// A fault of a message's stamp, for `Component::report_fault`.
struct StampFault {
  bool in_future = false;  ///< else it is stale
  std::string counter;     ///< INPUT.header.stamp.stale or INPUT.header.stamp.in_future
  std::string text;
};

/// Limits of the stamps of an input: the parameters `maximum_age` and `maximum_lead` of components.
struct StampLimits {
  double maximum_age = 0;   ///< s; 0: any age is accepted
  double maximum_lead = 0;  ///< s ahead of the clock

  /// Pure. `input` is the name of the message in counters and texts. While `now` is zero nothing is
  /// a fault: a simulated clock stands there until its first message, which may come after others.
  [[nodiscard]] std::optional<StampFault> find_fault(std::string_view input, Time stamp,
                                                     Time now) const;
};

}  // namespace pipescout
