// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/composition.hpp"

namespace pipescout::host {

/// Gives the calling thread, and those that it makes from now on, the niceness or the real-time
/// priority of the settings. Returns what the system has not permitted, and what would help; empty
/// when all is as asked for.
[[nodiscard]] std::string apply_to_this_thread(const ExecutorSettings& settings);

}  // namespace pipescout::host
