// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// What happened to the pixels of a picture.
struct PixelCount {
  std::size_t pixels = 0;
  std::size_t without_temperature = 0;  ///< NaN
  std::size_t below_range = 0;          ///< at or below the least that the sensor counts
  std::size_t above_range = 0;          ///< at or above the most
  PixelCount& operator+=(const PixelCount& other) noexcept;
  friend bool operator==(const PixelCount&, const PixelCount&) = default;
};

/// Counts between which a sensor tells temperatures apart: at either end it is saturated.
struct CountRange {
  std::uint16_t least = 0;
  std::uint16_t most = 65535;
};

/// The temperature of every count, so that a picture costs a look-up a pixel. 256 KiB.
class TemperatureTable {
 public:
  /// Of a camera and an object. Counts at or below the radiometry's floor get NaN.
  explicit TemperatureTable(const Radiometry& radiometry, CountRange range = {});
  /// gain * count + offset degC. Throws std::invalid_argument where `gain` is not positive or
  /// either is not finite.
  TemperatureTable(double gain, double offset, CountRange range = {});
  /// Of 8-bit grey: 0 is `black` degC and 255 is `white`. Greater counts get NaN. 0 and 255 are
  /// saturated. Throws std::invalid_argument where white is not above black, or is not finite.
  static TemperatureTable of_grey(double black, double white);

  [[nodiscard]] float operator[](std::uint16_t counts) const noexcept { return degrees_[counts]; }
  /// 65536 of them, rising but for the NaN.
  [[nodiscard]] std::span<const float> degrees() const noexcept { return degrees_; }

  /// The least count of at least this temperature; 65536 where there is none.
  [[nodiscard]] std::uint32_t first_at_least(double temperature) const noexcept;

  /// `degrees`, as many as `counts`, gets the temperatures. Throws std::invalid_argument where it
  /// has another size. Takes nothing from the heap.
  PixelCount convert(std::span<const std::uint16_t> counts, std::span<float> degrees) const;
  /// The same for a picture; `degrees` gets its rows one after the other. Throws
  /// std::invalid_argument where the view is not valid too.
  PixelCount convert(const CountView& counts, std::span<float> degrees) const;

 private:
  TemperatureTable() = default;
  std::vector<float> degrees_;
  CountRange range_{};
};

/// A rectangle of a picture, in pixels, whose object has parameters of its own.
struct Region {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  ObjectParameters object;
};

/// Pictures of one camera in which regions see objects of their own: a valve of bare metal, a pipe
/// painted black. Where regions overlap, the last counts.
class RegionTables {
 public:
  /// Throws std::invalid_argument as Radiometry, naming the region's number, and where a region has
  /// no pixel or begins outside the picture.
  RegionTables(const CameraConstants& camera, const ObjectParameters& background,
               std::span<const Region> regions, CountRange range = {});

  /// As TemperatureTable::convert of a picture. Regions are cut at its border.
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
