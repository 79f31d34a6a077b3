// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "pipescout/runtime/context.hpp"

namespace pipescout::testing {

struct ActionRace {
  std::size_t goals = 1000;
  /// Goals on their way at a time; each lane sends its next goal as soon as its last one ended.
  std::size_t lanes = 4;
};

/// What came of the goals, by the word of the server and that of the client.
struct ActionRaceReport {
  std::size_t succeeded = 0;
  std::size_t canceled = 0;
  /// Without an end that the client was told of, or with one that says it is not known.
  std::size_t lost = 0;
  /// Told otherwise than the server ended it: another end or result, a second end, an answer to the
  /// cancellation that contradicts the end, callbacks out of order.
  std::size_t wrong = 0;
  double seconds = 0.0;
  std::vector<std::string> faults;  ///< the first few, in words
};

/// Sends goals from one node to another, each with an executor of several threads and reentrant
/// groups. Half of the goals end at once; a quarter are cancelled while another thread of the
/// server ends them with success, and a quarter after that. The contexts may be the same. Ends
/// early when no goal has ended for a minute; those that are on their way count as lost.
[[nodiscard]] ActionRaceReport race_actions(const std::shared_ptr<Context>& server,
                                            const std::shared_ptr<Context>& client,
                                            const ActionRace& race);

}  // namespace pipescout::testing
