// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/thermal_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "colour_advice.hpp"
#include "exiftool.hpp"
#include "fff_frames.hpp"
#include "flir_file.hpp"
#include "picture_time.hpp"
#include "pipescout/thermal/parameter_doubts.hpp"
#include "pixel_file.hpp"
#include "scene_check.hpp"
#include "tiff_missing.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = 1U << 30U;
// The tag with the value of missing pixels is text of 7 digits or more, as much as a float has.
constexpr double kDigitsOfMissing = 1e-6;
constexpr std::size_t kFilesAtOnce = 200;  // open in one run of exiftool

/// What a file begins with.
enum class Container : std::uint8_t { kPng, kTiff, kJpeg, kFff, kOther };

Container container_of(std::span<const std::uint8_t> bytes) {
  const auto begins = [bytes](std::initializer_list<std::uint8_t> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
  };
  if (begins({0x89, 'P', 'N', 'G'})) {
    return Container::kPng;
  }
  if (begins({'I', 'I', 42, 0}) || begins({'M', 'M', 0, 42})) {
    return Container::kTiff;
  }
  if (begins({0xff, 0xd8, 0xff})) {
    return Container::kJpeg;
  }
  if (begins({'F', 'F', 'F', 0}) || begins({'A', 'F', 'F', 0})) {
    return Container::kFff;
  }
  return Container::kOther;
}

std::vector<std::uint8_t> bytes_of(const fs::path& file, std::optional<FrameExtent> frame) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    throw ThermalFileError(error ? error.message() : "is not a file");
  }
  const auto size = frame ? frame->size : fs::file_size(file, error);
  if (error) {
    throw ThermalFileError(error.message());
  }
  if (size == 0) {
    throw ThermalFileError("is empty");
  }
  if (size > kMostBytes) {
    throw ThermalFileError("has more than 1 GiB");
  }
  std::vector<std::uint8_t> bytes(size);
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(frame ? frame->offset : 0));
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw ThermalFileError("cannot be read");
  }
  return bytes;
}

/// Counts to temperatures, in all regions.
void convert(const thermal::CameraConstants& camera, const thermal::ObjectParameters& object,
             thermal::CountRange range, const ThermalSettings& settings, ThermalPicture& picture) {
  for (const thermal::Doubt& doubt : thermal::doubts(camera, object)) {
    picture.doubts.push_back(to_string(doubt));
  }
  std::vector<thermal::Region> regions;
  for (const RegionChanges& region : settings.regions) {
    regions.push_back(
        {region.x, region.y, region.width, region.height, region.object.apply(object)});
  }
  const thermal::RegionTables tables(camera, object, regions, range);
  picture.radiometry.emplace(camera, object);
  const thermal::CountView view{picture.counts.data(), picture.width, picture.height,
                                picture.width};
  picture.degrees.resize(picture.counts.size());
  picture.count = tables.convert(view, picture.degrees);
}

ThermalPicture from_flir(FlirContent content, const ThermalSettings& settings) {
  ThermalPicture picture;
  picture.kind = ThermalFileKind::kFlir;
  picture.width = content.counts.width;
  picture.height = content.counts.height;
  picture.counts = std::move(content.counts.values);
  picture.taken = content.taken;
  picture.place = content.place;
  picture.camera = std::move(content.camera_name);
  picture.lens = std::move(content.lens);
  picture.doubts = std::move(content.doubts);
  content.camera.path = settings.air_path;
  convert(content.camera, settings.object.apply(content.object),
          settings.range.value_or(content.range), settings, picture);
  return picture;
}

ThermalPicture from_counts(Pixels<std::uint16_t> pixels, const ThermalSettings& settings) {
  ThermalPicture picture;
  picture.kind = ThermalFileKind::kCounts16;
  picture.width = pixels.width;
  picture.height = pixels.height;
  picture.counts = std::move(pixels.values);
  const thermal::CountRange range = settings.range.value_or(thermal::CountRange{});
  if (settings.planck) {
    convert({.planck = *settings.planck, .path = settings.air_path}, settings.object.apply({}),
            range, settings, picture);
  } else if (settings.scale) {
    picture.degrees.resize(picture.counts.size());
    picture.count = thermal::TemperatureTable(settings.scale->gain, settings.scale->offset, range)
                        .convert(picture.counts, picture.degrees);
  } else {
    throw ThermalFileError(
        "contains 16-bit counts: the settings must convert them, by scale or planck");
  }
  return picture;
}

