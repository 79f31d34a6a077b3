// SPDX-License-Identifier: Apache-2.0
#include "tiff_missing.hpp"

#include <charconv>
#include <cstddef>
#include <limits>
#include <string_view>

namespace pipescout {
namespace {

// TIFF 6.0, section 2: the header has the order of bytes, 42 and the offset of the first directory,
// which is a count of entries and these: tag, type, number of values, and the values or, where they
// take more than four bytes, their offset.
constexpr std::size_t kDirectoryAt = 4;
constexpr std::size_t kEntrySize = 12;
constexpr std::size_t kTypeAt = 2;
constexpr std::size_t kCountAt = 4;
constexpr std::size_t kValueAt = 8;
constexpr std::size_t kInline = 4;
constexpr std::uint32_t kText = 2;
constexpr std::uint32_t kGdalNoData = 42113;

class Tiff {
 public:
  explicit Tiff(std::span<const std::uint8_t> bytes)
      : bytes_(bytes), big_endian_(!bytes.empty() && bytes[0] == 'M') {}

  /// Zero beyond the end.
  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) {
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      value = (value << 8U) | bytes_[at + (big_endian_ ? i : size - 1 - i)];
    }
    return value;
  }
  [[nodiscard]] std::string_view text(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) {
      return {};
    }
    return {reinterpret_cast<const char*>(bytes_.data()) + at, size};
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool big_endian_;
};

std::string_view without_blanks(std::string_view text) {
  text = text.substr(0, text.find('\0'));
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string_view::npos
             ? std::string_view()
             : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

std::optional<double> tiff_missing_value(std::span<const std::uint8_t> tiff) {
  const Tiff file(tiff);
  const std::size_t directory = file.number(kDirectoryAt, 4);
  const std::uint32_t entries = file.number(directory, 2);
  for (std::uint32_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + i * kEntrySize;
    if (file.number(entry, 2) != kGdalNoData || file.number(entry + kTypeAt, 2) != kText) {
      continue;
    }
    const std::size_t size = file.number(entry + kCountAt, 4);
    const std::size_t at =
        size <= kInline ? entry + kValueAt : std::size_t{file.number(entry + kValueAt, 4)};
    std::string_view text = without_blanks(file.text(at, size));
    if (text == "nan" || text == "NaN") {
      return std::numeric_limits<double>::quiet_NaN();
    }
    text.remove_prefix(text.starts_with('+') ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && end == text.data() + text.size()) {
      return value;
    }
  }
  return std::nullopt;
}

}  // namespace pipescout
