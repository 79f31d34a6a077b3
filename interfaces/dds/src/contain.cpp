// SPDX-License-Identifier: Apache-2.0
#include "contain.hpp"

#include <fastdds/dds/log/Log.hpp>

namespace pipescout::dds {

void log_contained(const char* what, const char* reason) noexcept {
  try {
    EPROSIMA_LOG_ERROR(PIPESCOUT, "exception in " << what << ": " << reason);
  } catch (...) {
    // Nothing is left to report it with.
  }
}

}  // namespace pipescout::dds