ThermalPicture from_grey(const Pixels<std::uint8_t>& pixels, const ThermalSettings& settings) {
  if (!settings.grey && !settings.automatic_gain) {
    throw ThermalFileError("contains 8-bit grey levels: the settings must convert them, by grey");
  }
  ThermalPicture picture;
  picture.kind = ThermalFileKind::kGrey8;
  picture.width = pixels.width;
  picture.height = pixels.height;
  picture.counts.assign(pixels.values.begin(), pixels.values.end());
  picture.degrees.resize(picture.counts.size());
  picture.levels = !settings.grey;
  const GreyScale scale = settings.grey.value_or(GreyScale{0, thermal::kGreyLevels});
  picture.count = thermal::TemperatureTable::of_grey(scale.black, scale.white)
                      .convert(picture.counts, picture.degrees);
  return picture;
}

ThermalPicture from_temperatures(Pixels<float> pixels, const ThermalSettings& settings) {
  ThermalPicture picture;
  picture.kind = ThermalFileKind::kTemperature32;
  picture.width = pixels.width;
  picture.height = pixels.height;
  picture.degrees = std::move(pixels.values);
  picture.count.pixels = picture.degrees.size();
  const bool kelvin = settings.float_unit == TemperatureUnit::kKelvin;
  const auto zero = static_cast<float>(thermal::kZeroCelsius);
  for (float& degree : picture.degrees) {
    degree = kelvin ? degree - zero : degree;
    if (!(degree > -zero && degree < thermal::kHottestBody)) {
      degree = std::numeric_limits<float>::quiet_NaN();
      ++picture.count.without_temperature;
    }
  }
  return picture;
}

ThermalPicture from_pixels(AnyPixels pixels, const ThermalSettings& settings) {
  if (auto* counts = std::get_if<Pixels<std::uint16_t>>(&pixels)) {
    return from_counts(std::move(*counts), settings);
  }
  if (auto* degrees = std::get_if<Pixels<float>>(&pixels)) {
    return from_temperatures(std::move(*degrees), settings);
  }
  return from_grey(std::get<Pixels<std::uint8_t>>(pixels), settings);
}

/// Indices of the pixels with this value.
std::vector<std::size_t> pixels_with(std::optional<double> value, const AnyPixels& pixels) {
  std::vector<std::size_t> found;
  if (!value) {
    return found;
  }
  std::visit(
      [&](const auto& image) {
        for (std::size_t i = 0; i < image.values.size(); ++i) {
          if (std::abs(static_cast<double>(image.values[i]) - *value) <=
              kDigitsOfMissing * std::abs(*value)) {
            found.push_back(i);
          }
        }
      },
      pixels);
  return found;
}

void remove(const std::vector<std::size_t>& missing, ThermalPicture& picture) {
  for (const std::size_t i : missing) {
    if (!std::isnan(picture.degrees[i])) {
      picture.degrees[i] = std::numeric_limits<float>::quiet_NaN();
      ++picture.count.without_temperature;
    }
  }
}

AnyPixels decoded(const std::vector<std::uint8_t>& bytes, const std::string& exiftool) {
  try {
    return decode_pixels(bytes);
  } catch (const ColourError& error) {
    throw ThermalFileError(error.what(), colour_advice(exiftool, bytes));
  }
}

