// SPDX-License-Identifier: Apache-2.0
#include "bare_ring.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>

namespace pipescout::benchmarks {
namespace {

constexpr std::size_t kHeaderBytes = 4096;

}  // namespace

BareRing::BareRing(const std::string& name) {
  const int file = shm_open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const std::size_t size = kHeaderBytes + kSlots * kSlotBytes;
  void* memory = MAP_FAILED;
  if (file >= 0 && ftruncate(file, static_cast<off_t>(size)) == 0) {
    memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
  }
  if (file >= 0) {
    close(file);
  }
  if (memory == MAP_FAILED) {
    throw std::runtime_error("no shared memory for the bare ring");
  }
  header_ = static_cast<Header*>(memory);
  slots_ = static_cast<std::uint8_t*>(memory) + kHeaderBytes;
  received_ = header_->sent.load();
}

BareRing::~BareRing() {
  munmap(header_, kHeaderBytes + kSlots * kSlotBytes);
}

void BareRing::remove(const std::string& name) {
  shm_unlink(name.c_str());
}

void BareRing::send(std::span<const std::uint8_t> message) {
  const std::uint32_t slot = header_->sent.load(std::memory_order_relaxed) % kSlots;
  std::memcpy(slots_ + slot * kSlotBytes, message.data(), message.size());
  header_->sizes[slot] = static_cast<std::uint32_t>(message.size());
  header_->sent.fetch_add(1, std::memory_order_release);
  syscall(SYS_futex, &header_->sent, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

std::size_t BareRing::receive(std::span<std::uint8_t> message) {
  while (header_->sent.load(std::memory_order_acquire) == received_) {
    syscall(SYS_futex, &header_->sent, FUTEX_WAIT, received_, nullptr, nullptr, 0);
  }
  const std::uint32_t slot = received_ % kSlots;
  ++received_;
  const std::size_t size = header_->sizes[slot];
  std::memcpy(message.data(), slots_ + slot * kSlotBytes, size);
  return size;
}

}  // namespace pipescout::benchmarks
