// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <libdeflate.h>

#include <random>

#include "compression.hpp"

namespace pipescout::bags {
namespace {

TEST(Crc32, IsThatOfZlibForAnySizePlaceAndParts) {
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926U);
  std::mt19937 random(1);
  Bytes bytes(20'000);
  for (std::byte& each : bytes) {
    each = static_cast<std::byte>(random());
  }
  for (int k = 0; k < 2000; ++k) {
    const std::size_t start = random() % 100;
    const std::size_t size = random() % (k % 2 == 0 ? 3000 : 19'000);
    const auto part = std::span(bytes).subspan(start, size);
    const std::size_t cut = size == 0 ? 0 : random() % size;
    const std::uint32_t expected = libdeflate_crc32(0, part.data(), part.size());
    ASSERT_EQ(crc32(part), size == 0 ? 0 : expected);
    ASSERT_EQ(crc32(part.subspan(cut), crc32(part.first(cut))), size == 0 ? 0 : expected);
  }
}

}  // namespace
}  // namespace pipescout::bags
