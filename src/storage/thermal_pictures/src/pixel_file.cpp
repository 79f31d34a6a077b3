// SPDX-License-Identifier: Apache-2.0
#include "pixel_file.hpp"

#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {
namespace {

template <class Pixel>
Pixels<Pixel> copy(const cv::Mat& image) {
  Pixels<Pixel> pixels{image.cols, image.rows, {}};
  pixels.values.reserve(image.total());
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<Pixel>(y);
    pixels.values.insert(pixels.values.end(), row, row + image.cols);
  }
  return pixels;
}

/// Grey levels that were saved as colours: the first channel; else the image as it is.
cv::Mat without_equal_channels(const cv::Mat& image) {
  if (image.type() != CV_8UC3) {
    return image;
  }
  std::array<cv::Mat, 3> channels;
  cv::split(image, channels.data());
  const bool is_grey = cv::norm(channels[0], channels[1], cv::NORM_INF) == 0 &&
                       cv::norm(channels[0], channels[2], cv::NORM_INF) == 0;
  return is_grey ? channels[0] : image;
}

constexpr int kUncompressed = 1;  // TIFF's own number for it

template <class Pixel>
std::string encoded(const thermal::ImageView<Pixel>& view) {
  if (!view.valid()) {
    throw std::invalid_argument("an image without pixels, or with overlapping rows");
  }
  // OpenCV wants a matrix that it may write to, and does not.
  const cv::Mat image(view.height, view.width, cv::DataType<Pixel>::type,
                      const_cast<Pixel*>(view.data),
                      static_cast<std::size_t>(view.stride) * sizeof(Pixel));
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".tiff", image, bytes, {cv::IMWRITE_TIFF_COMPRESSION, kUncompressed})) {
    throw std::runtime_error("OpenCV cannot write the TIFF");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::string to_tiff(const ThermalView& picture) {
  return std::visit([](const auto& view) { return encoded(view); }, picture);
}

AnyPixels decode_pixels(std::span<const std::uint8_t> bytes) {
  cv::Mat image;
  if (bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    // OpenCV wants a matrix that it may write to, and does not.
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<std::uint8_t*>(bytes.data()));
    try {
      image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
      image.release();
    }
  }
  if (image.empty()) {
    throw PixelError("cannot be decoded: truncated, or not an image");
  }
  image = without_equal_channels(image);
  if (image.channels() != 1) {
    throw ColourError("is a colour image (false colours, or a photograph) of " +
                      std::to_string(image.channels()) +
                      " channels: no temperatures can be read from its colours");
  }
  switch (image.depth()) {
    case CV_8U:
      return copy<std::uint8_t>(image);
    case CV_16U:
      return copy<std::uint16_t>(image);
    case CV_32F:
      return copy<float>(image);
    default:
      throw PixelError("has pixels that are neither unsigned 8 or 16 bits nor 32-bit floats");
  }
}

}  // namespace pipescout
