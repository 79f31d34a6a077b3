// SPDX-License-Identifier: Apache-2.0
#include "guarded_buffer.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace pipescout::testing {

GuardedBuffer::GuardedBuffer(std::size_t capacity) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  readable_ = (capacity + page - 1) / page * page;
  mapped_ = readable_ + page;
  void* const memory =
      mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    throw std::system_error(errno, std::generic_category(), "mmap");
  }
  memory_ = static_cast<std::byte*>(memory);
  if (mprotect(memory_ + readable_, page, PROT_NONE) != 0) {
    const int error = errno;
    munmap(memory_, mapped_);
    throw std::system_error(error, std::generic_category(), "mprotect");
  }
}

GuardedBuffer::~GuardedBuffer() {
  munmap(memory_, mapped_);
}

std::span<const std::byte> GuardedBuffer::assign(std::span<const std::byte> bytes) {
  if (bytes.size() > readable_) {
    throw std::length_error("more bytes than the buffer holds");
  }
  std::byte* const first = memory_ + (readable_ - bytes.size());
  std::ranges::copy(bytes, first);
  return {first, bytes.size()};
}

}  // namespace pipescout::testing
