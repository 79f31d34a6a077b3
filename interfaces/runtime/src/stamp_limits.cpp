// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/stamp_limits.hpp"

#include "text_for_people.hpp"

namespace pipescout {

std::optional<StampFault> StampLimits::find_fault(std::string_view input, Time stamp,
                                                  Time now) const {
  if (now == Time{}) {
    return std::nullopt;
  }
  const double age = to_seconds(now - stamp);
  const std::string name(input);
  if (maximum_age > 0.0 && age > maximum_age) {
    return StampFault{.in_future = false,
                      .counter = name + ".header.stamp.stale",
                      .text = name + ": a message is " + text_for_people(age) + " s old"};
  }
  if (-age > maximum_lead) {
    return StampFault{.in_future = true,
                      .counter = name + ".header.stamp.in_future",
                      .text = name + ": a message has a stamp " + text_for_people(-age) +
                              " s ahead of the clock"};
  }
  return std::nullopt;
}

}  // namespace pipescout
