// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace pipescout::test {

/// Counts what the current thread takes from the heap while it lives: every malloc, calloc, realloc
/// and aligned allocation, by C++ `new` too, in this program and in its shared libraries.
/// One at a time per thread.
class HeapGuard {
 public:
  HeapGuard();
  ~HeapGuard();
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;

  /// Allocations since construction.
  [[nodiscard]] std::size_t allocations() const;
};

}  // namespace pipescout::test
