// SPDX-License-Identifier: Apache-2.0
// What a broken or hostile peer can send: every type must refuse it, or read it as some message,
// without a fault, without reading past the end, and without allocating out of proportion.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "all_types.hpp"
#include "allocation_counter.hpp"
#include "guarded_buffer.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kEncapsulation = 4;
constexpr std::size_t kSampleSize = 16 * 1024;
constexpr std::size_t kPlausibleSize = 1024;

/// A byte on the wire can become this many in memory: an empty string (4 bytes) takes 32, and a
/// vector that grows element by element asks for up to three times what it ends with in all.
constexpr std::size_t kMemoryPerByte = 24;
/// Room made ahead of the elements of a sequence, on all levels of nesting.
constexpr std::size_t kMemoryAhead = 64 * 1024;

/// Reads from guarded memory and checks the allocations.
class Reader {
 public:
  bool read(const MessageType& type, std::span<const std::byte> bytes, void* message) {
    const auto guarded = buffer_.assign(bytes);
    const std::size_t before = testing::allocated_bytes();
    const bool accepted = type.deserialize(guarded, message);
    EXPECT_LE(testing::allocated_bytes() - before, kMemoryPerByte * bytes.size() + kMemoryAhead)
        << type.name;
    return accepted;
  }

 private:
  testing::GuardedBuffer buffer_{2 * kSampleSize};
};

Bytes serialized(const MessageType& type, const void* message) {
  Bytes bytes(type.serialized_size(message));
  bytes.resize(type.serialize(message, bytes));
  return bytes;
}

/// Words of which most are 0 or 1, as lengths, booleans and numbers at once, so that many of these
/// are messages with content.
Bytes plausible_bytes(std::mt19937& engine) {
  std::uniform_int_distribution<int> percent(0, 99);
  Bytes bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  bytes.resize(kPlausibleSize);
  for (std::size_t i = kEncapsulation; i + 4 <= bytes.size(); i += 4) {
    const int kind = percent(engine);
    const std::uint32_t word = kind < 50   ? 0
                               : kind < 95 ? 1
                               : kind < 98 ? 3
                                           : static_cast<std::uint32_t>(engine());
    std::memcpy(&bytes[i], &word, sizeof word);
  }
  return bytes;
}

/// Messages of the type with some content, serialised; found by trial.
std::vector<Bytes> sample_messages(const MessageType& type, std::mt19937& engine) {
  Reader reader;
  std::vector<Bytes> samples{serialized(type, type.create().get())};
  for (int trial = 0; trial < 40; ++trial) {
    const auto message = type.create();
    // Refused for the bytes that are left, most often, or where it was cut; what was read until
    // then is a message.
    static_cast<void>(reader.read(type, plausible_bytes(engine), message.get()));
    samples.push_back(serialized(type, message.get()));
  }
  std::ranges::stable_sort(samples, {}, &Bytes::size);
  return {samples.end() - std::min<std::ptrdiff_t>(4, std::ssize(samples)), samples.end()};
}

class HostileBytesTest : public ::testing::Test {
 protected:
  /// Whether the bytes are read as a message; if so it must be whole: it can be written, and what
  /// was written is read as the same.
  bool accepts(const MessageType& type, std::span<const std::byte> bytes) {
    const auto message = type.create();
    if (!reader_.read(type, bytes, message.get())) {
      return false;
    }
    const Bytes first = serialized(type, message.get());
    EXPECT_FALSE(first.empty());
    const auto copy = type.create();
    EXPECT_TRUE(reader_.read(type, first, copy.get()));
    EXPECT_EQ(serialized(type, copy.get()), first);
    return true;
  }

  Reader reader_;
  std::mt19937 engine_{20080315};
};

TEST_F(HostileBytesTest, MessagesWithContentSurviveARoundTrip) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    for (const Bytes& sample : sample_messages(*type, engine_)) {
      EXPECT_TRUE(accepts(*type, sample));
    }
  }
}

