// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/temperature_export.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

namespace pipescout {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} * 1024 * 1024;

/// What is not gzipped is passed through as it is.
std::string unzipped(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(::gzopen(file.c_str(), "rb"), ::gzclose);
  if (!stream) {
    throw ThermalFileError(file.string() + ": cannot be opened");
  }
  std::string text;
  std::array<char, 65536> block{};
  while (true) {
    const int size = ::gzread(stream.get(), block.data(), block.size());
    if (size < 0) {
      throw ThermalFileError(file.string() + ": cannot be read, or is truncated");
    }
    if (size == 0) {
      break;
    }
    text.append(block.data(), static_cast<std::size_t>(size));
    if (text.size() > kMostBytes) {
      throw ThermalFileError(file.string() + ": is larger than 256 MiB");
    }
  }
  // zlib tells of a stream that has no end when it is asked, not by what it has read.
  int error = Z_OK;
  (void)::gzerror(stream.get(), &error);
  if (error != Z_OK) {
    throw ThermalFileError(file.string() + ": is truncated");
  }
  return text;
}

bool separates(char c) {
  return c == ',' || c == '\n' || c == '\r' || c == ' ' || c == '\t';
}

}  // namespace

std::vector<float> read_temperature_export(const std::filesystem::path& file) {
  const std::string text = unzipped(file);
  const char* const end = text.data() + text.size();
  std::vector<float> degrees;
  for (const char* at = text.data(); at != end;) {
    if (separates(*at)) {
      ++at;
      continue;
    }
    float value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || (next != end && !separates(*next))) {
      throw ThermalFileError(file.string() + ": value " + std::to_string(degrees.size() + 1) +
                             " is not a number");
    }
    degrees.push_back(value);
    at = next;
  }
  return degrees;
}

TemperatureError temperature_error(const ThermalPicture& picture, std::span<const float> degrees) {
  if (degrees.size() != picture.degrees.size()) {
    throw std::invalid_argument("degrees: " + std::to_string(degrees.size()) +
                                " temperatures for " + std::to_string(picture.degrees.size()) +
                                " pixels");
  }
  double sum = 0;
  TemperatureError result;
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    const double ours = picture.degrees[i];
    const double theirs = degrees[i];
    const double error = std::isfinite(ours) && std::isfinite(theirs) ? std::abs(ours - theirs)
                         : std::isfinite(ours) == std::isfinite(theirs)
                             ? 0
                             : std::numeric_limits<double>::infinity();
    sum += error;
    result.max_abs = std::max(result.max_abs, error);
  }
  result.mean_abs = degrees.empty() ? 0 : sum / static_cast<double>(degrees.size());
  return result;
}

}  // namespace pipescout
