// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "bytes.hpp"

namespace pipescout::bags {

/// The CRC32 of zlib and MCAP. `before`: that of the bytes in front of these.
[[nodiscard]] std::uint32_t crc32(ByteView bytes, std::uint32_t before = 0) noexcept;

/// Compresses with zstd, keeping its tables between calls.
class ZstdCompressor {
 public:
  explicit ZstdCompressor(int level);
  ~ZstdCompressor();
  ZstdCompressor(const ZstdCompressor&) = delete;
  ZstdCompressor& operator=(const ZstdCompressor&) = delete;
  /// One frame with its size and checksum.
  void compress(ByteView content, Bytes& into);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// One LZ4 frame.
void compress_lz4(ByteView content, Bytes& into);

enum class Codec : std::uint8_t { kZstd, kLz4, kBzip2 };

/// How far compressed bytes could be unpacked.
enum class Unpacked : std::uint8_t { kWhole, kCut, kDamaged, kTooLarge };

/// Unpacks one frame after another. `into` grows with what comes out, never in advance by what the
/// bytes say of themselves, and keeps what came out before an error. Stops with kTooLarge beyond
/// `limit` bytes.
[[nodiscard]] Unpacked unpack(Codec codec, ByteView compressed, std::uint64_t limit, Bytes& into);

/// Compresses or unpacks a whole file, in pieces. The target is new. Throws BagError.
void compress_file(const std::filesystem::path& from, const std::filesystem::path& to, int level);
/// False when the source is cut: the target then holds what was there.
[[nodiscard]] bool unpack_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace pipescout::bags