TEST_F(HostileBytesTest, EveryTruncationIsRefused) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    for (const Bytes& sample : sample_messages(*type, engine_)) {
      const std::size_t step = 1 + sample.size() / 512;
      for (std::size_t size = 0; size < sample.size(); size += step) {
        EXPECT_FALSE(accepts(*type, std::span(sample).first(size)))
            << size << " of " << sample.size();
      }
      EXPECT_FALSE(accepts(*type, std::span(sample).first(sample.size() - 1)));
    }
  }
}

TEST_F(HostileBytesTest, OnlyPlainCdrIsAccepted) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    Bytes bytes = serialized(*type, type->create().get());
    for (int high = 0; high < 256; high += 51) {
      for (int low = 0; low < 16; ++low) {
        bytes[0] = static_cast<std::byte>(high);
        bytes[1] = static_cast<std::byte>(low);
        if (high != 0 || low > 1) {
          EXPECT_FALSE(accepts(*type, bytes)) << high << ' ' << low;
        }
      }
    }
  }
}

TEST_F(HostileBytesTest, FlippedBitsDoNoHarm) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    for (const Bytes& sample : sample_messages(*type, engine_)) {
      std::uniform_int_distribution<std::size_t> position(kEncapsulation, sample.size() - 1);
      std::uniform_int_distribution<int> bit(0, 7);
      for (int trial = 0; trial < 200; ++trial) {
        Bytes bytes = sample;
        for (int flip = 0; flip <= trial % 3; ++flip) {
          bytes[position(engine_)] ^= std::byte{1} << bit(engine_);
        }
        accepts(*type, bytes);
      }
    }
  }
}

TEST_F(HostileBytesTest, HugeLengthsDoNoHarm) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    for (Bytes bytes : sample_messages(*type, engine_)) {
      const std::size_t step = 4 * (1 + bytes.size() / 1024);
      const std::size_t end = bytes.size();
      bytes.resize(kSampleSize);  // more bytes behind the message, for a length to claim
      for (std::size_t at = kEncapsulation; at + 4 <= end; at += step) {
        const auto rest = static_cast<std::uint32_t>(bytes.size() - at - 4);
        std::uint32_t original = 0;
        std::memcpy(&original, &bytes[at], sizeof original);
        for (const std::uint32_t length :
             std::array{0xffffffffu, 0x80000000u, 0x10000000u, rest + 1, rest, rest / 8}) {
          std::memcpy(&bytes[at], &length, sizeof length);
          accepts(*type, bytes);
        }
        std::memcpy(&bytes[at], &original, sizeof original);
      }
    }
  }
}

TEST_F(HostileBytesTest, NoiseDoesNoHarm) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    std::uniform_int_distribution<int> any(0, 255);
    std::uniform_int_distribution<std::size_t> size(0, 600);
    for (int trial = 0; trial < 200; ++trial) {
      Bytes bytes(size(engine_));
      std::ranges::generate(bytes, [&] { return static_cast<std::byte>(any(engine_)); });
      if (bytes.size() >= 2) {
        bytes[0] = std::byte{0};
        bytes[1] = static_cast<std::byte>(trial % 2);
      }
      accepts(*type, bytes);
    }
  }
}

TEST_F(HostileBytesTest, AMessageStaysUsableAfterRefusedBytes) {
  for (const MessageType* type : testing::all_types()) {
    SCOPED_TRACE(type->name);
    const auto message = type->create();
    const Bytes good = serialized(*type, message.get());
    for (const Bytes& sample : sample_messages(*type, engine_)) {
      reader_.read(*type, std::span(sample).first(sample.size() - 1), message.get());
      ASSERT_TRUE(reader_.read(*type, good, message.get()));
      EXPECT_EQ(serialized(*type, message.get()), good);
    }
  }
}

}  // namespace
}  // namespace pipescout