ThermalPicture read_unnamed(const fs::path& file, std::optional<FrameExtent> frame,
                            const ThermalSettings& settings, const std::string& exiftool) {
  const std::vector<std::uint8_t> bytes = bytes_of(file, frame);
  const Container container = container_of(bytes);
  if (container == Container::kOther) {
    throw ThermalFileError("is neither PNG, TIFF, JPEG nor FLIR's FFF");
  }
  if (container == Container::kPng || container == Container::kTiff) {
    AnyPixels pixels = decoded(bytes, exiftool);
    const std::vector<std::size_t> missing = container == Container::kTiff
                                                 ? pixels_with(tiff_missing_value(bytes), pixels)
                                                 : std::vector<std::size_t>();
    ThermalPicture picture = from_pixels(std::move(pixels), settings);
    require_scene(picture, missing, settings);
    remove(missing, picture);
    picture.unit_doubt = unit_doubt(picture, settings);
    return picture;
  }
  std::string complaint;
  auto flir = flir_content(exiftool_json(exiftool, flir_tags(), bytes), complaint);
  if (flir) {
    if (!flir->taken) {
      // Asked only now: EXIF has the same name for it, and few cameras have no clock.
      PictureTime time = picture_times(exiftool_json(exiftool, time_tags(), bytes), 1).front();
      flir->taken = time.taken;
      std::move(time.doubts.begin(), time.doubts.end(), std::back_inserter(flir->doubts));
    }
    return from_flir(std::move(*flir), settings);
  }
  const bool grey_has_meaning = settings.grey || settings.automatic_gain;
  if (container == Container::kJpeg && (complaint.empty() || grey_has_meaning)) {
    AnyPixels pixels = decoded(bytes, exiftool);
    if (grey_has_meaning) {
      return from_pixels(std::move(pixels), settings);
    }
  }
  throw ThermalFileError("has no thermal block" +
                         (complaint.empty() ? "" : " (exiftool: " + complaint + ")"));
}

}  // namespace

std::string_view to_string(ThermalFileKind kind) noexcept {
  switch (kind) {
    case ThermalFileKind::kFlir:
      return "flir";
    case ThermalFileKind::kCounts16:
      return "counts16";
    case ThermalFileKind::kTemperature32:
      return "temperature32";
    case ThermalFileKind::kGrey8:
      return "grey8";
  }
  return "unknown";
}

ThermalFileReader::ThermalFileReader(ThermalSettings settings, std::string exiftool)
    : settings_(std::move(settings)), exiftool_(std::move(exiftool)) {}

ThermalPicture ThermalFileReader::read(const fs::path& file) {
  try {
    return read_unnamed(file, std::nullopt, settings_, exiftool_);
  } catch (const ThermalFileError& error) {
    throw ThermalFileError(file.string() + ": " + error.what(), error.advice());
  } catch (const std::exception& error) {
    throw ThermalFileError(file.string() + ": " + error.what());
  }
}

ThermalPicture ThermalFileReader::read(const fs::path& file, const std::vector<FrameExtent>& frames,
                                       std::size_t index) {
  if (frames.size() == 1) {
    return read(file);
  }
  try {
    return read_unnamed(file, frames.at(index), settings_, exiftool_);
  } catch (const ThermalFileError& error) {
    throw ThermalFileError(
        file.string() + ": frame " + std::to_string(index + 1) + ": " + error.what(),
        error.advice());
  } catch (const std::exception& error) {
    throw ThermalFileError(file.string() + ": frame " + std::to_string(index + 1) + ": " +
                           error.what());
  }
}

std::vector<FrameExtent> ThermalFileReader::frames(const fs::path& file) {
  std::error_code error;
  std::vector<FrameExtent> frames;
  if (fs::is_regular_file(file, error)) {
    frames = fff_frames(file);
  }
  if (frames.empty()) {
    const auto size = fs::file_size(file, error);
    frames.push_back({0, error ? 0 : size});
  }
  return frames;
}

std::vector<std::optional<double>> ThermalFileReader::times(std::span<const fs::path> files) const {
  std::vector<std::optional<double>> times;
  while (!files.empty()) {
    const auto some = files.first(std::min(files.size(), kFilesAtOnce));
    files = files.subspan(some.size());
    try {
      for (const PictureTime& time :
           picture_times(exiftool_json(exiftool_, time_tags(), some), some.size())) {
        times.push_back(time.taken);
      }
    } catch (const std::exception& error) {
      throw ThermalFileError(error.what());
    }
  }
  return times;
}

bool has_thermal_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array kExtensions{".jpg", ".jpeg", ".fff", ".seq",
                                   ".csq", ".png",  ".tif", ".tiff"};
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace pipescout
