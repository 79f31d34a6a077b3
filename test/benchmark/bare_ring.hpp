// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace pipescout::benchmarks {

/// The least that a message between two processes can cost: a ring of shared memory, one copy in,
/// one copy out, and a futex. One sender, one receiver that keeps up; nothing is checked.
class BareRing {
 public:
  /// Bytes of the largest message.
  static constexpr std::size_t kSlotBytes = std::size_t{8} << 20U;

  /// Opens the ring of that name, or makes it. Throws std::runtime_error.
  explicit BareRing(const std::string& name);
  BareRing(const BareRing&) = delete;
  BareRing& operator=(const BareRing&) = delete;
  ~BareRing();

  /// Takes the name away; who has opened the ring keeps it.
  static void remove(const std::string& name);

  void send(std::span<const std::uint8_t> message);
  /// Waits for the next message and copies it into `message`; returns its size.
  std::size_t receive(std::span<std::uint8_t> message);

 private:
  static constexpr std::size_t kSlots = 2;

  struct Header {
    std::atomic<std::uint32_t> sent;  // also the futex
    std::uint32_t sizes[kSlots];
  };

  Header* header_ = nullptr;
  std::uint8_t* slots_ = nullptr;
  std::uint32_t received_ = 0;
};

}  // namespace pipescout::benchmarks
