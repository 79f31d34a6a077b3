// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// Counts of special pixels of an image.
struct PixelCount {
  std::size_t pixels = 0;
  std::size_t without_temperature = 0;  ///< NaN
  std::size_t below_range = 0;          ///< at or below the smallest count
  std::size_t above_range = 0;          ///< at or above the largest count
  PixelCount& operator+=(const PixelCount& other) noexcept;
  friend bool operator==(const PixelCount&, const PixelCount&) = default;
};

/// Largest grey level of 8 bits.
inline constexpr double kGreyLevels = 255;

/// Range of the sensor: saturated at either end.
struct CountRange {
  std::uint16_t least = 0;
  std::uint16_t most = 65535;
};

/// The temperature of every count, so that conversion is one look-up per pixel. 256 KiB.
class TemperatureTable {
 public:
  /// For a camera and an object. Counts at or below the radiometry's floor get NaN.
  explicit TemperatureTable(const Radiometry& radiometry, CountRange range = {});
  /// gain * count + offset degC; NaN for what no body in view has (kHottestBody). Throws
  /// std::invalid_argument when `gain` is not positive or either is not finite.
  TemperatureTable(double gain, double offset, CountRange range = {});
  /// For 8-bit grey: 0 is `black` degC and 255 is `white`. Larger counts get NaN. 0 and 255 are
  /// saturated. Throws std::invalid_argument where white is not above black, or is not finite.
  static TemperatureTable of_grey(double black, double white);

  [[nodiscard]] float operator[](std::uint16_t counts) const noexcept { return degrees_[counts]; }
  /// 65536 values, increasing except for NaN.
  [[nodiscard]] std::span<const float> degrees() const noexcept { return degrees_; }

  /// The smallest count of at least this temperature; 65536 if none.
  [[nodiscard]] std::uint32_t first_at_least(double temperature) const noexcept;

  /// Writes the temperatures to `degrees`, which must have the size of `counts`, else throws
  /// std::invalid_argument. Allocates nothing.
  PixelCount convert(std::span<const std::uint16_t> counts, std::span<float> degrees) const;
  /// The same for an image; `degrees` gets its rows consecutively. Also throws
  /// std::invalid_argument when the view is not valid.
  PixelCount convert(const CountView& counts, std::span<float> degrees) const;

 private:
  TemperatureTable() = default;
  std::vector<float> degrees_;
  CountRange range_{};
};

/// A rectangle of an image, in pixels, with other object parameters.
struct Region {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  ObjectParameters object;
};

/// Conversion of images with regions of other objects: a valve of bare metal, a pipe painted black.
/// Where regions overlap, the last one is used.
class RegionTables {
 public:
  /// Throws std::invalid_argument as Radiometry, naming the region's number, and when a region has
  /// no pixel or begins outside the image.
  RegionTables(const CameraConstants& camera, const ObjectParameters& background,
               std::span<const Region> regions, CountRange range = {});

  /// As TemperatureTable::convert of an image. Regions are clipped at its border.
  PixelCount convert(const CountView& counts, std::span<float> degrees) const;

 private:
  struct RegionTable {
    Region region;
    TemperatureTable table;
  };
  TemperatureTable background_;
  std::vector<RegionTable> regions_;
};

}  // namespace pipescout::thermal
