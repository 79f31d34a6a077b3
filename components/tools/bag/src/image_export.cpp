// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstring>
#include <iomanip>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "pipescout/command_line/command.hpp"
#include "topic_export.hpp"

namespace pipescout::bag_command {
namespace {

using command_line::CommandError;

struct Encoding {
  int type = 0;                   ///< of OpenCV
  std::optional<int> conversion;  ///< to what OpenCV writes
};

const Encoding* encoding_of(const std::string& name) {
  // OpenCV names Bayer patterns by the second row and column.
  static const std::unordered_map<std::string, Encoding> kEncodings{
      {"mono8", {CV_8UC1, {}}},
      {"8UC1", {CV_8UC1, {}}},
      {"mono16", {CV_16UC1, {}}},
      {"16UC1", {CV_16UC1, {}}},
      {"32FC1", {CV_32FC1, {}}},
      {"bgr8", {CV_8UC3, {}}},
      {"8UC3", {CV_8UC3, {}}},
      {"rgb8", {CV_8UC3, cv::COLOR_RGB2BGR}},
      {"bgra8", {CV_8UC4, {}}},
      {"rgba8", {CV_8UC4, cv::COLOR_RGBA2BGRA}},
      {"bayer_rggb8", {CV_8UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr8", {CV_8UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg8", {CV_8UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg8", {CV_8UC1, cv::COLOR_BayerGB2BGR}},
      {"bayer_rggb16", {CV_16UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr16", {CV_16UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg16", {CV_16UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg16", {CV_16UC1, cv::COLOR_BayerGB2BGR}}};
  const auto found = kEncodings.find(name);
  return found == kEncodings.end() ? nullptr : &found->second;
}

/// The pixels with the bytes of each value in this machine's order.
cv::Mat pixels_of(const sensor_msgs::msg::Image& image, const Encoding& encoding) {
  const std::size_t row_size = image.width * CV_ELEM_SIZE(encoding.type);
  constexpr std::uint32_t kLargestSide = 65535;
  if (image.width == 0 || image.height == 0 || image.width > kLargestSide ||
      image.height > kLargestSide || image.step < row_size ||
      image.data.size() < std::size_t{image.step} * image.height) {
    throw CommandError("an image of " + std::to_string(image.width) + "x" +
                       std::to_string(image.height) + ", " + image.encoding + ", step " +
                       std::to_string(image.step) + ", has " + std::to_string(image.data.size()) +
                       " bytes");
  }
  cv::Mat pixels(static_cast<int>(image.height), static_cast<int>(image.width), encoding.type);
  for (int row = 0; row < pixels.rows; ++row) {
    std::memcpy(pixels.ptr(row), image.data.data() + static_cast<std::size_t>(row) * image.step,
                row_size);
  }
  const auto size = static_cast<std::size_t>(CV_ELEM_SIZE1(encoding.type));
  const bool is_big = std::endian::native == std::endian::big;
  if (size > 1 && (image.is_bigendian != 0) != is_big) {
    for (std::uint8_t* value = pixels.data; value < pixels.dataend; value += size) {
      std::reverse(value, value + size);
    }
  }
  return pixels;
}

template <class Header>
std::string name_of(std::uint64_t count, const Header& header) {
  std::ostringstream out;
  out << std::setfill('0') << std::setw(6) << count << '_' << header.stamp.sec << '.'
      << std::setw(9) << header.stamp.nanosec;
  return out.str();
}

}  // namespace

ImageExport::ImageExport(std::filesystem::path folder, std::string ending)
    : folder_(std::move(folder)), ending_(std::move(ending)) {
  std::filesystem::create_directories(folder_);
}

bool ImageExport::takes(std::string_view type) {
  return type == "sensor_msgs/msg/Image" || type == "sensor_msgs/msg/CompressedImage";
}

void ImageExport::write(MessageView message) {
  if (message.type->name == "sensor_msgs/msg/CompressedImage") {
    const auto& image = *static_cast<const sensor_msgs::msg::CompressedImage*>(message.message);
    const bool is_png = image.format.find("png") != std::string::npos;
    const auto path = folder_ / (name_of(count_, image.header) + (is_png ? ".png" : ".jpg"));
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(image.data.data()),
               static_cast<std::streamsize>(image.data.size()));
    if (!file) {
      throw CommandError(path.string() + ": cannot be written");
    }
    ++count_;
    return;
  }
  const auto& image = *static_cast<const sensor_msgs::msg::Image*>(message.message);
  const Encoding* encoding = encoding_of(image.encoding);
  if (encoding == nullptr) {
    throw CommandError("images of the encoding '" + image.encoding + "' cannot be exported");
  }
  cv::Mat pixels = pixels_of(image, *encoding);
  if (encoding->conversion) {
    cv::Mat converted;
    cv::cvtColor(pixels, converted, *encoding->conversion);
    pixels = converted;
  }
  const std::string ending = encoding->type == CV_32FC1 ? "tiff" : ending_;
  const auto path = folder_ / (name_of(count_, image.header) + "." + ending);
  if (!cv::imwrite(path.string(), pixels)) {
    throw CommandError(path.string() + ": cannot be written");
  }
  ++count_;
}

}  // namespace pipescout::bag_command
