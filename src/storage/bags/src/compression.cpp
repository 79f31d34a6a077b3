// SPDX-License-Identifier: Apache-2.0
#include "compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "file_access.hpp"
#include "pipescout/bags/bag_error.hpp"

namespace pipescout::bags {
namespace {

using ZstdContext = std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)>;

/// Bytes by which the result of unpacking grows.
constexpr std::size_t kGrowth = std::size_t{256} * 1024;

ZstdContext zstd_context(int level) {
  ZstdContext context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  if (!context) {
    throw std::bad_alloc();
  }
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  return context;
}

/// Room at the end of `into`, doubled as it fills, up to just beyond the limit.
std::span<std::byte> room(Bytes& into, std::size_t used, std::uint64_t limit) {
  if (into.size() == used) {
    const std::size_t grown = std::max(used * 2, used + kGrowth);
    into.resize(static_cast<std::size_t>(std::min<std::uint64_t>(grown, limit + 1)));
  }
  return std::span(into).subspan(used);
}

Unpacked unpack_zstd(ByteView compressed, std::uint64_t limit, Bytes& into) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  ZSTD_inBuffer input{compressed.data(), compressed.size(), 0};
  std::size_t used = 0;
  std::size_t left = 1;
  while (used <= limit) {
    const auto space = room(into, used, limit);
    ZSTD_outBuffer output{space.data(), space.size(), 0};
    left = ZSTD_decompressStream(context.get(), &output, &input);
    used += output.pos;
    if (ZSTD_isError(left) != 0) {
      into.resize(used);
      return Unpacked::kDamaged;
    }
    if (input.pos == input.size && output.pos < output.size) {
      break;
    }
    if (left == 0 && input.pos == input.size) {
      break;
    }
  }
  into.resize(used);
  if (used > limit) {
    return Unpacked::kTooLarge;
  }
  return left == 0 ? Unpacked::kWhole : Unpacked::kCut;
}

Unpacked unpack_lz4(ByteView compressed, std::uint64_t limit, Bytes& into) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  std::size_t taken = 0;
  std::size_t used = 0;
  std::size_t hint = 1;
  while (used <= limit) {
    const auto space = room(into, used, limit);
    std::size_t written = space.size();
    std::size_t read = compressed.size() - taken;
    hint = LZ4F_decompress(context.get(), space.data(), &written, compressed.data() + taken, &read,
                           nullptr);
    if (LZ4F_isError(hint) != 0) {
      into.resize(used);
      return Unpacked::kDamaged;
    }
    taken += read;
    used += written;
    if (taken == compressed.size() && (hint == 0 || written < space.size())) {
      break;
    }
  }
  into.resize(used);
  if (used > limit) {
    return Unpacked::kTooLarge;
  }
  return hint == 0 ? Unpacked::kWhole : Unpacked::kCut;
}

Unpacked unpack_bzip2(ByteView compressed, std::uint64_t limit, Bytes& into) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
    throw std::bad_alloc();
  }
  stream.next_in = reinterpret_cast<char*>(const_cast<std::byte*>(compressed.data()));
  stream.avail_in = static_cast<unsigned>(
      std::min<std::size_t>(compressed.size(), std::numeric_limits<unsigned>::max()));
  std::size_t used = 0;
  int result = BZ_OK;
  while (used <= limit && result == BZ_OK) {
    const auto space = room(into, used, limit);
    stream.next_out = reinterpret_cast<char*>(space.data());
    stream.avail_out = static_cast<unsigned>(space.size());
    result = BZ2_bzDecompress(&stream);
    const std::size_t written = space.size() - stream.avail_out;
    used += written;
    if (result == BZ_OK && stream.avail_in == 0 && written < space.size()) {
      break;
    }
  }
  BZ2_bzDecompressEnd(&stream);
  into.resize(used);
  if (result != BZ_OK && result != BZ_STREAM_END) {
    return Unpacked::kDamaged;
  }
  if (used > limit) {
    return Unpacked::kTooLarge;
  }
  return result == BZ_STREAM_END ? Unpacked::kWhole : Unpacked::kCut;
}

}  // namespace

