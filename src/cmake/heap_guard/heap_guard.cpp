// SPDX-License-Identifier: Apache-2.0
#include "heap_guard.hpp"

#include <cerrno>

namespace {

thread_local bool counting = false;
thread_local std::size_t count = 0;

void note_allocation() {
  if (counting) {
    ++count;
  }
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// A sanitizer owns malloc and offers a hook instead.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {
const int hooks_installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { note_allocation(); }, [](const volatile void*) {});
}  // namespace

#else

// The program's own definitions take the place of glibc's for its shared libraries as well.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  note_allocation();
  return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) {
  note_allocation();
  return __libc_calloc(number, size);
}

void* realloc(void* memory, std::size_t size) {
  note_allocation();
  return __libc_realloc(memory, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note_allocation();
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  note_allocation();
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}

#endif

namespace pipescout::test {

HeapGuard::HeapGuard() {
  count = 0;
  counting = true;
}

HeapGuard::~HeapGuard() {
  counting = false;
}

std::size_t HeapGuard::allocations() const {
  return count;
}

}  // namespace pipescout::test
