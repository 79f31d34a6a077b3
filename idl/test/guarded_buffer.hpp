// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace pipescout::testing {

/// Bytes whose end is the end of readable memory: reading one byte further is a fault at once,
/// in any kind of build.
class GuardedBuffer {
 public:
  explicit GuardedBuffer(std::size_t capacity);
  ~GuardedBuffer();
  GuardedBuffer(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(const GuardedBuffer&) = delete;

  /// Copies the bytes, at most `capacity` of them, against the guard.
  std::span<const std::byte> assign(std::span<const std::byte> bytes);

 private:
  std::size_t readable_;
  std::size_t mapped_;
  std::byte* memory_;
};

}  // namespace pipescout::testing
