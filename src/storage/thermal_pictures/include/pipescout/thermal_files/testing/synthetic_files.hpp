// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

/// Files as cameras and geographic software write them, byte by byte.
namespace pipescout::test {

/// A directory of a little-endian TIFF (also EXIF's form) with texts, numbers and data.
class TiffBuilder {
 public:
  TiffBuilder() : bytes_("II*\0", 4) { put(std::uint32_t{0}); }

  /// Adds data outside of directories; its offset.
  std::uint32_t data(const std::string& data) {
    bytes_.resize(bytes_.size() + bytes_.size() % 2);
    const auto at = static_cast<std::uint32_t>(bytes_.size());
    bytes_ += data;
    return at;
  }
  void number(std::uint16_t tag, std::uint32_t value) { entries_.push_back({tag, 4, 1, value}); }
  void text(std::uint16_t tag, std::string text) {
    text.push_back('\0');
    const auto size = static_cast<std::uint32_t>(text.size());
    if (size <= 4) {
      std::uint32_t inside = 0;
      std::memcpy(&inside, text.data(), size);
      entries_.push_back({tag, 2, size, inside});
    } else {
      entries_.push_back({tag, 2, size, data(text)});
    }
  }
  /// Writes the entries, in the order of their tags, as a directory; its offset.
  std::uint32_t directory() {
    bytes_.resize(bytes_.size() + bytes_.size() % 2);
    const auto at = static_cast<std::uint32_t>(bytes_.size());
    put(static_cast<std::uint16_t>(entries_.size()));
    for (const Entry& entry : entries_) {
      put(entry.tag);
      put(entry.type);
      put(entry.count);
      put(entry.value);
    }
    put(std::uint32_t{0});
    entries_.clear();
    return at;
  }
  /// With this directory as the first.
  std::string file(std::uint32_t first) const {
    std::string file = bytes_;
    std::memcpy(&file[4], &first, sizeof(first));
    return file;
  }

 private:
  struct Entry {
    std::uint16_t tag;
    std::uint16_t type;
    std::uint32_t count;
    std::uint32_t value;
  };
  template <class T>
  void put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  std::string bytes_;
  std::vector<Entry> entries_;
};

/// An image of one strip; `missing`: of the tag GDAL_NODATA, empty for none.
template <class Pixel>
std::string tiff_with_missing(const std::vector<Pixel>& pixels, std::uint32_t width,
                              const std::string& missing) {
  constexpr bool kFloat = std::is_floating_point_v<Pixel>;
  const auto size = static_cast<std::uint32_t>(pixels.size() * sizeof(Pixel));
  const auto height = static_cast<std::uint32_t>(pixels.size()) / width;
  TiffBuilder tiff;
  const auto strip =
      tiff.data(std::string(reinterpret_cast<const char*>(pixels.data()), std::size_t{size}));
  tiff.number(256, width);
  tiff.number(257, height);
  tiff.number(258, 8 * sizeof(Pixel));
  tiff.number(259, 1);  // not compressed
  tiff.number(262, 1);  // black is zero
  tiff.number(273, strip);
  tiff.number(277, 1);
  tiff.number(278, height);
  tiff.number(279, size);
  tiff.number(339, kFloat ? 3 : 1);
  if (!missing.empty()) {
    tiff.text(42113, missing);
  }
  return tiff.file(tiff.directory());
}

/// APP1.
inline std::string jpeg_segment(const std::string& content) {
  const std::size_t size = content.size() + 2;
  return std::string{'\xff', '\xe1', static_cast<char>(size >> 8U), static_cast<char>(size)} +
         content;
}

/// A JPEG file with the maker of a camera in EXIF.
inline std::string jpeg_made_by(const std::string& jpeg, const std::string& maker) {
  TiffBuilder exif;
  exif.text(0x010f, maker);
  return jpeg.substr(0, 2) +
         jpeg_segment(std::string("Exif\0\0", 6) + exif.file(exif.directory())) + jpeg.substr(2);
}

/// A JPEG file with a block of FLIR's and the time of EXIF, each left out where it is empty.
inline std::string jpeg_with(const std::string& jpeg, const std::string& flir,
                             const std::string& exif_time) {
  std::string file = jpeg.substr(0, 2);
  if (!exif_time.empty()) {
    TiffBuilder exif;
    exif.text(0x9003, exif_time);
    const auto inner = exif.directory();
    exif.number(0x8769, inner);
    file += jpeg_segment(std::string("Exif\0\0", 6) + exif.file(exif.directory()));
  }
  if (!flir.empty()) {
    file += jpeg_segment(std::string("FLIR\0\1\0\0", 8) + flir);
  }
  return file + jpeg.substr(2);
}

}  // namespace pipescout::test
