// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace pipescout {

/// Thrown by `ActionHandlers::decide`: rejects the goal and says why. The answer to a goal has no
/// room for a reason in ROS 2, so the server logs it ("action '/a': goal ID rejected: WHY"), before
/// it answers: on /rosout everybody hears it, and `pipescout action send_goal` shows it.
class GoalRejected : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace pipescout
