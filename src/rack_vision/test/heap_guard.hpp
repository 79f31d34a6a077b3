// SPDX-License-Identifier: Apache-2.0
// Include in one source of a program only: it replaces malloc and its kin.
#pragma once

#include <cerrno>
#include <cstddef>

namespace pipescout::rack_vision::test {

inline thread_local bool counting = false;
inline thread_local std::size_t allocations_counted = 0;

inline void note_allocation() {
  if (counting) {
    ++allocations_counted;
  }
}

/// Counts what the current thread takes from the heap while it lives: every malloc, calloc, realloc
/// and aligned allocation, by C++ `new` too, in this program and in its shared libraries.
/// One at a time per thread.
class HeapGuard {
 public:
  HeapGuard() {
    allocations_counted = 0;
    counting = true;
  }
  ~HeapGuard() { counting = false; }
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;

  /// Allocations since construction.
  [[nodiscard]] std::size_t allocations() const { return allocations_counted; }
};

}  // namespace pipescout::rack_vision::test

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// A sanitizer owns malloc and offers a hook instead.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {
const int hooks_installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { pipescout::rack_vision::test::note_allocation(); },
    [](const volatile void*) {});
}  // namespace

#else

// The program's own definitions take the place of glibc's for its shared libraries as well.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  pipescout::rack_vision::test::note_allocation();
  return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) noexcept {
  pipescout::rack_vision::test::note_allocation();
  return __libc_calloc(number, size);
}

void* realloc(void* memory, std::size_t size) noexcept {
  pipescout::rack_vision::test::note_allocation();
  return __libc_realloc(memory, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  pipescout::rack_vision::test::note_allocation();
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  pipescout::rack_vision::test::note_allocation();
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}

#endif
