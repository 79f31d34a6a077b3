// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/thermal_files/thermal_settings.hpp"

/// Pictures of thermal cameras from files.
namespace pipescout {

/// A file that gives no thermal picture; what() names it and says why.
class ThermalFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ThermalFileKind : std::uint8_t {
  kFlir,           ///< radiometric JPEG, or FFF
  kCounts16,       ///< PNG or TIFF of 16 bits
  kTemperature32,  ///< TIFF of 32-bit floating-point temperatures
  kGrey8,          ///< any picture of 8 bits and no colour
};
/// "flir", "counts16", "temperature32", "grey8"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(ThermalFileKind kind) noexcept;

/// Where a file says that it was taken. WGS 84: degrees, metres.
struct GeographicPlace {
  double latitude = 0;
  double longitude = 0;
  std::optional<double> altitude;
};

struct ThermalPicture {
  ThermalFileKind kind = ThermalFileKind::kFlir;
  int width = 0;
  int height = 0;
  std::vector<float> degrees;  ///< degC, row by row from the upper left; NaN where there is none
  thermal::PixelCount count;

  /// Counts of the sensor, as many as `degrees`; empty for temperatures.
  std::vector<std::uint16_t> counts;
  /// Of the picture without its regions; nothing where no Planck constants are known.
  std::optional<thermal::Radiometry> radiometry;

  std::optional<double> taken;  ///< s since 1970 UTC
  std::optional<GeographicPlace> place;
  std::string camera;               ///< model and serial number; empty when not told
  std::string lens;                 ///< likewise
  std::vector<std::string> doubts;  ///< what the file says that makes little sense

  [[nodiscard]] thermal::TemperatureView view() const noexcept {
    return {degrees.data(), width, height, width};
  }
};

/// Reads thermal pictures that are taken alike. Not thread-safe.
class ThermalFileReader {
 public:
  /// `exiftool`: name or path of the program that takes FLIR's files apart: Debian's package
  /// libimage-exiftool-perl. It is run without a shell and never sees the name of a picture.
  explicit ThermalFileReader(ThermalSettings settings, std::string exiftool = "exiftool");

  /// The content decides what a file is, not its name. Throws ThermalFileError, naming the file,
  /// for one that is empty, cut short, of another kind, of colour, without thermal block, without
  /// the settings that its kind needs or with parameters out of their range; and where exiftool is
  /// missing. The next file is not affected.
  [[nodiscard]] ThermalPicture read(const std::filesystem::path& file);

  [[nodiscard]] const ThermalSettings& settings() const noexcept { return settings_; }

 private:
  ThermalSettings settings_;
  std::string exiftool_;
};

/// Counts, degC or grey levels of a camera.
using ThermalView = std::variant<thermal::CountView, thermal::TemperatureView, thermal::GreyView>;

/// The content of a TIFF file that `read` takes back bit by bit, with settings that tell what
/// counts and grey levels mean. Not compressed: 320 x 240 counts take 0.1 ms, a PNG of half the
/// size takes
/// 3. Throws std::invalid_argument for a view that is not valid.
[[nodiscard]] std::string to_tiff(const ThermalView& picture);

/// Whether `read` might make something of a file of this name: .jpg, .jpeg, .fff, .png, .tif,
/// .tiff, in any case.
[[nodiscard]] bool has_thermal_extension(const std::filesystem::path& file);

}  // namespace pipescout
