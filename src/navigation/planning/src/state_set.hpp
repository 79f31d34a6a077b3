// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pipescout::navigation {

/// Keys of states in a table with open addressing, which is cleared at no cost.
class StateSet {
 public:
  void clear() {
    count_ = 0;
    if (++query_ == 0) {
      slots_.assign(slots_.size(), {});
      query_ = 1;
    }
  }
  [[nodiscard]] bool contains(std::uint64_t key) const {
    return !slots_.empty() && slots_[slot_of(key)].query == query_;
  }
  void insert(std::uint64_t key) {
    if (2 * (count_ + 1) > slots_.size()) {
      grow();
    }
    Slot& slot = slots_[slot_of(key)];
    if (slot.query != query_) {
      slot = {key, query_};
      ++count_;
    }
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t query = 0;
  };

  /// Where the key is, or would be.
  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const {
    // Fibonacci hashing (Knuth, "The Art of Computer Programming", volume 3, section 6.4).
    constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
    constexpr unsigned kUpperHalf = 32;
    std::size_t at = static_cast<std::size_t>((key * kGolden) >> kUpperHalf) & (slots_.size() - 1);
    while (slots_[at].query == query_ && slots_[at].key != key) {
      at = (at + 1) & (slots_.size() - 1);
    }
    return at;
  }
  void grow() {
    constexpr std::size_t kSmallest = 4096;
    std::vector<Slot> old = std::exchange(slots_, {});
    slots_.resize(old.empty() ? kSmallest : 2 * old.size());
    for (const Slot& slot : old) {
      if (slot.query == query_) {
        slots_[slot_of(slot.key)] = slot;
      }
    }
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
  std::uint32_t query_ = 1;
};

}  // namespace pipescout::navigation
