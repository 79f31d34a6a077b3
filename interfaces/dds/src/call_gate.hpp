// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace pipescout::dds {

/// Lets calls through until it is closed; closing waits for those in progress. Fast DDS does not
/// wait for a listener call when the listener is taken away, hence this.
class CallGate {
 public:
  /// Held while a call is in progress.
  class Pass {
   public:
    explicit Pass(CallGate& gate) noexcept : gate_(gate), entered_(gate.enter()) {}
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;
    ~Pass() {
      if (entered_) {
        gate_.leave();
      }
    }
    explicit operator bool() const noexcept { return entered_; }

   private:
    CallGate& gate_;
    const bool entered_;
  };

  void close() noexcept {
    std::uint32_t state = state_.fetch_or(kClosed, std::memory_order_acq_rel) | kClosed;
    while (state != kClosed) {
      state_.wait(state, std::memory_order_acquire);
      state = state_.load(std::memory_order_acquire);
    }
  }

 private:
  static constexpr std::uint32_t kClosed = 0x8000'0000;

  bool enter() noexcept {
    if ((state_.fetch_add(1, std::memory_order_acq_rel) & kClosed) == 0) {
      return true;
    }
    leave();
    return false;
  }

  void leave() noexcept {
    if ((state_.fetch_sub(1, std::memory_order_acq_rel) & kClosed) != 0) {
      state_.notify_all();
    }
  }

  std::atomic<std::uint32_t> state_{0};  // calls in progress, and whether it is closed
};

}  // namespace pipescout::dds
