// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pipescout::test {

/// What a file of FLIR's FFF format holds, as far as exiftool looks at it: a header, a directory of
/// two records, the raw counts and the camera's data. Little-endian.
struct SyntheticFlir {
  std::uint16_t width = 8;
  std::uint16_t height = 6;
  std::vector<std::uint16_t> counts = std::vector<std::uint16_t>(48, 20118);
  float emissivity = 0.95F;
  float distance = 1;          // m
  float reflected = 293.15F;   // K
  float atmosphere = 293.15F;  // K
  float window = 293.15F;      // K
  float window_transmission = 1;
  float humidity = 0.5F;
  float r1 = 21106.77F;
  float b = 1501;
  float f = 1;
  std::int32_t o = -7340;
  float r2 = 0.012545258F;
  std::uint16_t median = 20118;
  std::uint16_t span = 4204;
  std::uint32_t taken = 1700000000;  // s since 1970 UTC
  std::string camera = "Test camera";
  std::string lens;

  [[nodiscard]] std::string bytes() const {
    constexpr std::size_t kDirectory = 64;
    constexpr std::size_t kEntry = 32;
    constexpr std::size_t kRaw = kDirectory + 2 * kEntry;
    const std::size_t raw_size = 32 + 2 * counts.size();
    const std::size_t info = kRaw + raw_size;
    constexpr std::size_t kInfoSize = 0x39c;
    std::string out(info + kInfoSize, '\0');
    const auto put = [&out](std::size_t at, const auto& value) {
      std::memcpy(&out[at], &value, sizeof(value));
    };
    std::memcpy(out.data(), "FFF\0PIPESCOUT TEST", 18);
    put(20, std::uint32_t{100});
    put(24, static_cast<std::uint32_t>(kDirectory));
    put(28, std::uint32_t{2});
    const auto entry = [&](std::size_t index, std::uint16_t type, std::size_t at,
                           std::size_t size) {
      put(kDirectory + index * kEntry, type);
      put(kDirectory + index * kEntry + 12, static_cast<std::uint32_t>(at));
      put(kDirectory + index * kEntry + 16, static_cast<std::uint32_t>(size));
    };
    entry(0, 1, kRaw, raw_size);
    entry(1, 0x20, info, kInfoSize);
    put(kRaw, std::uint16_t{2});
    put(kRaw + 2, width);
    put(kRaw + 4, height);
    std::memcpy(&out[kRaw + 32], counts.data(), 2 * counts.size());
    put(info, std::uint16_t{2});
    put(info + 0x20, emissivity);
    put(info + 0x24, distance);
    put(info + 0x28, reflected);
    put(info + 0x2c, atmosphere);
    put(info + 0x30, window);
    put(info + 0x34, window_transmission);
    put(info + 0x3c, humidity);
    put(info + 0x58, r1);
    put(info + 0x5c, b);
    put(info + 0x60, f);
    put(info + 0x70, 0.006569F);
    put(info + 0x74, 0.01262F);
    put(info + 0x78, -0.002276F);
    put(info + 0x7c, -0.00667F);
    put(info + 0x80, 1.9F);
    std::memcpy(&out[info + 0xd4], camera.data(), camera.size());
    std::memcpy(&out[info + 0x170], lens.data(), lens.size());
    put(info + 0x308, o);
    put(info + 0x30c, r2);
    put(info + 0x310, std::uint16_t{100});
    put(info + 0x312, std::uint16_t{60000});
    put(info + 0x338, median);
    put(info + 0x33c, span);
    put(info + 0x384, taken);
    return out;
  }
};

}  // namespace pipescout::test
