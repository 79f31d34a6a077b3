// SPDX-License-Identifier: Apache-2.0
#include "fff_frames.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include "picture_time.hpp"

namespace pipescout {
namespace {

// Places in the header: of the version, the offset of the directory and the number of its entries;
// and in an entry of the directory: of the offset and the size of the record.
constexpr std::size_t kVersionAt = 20;
constexpr std::size_t kDirectoryAt = 24;
constexpr std::size_t kEntriesAt = 28;
constexpr std::size_t kHeaderSize = 64;
constexpr std::size_t kEntrySize = 32;
constexpr std::size_t kRecordAt = 12;
constexpr std::size_t kRecordSizeAt = 16;
// Versions of the format are 100 to 199: with the bytes the other way round it is none of them.
constexpr std::uint32_t kLeastVersion = 100;
constexpr std::uint32_t kMostVersion = 199;
constexpr std::uint32_t kMostEntries = 1000;
// The record of the camera, whose first two bytes are the number 2, and in it the time: s since
// 1970 UTC, and ms in 16 bits.
constexpr std::uint32_t kCameraRecord = 0x20;
constexpr std::size_t kTimeAt = 0x384;
constexpr std::uint32_t kSixteenBits = 0xffff;
constexpr std::size_t kBlock = 65536;  // bytes read at once in the search for a header

using Header = std::array<char, kHeaderSize>;

class Frames {
 public:
  explicit Frames(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
    stream_.seekg(0, std::ios::end);
    size_ = stream_ ? static_cast<std::uint64_t>(stream_.tellg()) : 0;
  }

  std::vector<FrameExtent> all() {
    std::vector<FrameExtent> frames;
    std::optional<std::uint64_t> at =
        end_of_frame(0) ? std::optional<std::uint64_t>(0) : std::nullopt;
    while (at) {
      const std::uint64_t end = *end_of_frame(*at);
      const std::optional<double> taken = taken_;
      const auto next = next_frame(end);
      frames.push_back({*at, next.value_or(size_) - *at, taken});
      at = next;
    }
    return frames;
  }

 private:
  template <std::size_t Size>
  bool read(std::uint64_t at, std::array<char, Size>& bytes) {
    if (at + Size > size_) {
      return false;
    }
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    return static_cast<bool>(stream_.read(bytes.data(), Size));
  }

  template <std::size_t Size>
  static std::uint32_t number(const std::array<char, Size>& bytes, std::size_t at, bool swapped) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto byte = static_cast<unsigned char>(bytes.at(at + (swapped ? 3 - i : i)));
      value |= std::uint32_t{byte} << (8 * i);
    }
    return value;
  }

  /// Where the frame that begins at `at` ends; nothing where none begins.
  std::optional<std::uint64_t> end_of_frame(std::uint64_t at) {
    Header header{};
    if (!read(at, header) ||
        std::string_view(header.data() + 1, 3) != std::string_view("FF\0", 3) ||
        (header[0] != 'F' && header[0] != 'A')) {
      return std::nullopt;
    }
    const auto is_version = [](std::uint32_t v) { return v >= kLeastVersion && v <= kMostVersion; };
    const bool swapped = !is_version(number(header, kVersionAt, false));
    if (swapped && !is_version(number(header, kVersionAt, true))) {
      return std::nullopt;
    }
    const std::uint64_t directory = at + number(header, kDirectoryAt, swapped);
    const std::uint32_t entries = number(header, kEntriesAt, swapped);
    if (entries > kMostEntries) {
      return std::nullopt;
    }
    taken_.reset();
    std::uint64_t end = std::max(at + kHeaderSize, directory + std::uint64_t{entries} * kEntrySize);
    for (std::uint32_t i = 0; i < entries; ++i) {
      std::array<char, kEntrySize> entry{};
      if (!read(directory + std::uint64_t{i} * kEntrySize, entry)) {
        break;  // cut short: what is there is the frame
      }
      const std::uint64_t record = at + number(entry, kRecordAt, swapped);
      const std::uint32_t type = number(entry, 0, swapped);
      if ((swapped ? type >> 16U : type & kSixteenBits) == kCameraRecord) {
        taken_ = time_in(record);
      }
      end = std::max(end, record + number(entry, kRecordSizeAt, swapped));
    }
    return std::min(end, size_);
  }

  /// Of the record of the camera; nothing where its clock was not set.
  std::optional<double> time_in(std::uint64_t record) {
    std::array<char, 2> two{};
    std::array<char, 8> time{};
    if (!read(record, two) || !read(record + kTimeAt, time)) {
      return std::nullopt;
    }
    const bool swapped = two[0] == 0;
    const std::uint32_t fraction = number(time, 4, swapped) & kSixteenBits;
    const double taken = number(time, 0, swapped) + 1e-3 * fraction;
    return is_plausible_time(taken) ? std::optional(taken) : std::nullopt;
  }

  /// The first frame at `from` or behind it.
  std::optional<std::uint64_t> next_frame(std::uint64_t from) {
    std::array<char, kBlock> block{};
    while (from + kHeaderSize <= size_) {
      const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, size_ - from));
      stream_.clear();
      stream_.seekg(static_cast<std::streamoff>(from));
      if (!stream_.read(block.data(), static_cast<std::streamsize>(size))) {
        return std::nullopt;
      }
      const std::string_view bytes(block.data(), size);
      for (std::size_t k = bytes.find("FF"); k != std::string_view::npos;
           k = bytes.find("FF", k + 1)) {
        // "FFF" is found at its first letter, "AFF" at its second.
        for (const std::uint64_t at : {from + k, from + k - 1}) {
          if (at >= from && end_of_frame(at)) {
            return at;
          }
        }
      }
      from += size < kBlock ? size : size - kHeaderSize;
    }
    return std::nullopt;
  }

  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::optional<double> taken_;  // of the frame that was looked at last
};

}  // namespace

std::vector<FrameExtent> fff_frames(const std::filesystem::path& file) {
  return Frames(file).all();
}

}  // namespace pipescout
