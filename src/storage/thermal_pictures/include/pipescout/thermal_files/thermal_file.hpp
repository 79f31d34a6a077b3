// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/thermal_files/thermal_settings.hpp"

/// Reading of thermal images from files.
namespace pipescout {

/// A file without a valid thermal image; what() names it and the reason.
class ThermalFileError : public std::runtime_error {
 public:
  explicit ThermalFileError(const std::string& what, std::string advice = {})
      : std::runtime_error(what), advice_(std::move(advice)) {}
  /// What to do about it, the same for all files of its kind: to be told once. Empty: nothing.
  [[nodiscard]] const std::string& advice() const noexcept { return advice_; }

 private:
  std::string advice_;
};

enum class ThermalFileKind : std::uint8_t {
  kFlir,           ///< radiometric JPEG, or FFF
  kCounts16,       ///< PNG or TIFF of 16 bits
  kTemperature32,  ///< TIFF of 32-bit floating-point temperatures
  kGrey8,          ///< any greyscale image of 8 bits
};
/// "flir", "counts16", "temperature32", "grey8"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(ThermalFileKind kind) noexcept;

/// Position in the file's metadata. WGS 84: degrees, metres.
struct GeographicPlace {
  double latitude = 0;
  double longitude = 0;
  std::optional<double> altitude;
};

/// Where an image is in its file, bytes.
struct FrameExtent {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  std::optional<double>
      taken{};  ///< s since 1970 UTC, of frames of FLIR's with a clock that was set
};

struct ThermalPicture {
  ThermalFileKind kind = ThermalFileKind::kFlir;
  int width = 0;
  int height = 0;
  std::vector<float> degrees;  ///< degC, row by row from the upper left; NaN without temperature
  /// `degrees` are grey levels of automatic gain, 0 to 255, and no temperatures.
  bool levels = false;
  thermal::PixelCount count;

  /// Counts of the sensor, as many as `degrees`; empty for temperatures.
  std::vector<std::uint16_t> counts;
  /// Of the image without its regions; nothing without Planck constants.
  std::optional<thermal::Radiometry> radiometry;

  /// s since 1970 UTC. FLIR's files only, and only of a clock that was set: before 2001 it was not.
  std::optional<double> taken;
  std::optional<GeographicPlace> place;
  std::string camera;               ///< model and serial number, readable; empty if unknown
  std::string lens;                 ///< likewise
  std::vector<std::string> doubts;  ///< implausible metadata of the file
  /// Why the temperatures may be in another unit, and what to set then; empty: no doubt.
  std::string unit_doubt;

  [[nodiscard]] thermal::TemperatureView view() const noexcept {
    return {degrees.data(), width, height, width};
  }
};

/// Reads thermal images with common settings. Not thread-safe.
class ThermalFileReader {
 public:
  /// `exiftool`: name or path of the program that parses FLIR's files: Debian's package
  /// libimage-exiftool-perl. It is run without a shell and never gets the name of an image.
  explicit ThermalFileReader(ThermalSettings settings, std::string exiftool = "exiftool");

  /// The format is detected from the content, not from the name. Throws ThermalFileError, naming
  /// the file, for one that is empty, truncated, of another kind, in colour, without thermal block,
  /// without the settings that its kind needs or with parameters out of range, with a scale or unit
  /// that gives most pixels a temperature that no scene has; and when exiftool is missing. The next
  /// file is not affected.
  [[nodiscard]] ThermalPicture read(const std::filesystem::path& file);
  /// One of its `frames`. The message names its number, from 1 on, too.
  [[nodiscard]] ThermalPicture read(const std::filesystem::path& file,
                                    const std::vector<FrameExtent>& frames, std::size_t index);

  /// The images of a file: more than one in a sequence of FLIR's (SEQ, CSQ, or FFF of several). Of
  /// any other file, and of one that cannot be read, one: all of it.
  [[nodiscard]] static std::vector<FrameExtent> frames(const std::filesystem::path& file);

  /// When the images, or the first ones of sequences, were taken, s since 1970 UTC: the time in
  /// FLIR's block where the camera's clock was set, else that in EXIF, which is taken for UTC where
  /// it has no time zone. Files of any kind; nothing for those that do not tell. Much faster than
  /// reading each. Throws ThermalFileError when exiftool is missing or fails.
  [[nodiscard]] std::vector<std::optional<double>> times(
      std::span<const std::filesystem::path> files) const;

  [[nodiscard]] const ThermalSettings& settings() const noexcept { return settings_; }

 private:
  ThermalSettings settings_;
  std::string exiftool_;
};

/// Counts, degC or grey levels of a camera.
using ThermalView = std::variant<thermal::CountView, thermal::TemperatureView, thermal::GreyView>;

/// The content of a TIFF file that `read` restores exactly, with settings for counts and grey
/// levels. Not compressed: 320 x 240 counts take 0.1 ms, a PNG of half the size takes
/// 3. Throws std::invalid_argument for a view that is not valid.
[[nodiscard]] std::string to_tiff(const ThermalView& picture);

/// Whether a file of this name may be a thermal image: .jpg, .jpeg, .fff, .seq, .csq, .png, .tif,
/// .tiff, in any case.
[[nodiscard]] bool has_thermal_extension(const std::filesystem::path& file);

}  // namespace pipescout
