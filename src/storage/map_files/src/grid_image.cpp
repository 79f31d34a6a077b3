// SPDX-License-Identifier: Apache-2.0
#include "grid_image.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "pipescout/map_files/grid_file.hpp"

namespace pipescout {
namespace {

constexpr std::uint32_t kWhite = 255;
constexpr std::uint32_t kSavedUnknown = 205;  // of map_saver

/// OpenCV neither scales the binary form by its largest value nor says where a file is cut.
class PgmReader {
 public:
  PgmReader(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {}

  GridImage read() {
    constexpr int kLargestSide = 100'000;
    constexpr std::size_t kMostPixels = 1'000'000'000;
    const std::string_view magic = text_.substr(0, 2);
    at_ = 2;
    GridImage image;
    image.white = kWhite;
    image.saved_unknown = kSavedUnknown;
    image.width = number("width", 1, kLargestSide);
    image.height = number("height", 1, kLargestSide);
    const int white = number("largest value", 1, static_cast<int>(kWhite));
    const auto count =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (count > kMostPixels) {
      fail("it has more than 1e9 pixels");
    }
    ++at_;  // one white space
    if (magic == "P5" && text_.size() < at_ + count) {
      fail("it is truncated: " + std::to_string(count) + " pixels expected, " +
           std::to_string(text_.size() - std::min(at_, text_.size())) + " found");
    }
    image.shades.reserve(std::min(count, text_.size()));
    for (std::size_t i = 0; i < count; ++i) {
      const int value =
          magic == "P5" ? static_cast<std::uint8_t>(text_[at_ + i]) : number("pixel", 0, white);
      if (value > white) {
        fail("pixel " + std::to_string(i) + " is " + std::to_string(value) + ", above " +
             std::to_string(white));
      }
      image.shades.push_back(
          static_cast<std::uint32_t>(std::lround(value * double{kWhite} / white)));
    }
    return image;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw MapFileError(path_ + ": " + message);
  }

  int number(const std::string& what, int low, int high) {
    while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '#')) {
      at_ = text_[at_] == '#' ? std::min(text_.find('\n', at_), text_.size()) : at_ + 1;
    }
    int value = 0;
    const char* end = text_.data() + text_.size();
    const auto [stop, error] =
        std::from_chars(text_.data() + std::min(at_, text_.size()), end, value);
    if (error != std::errc() || value < low || value > high) {
      fail(what + " is missing or outside [" + std::to_string(low) + ", " + std::to_string(high) +
           "]");
    }
    at_ = static_cast<std::size_t>(stop - text_.data());
    return value;
  }

  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0;
};

/// Mean of the colours, and of alpha where it counts, times their number.
template <typename Channel>
void append_shades(const cv::Mat& pixels, AlphaUse alpha, GridImage& image) {
  const int channels = pixels.channels();
  const bool has_alpha = channels == 4;
  const int counted = has_alpha && alpha == AlphaUse::kSeparate ? 3 : channels;
  constexpr std::uint32_t kLargest = std::numeric_limits<Channel>::max();
  const auto colours = static_cast<std::uint32_t>(has_alpha ? 3 : channels);
  image.white = kLargest * static_cast<std::uint32_t>(counted);
  image.saved_unknown = kSavedUnknown * (kLargest / kWhite) * colours +
                        kLargest * (static_cast<std::uint32_t>(counted) - colours);
  image.shades.reserve(pixels.total());
  for (int row = 0; row < pixels.rows; ++row) {
    const auto* values = pixels.ptr<Channel>(row);
    for (int column = 0; column < pixels.cols; ++column, values += channels) {
      std::uint32_t sum = 0;
      for (int channel = 0; channel < counted; ++channel) {
        sum += values[channel];
      }
      image.shades.push_back(sum);
      if (has_alpha) {
        image.transparent.push_back(values[3] != kLargest);
      }
    }
  }
}

}  // namespace

GridImage decode_grid_image(const std::string& content, const std::filesystem::path& path,
                            AlphaUse alpha) {
  if (content.starts_with("P5") || content.starts_with("P2")) {
    return PgmReader(content, path.string()).read();
  }
  cv::Mat pixels;
  try {
    const std::vector<std::uint8_t> bytes(content.begin(), content.end());
    pixels = bytes.empty() ? cv::Mat() : cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw MapFileError(path.string() + ": " + error.what());
  }
  if (pixels.empty()) {
    throw MapFileError(path.string() + ": it is no image that can be read (PGM, PNG, BMP), or it " +
                       "is cut");
  }
  GridImage image;
  image.width = pixels.cols;
  image.height = pixels.rows;
  const int channels = pixels.channels();
  if ((pixels.depth() != CV_8U && pixels.depth() != CV_16U) ||
      (channels != 1 && channels != 3 && channels != 4)) {
    throw MapFileError(path.string() +
                       ": its pixels are neither grey nor colours, or have neither 8 nor 16 bits");
  }
  if (pixels.depth() == CV_8U) {
    append_shades<std::uint8_t>(pixels, alpha, image);
  } else {
    append_shades<std::uint16_t>(pixels, alpha, image);
  }
  return image;
}

}  // namespace pipescout
