// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// Little-endian bytes, as MCAP and the bags of ROS 1 have them.
namespace pipescout::bags {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

/// Leaves new elements as they are: buffers that are filled right after they grow need no zeros.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
  using value_type = T;
  template <class U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
};

using Bytes = std::vector<std::byte, UninitializedAllocator<std::byte>>;
using ByteView = std::span<const std::byte>;

[[nodiscard]] inline ByteView bytes_of(std::string_view text) noexcept {
  return std::as_bytes(std::span(text.data(), text.size()));
}
[[nodiscard]] inline std::string_view text_of(ByteView bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline void append(Bytes& to, ByteView bytes) {
  if (!bytes.empty()) {
    const std::size_t start = to.size();
    to.resize(start + bytes.size());
    std::memcpy(to.data() + start, bytes.data(), bytes.size());
  }
}

template <class T>
requires std::is_arithmetic_v<T>
void append_number(Bytes& to, T value) {
  append(to, std::as_bytes(std::span(&value, 1)));
}

/// With its length in 32 bits.
inline void append_text(Bytes& to, std::string_view text) {
  append_number(to, static_cast<std::uint32_t>(text.size()));
  append(to, bytes_of(text));
}

/// Takes fields off the front of some bytes; gives none where too few are left.
class ByteCursor {
 public:
  explicit ByteCursor(ByteView bytes) noexcept : bytes_(bytes) {}

  [[nodiscard]] std::size_t position() const noexcept { return position_; }
  [[nodiscard]] std::size_t left() const noexcept { return bytes_.size() - position_; }

  template <class T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] std::optional<T> number() noexcept {
    if (left() < sizeof(T)) {
      return std::nullopt;
    }
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }
  [[nodiscard]] std::optional<ByteView> bytes(std::uint64_t size) noexcept {
    if (left() < size) {
      return std::nullopt;
    }
    const ByteView result = bytes_.subspan(position_, static_cast<std::size_t>(size));
    position_ += result.size();
    return result;
  }
  /// Bytes behind their length in 32 bits.
  [[nodiscard]] std::optional<ByteView> sized_bytes() noexcept {
    const auto size = number<std::uint32_t>();
    return size ? bytes(*size) : std::nullopt;
  }
  [[nodiscard]] std::optional<std::string_view> text() noexcept {
    const auto content = sized_bytes();
    return content ? std::optional(text_of(*content)) : std::nullopt;
  }

 private:
  ByteView bytes_;
  std::size_t position_ = 0;
};

}  // namespace pipescout::bags
