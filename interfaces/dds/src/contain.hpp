// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <utility>

namespace pipescout::dds {

/// Reports through Fast DDS's log.
void log_contained(const char* what, const char* reason) noexcept;

/// Calls, and keeps every exception from a thread of Fast DDS, which would end the process.
template <class Call>
void contain(const char* what, Call&& call) noexcept {
  try {
    std::forward<Call>(call)();
  } catch (const std::exception& error) {
    log_contained(what, error.what());
  } catch (...) {
    log_contained(what, "not a std::exception");
  }
}

}  // namespace pipescout::dds