struct ZstdCompressor::State {
  ZstdContext context;
};

ZstdCompressor::ZstdCompressor(int level)
    : state_(std::make_unique<State>(State{zstd_context(level)})) {}

ZstdCompressor::~ZstdCompressor() = default;

void ZstdCompressor::compress(ByteView content, Bytes& into) {
  into.resize(ZSTD_compressBound(content.size()));
  const std::size_t size = ZSTD_compress2(state_->context.get(), into.data(), into.size(),
                                          content.data(), content.size());
  if (ZSTD_isError(size) != 0) {
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  }
  into.resize(size);
}

void compress_lz4(ByteView content, Bytes& into) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentSize = content.size();
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  into.resize(LZ4F_compressFrameBound(content.size(), &preferences));
  const std::size_t size =
      LZ4F_compressFrame(into.data(), into.size(), content.data(), content.size(), &preferences);
  if (LZ4F_isError(size) != 0) {
    throw std::runtime_error(std::string("lz4: ") + LZ4F_getErrorName(size));
  }
  into.resize(size);
}

Unpacked unpack(Codec codec, ByteView compressed, std::uint64_t limit, Bytes& into) {
  into.clear();
  if (compressed.empty()) {
    return Unpacked::kCut;
  }
  switch (codec) {
    case Codec::kZstd:
      return unpack_zstd(compressed, limit, into);
    case Codec::kLz4:
      return unpack_lz4(compressed, limit, into);
    case Codec::kBzip2:
      return unpack_bzip2(compressed, limit, into);
  }
  return Unpacked::kDamaged;
}

void compress_file(const std::filesystem::path& from, const std::filesystem::path& to, int level) {
  const InputFile source(from);
  OutputFile target(to);
  const ZstdContext context = zstd_context(level);
  ZSTD_CCtx_setPledgedSrcSize(context.get(), source.size());
  Bytes piece;
  Bytes packed(ZSTD_CStreamOutSize());
  std::uint64_t offset = 0;
  std::size_t left = 1;
  while (left != 0) {
    source.read(offset, kGrowth, piece);
    offset += piece.size();
    const bool last = offset >= source.size();
    ZSTD_inBuffer input{piece.data(), piece.size(), 0};
    do {
      ZSTD_outBuffer output{packed.data(), packed.size(), 0};
      left =
          ZSTD_compressStream2(context.get(), &output, &input, last ? ZSTD_e_end : ZSTD_e_continue);
      if (ZSTD_isError(left) != 0) {
        throw BagError(BagFault::kSystem, from, std::string("zstd: ") + ZSTD_getErrorName(left));
      }
      target.write({std::span(packed).first(output.pos)});
    } while (input.pos < input.size || (last && left != 0));
    if (!last) {
      left = 1;
    }
  }
}

bool unpack_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  const InputFile source(from);
  OutputFile target(to);
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  Bytes piece;
  Bytes unpacked(ZSTD_DStreamOutSize());
  std::uint64_t offset = 0;
  std::size_t left = 1;
  while (offset < source.size()) {
    source.read(offset, kGrowth, piece);
    if (piece.empty()) {
      break;
    }
    ZSTD_inBuffer input{piece.data(), piece.size(), 0};
    bool full = false;
    while (input.pos < input.size || (full && left != 0)) {
      ZSTD_outBuffer output{unpacked.data(), unpacked.size(), 0};
      left = ZSTD_decompressStream(context.get(), &output, &input);
      if (ZSTD_isError(left) != 0) {
        throw BagError(BagFault::kMalformed, from, offset + input.pos, "zstd",
                       ZSTD_getErrorName(left));
      }
      target.write({std::span(unpacked).first(output.pos)});
      full = output.pos == output.size;
    }
    offset += piece.size();
  }
  return left == 0;
}

}  // namespace pipescout::bags
