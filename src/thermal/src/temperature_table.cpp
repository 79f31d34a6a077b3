// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/temperature_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

using validation::refuse;
using validation::require;

constexpr std::size_t kCounts = 65536;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

void require_range(CountRange range) {
  if (range.least >= range.most) {
    refuse("range: [", range.least, ", ", range.most, "] is empty");
  }
}

void require_size(std::size_t counts, std::size_t degrees) {
  if (counts != degrees) {
    refuse("degrees: ", degrees, " pixels for ", counts, " counts");
  }
}

void require_picture(const CountView& counts, std::span<const float> degrees) {
  if (!counts.valid()) {
    refuse("counts: ", counts.width, " x ", counts.height, " pixels in rows of ", counts.stride,
           " are no picture");
  }
  require_size(static_cast<std::size_t>(counts.width) * static_cast<std::size_t>(counts.height),
               degrees.size());
}

}  // namespace

PixelCount& PixelCount::operator+=(const PixelCount& other) noexcept {
  pixels += other.pixels;
  without_temperature += other.without_temperature;
  below_range += other.below_range;
  above_range += other.above_range;
  return *this;
}

TemperatureTable::TemperatureTable(const Radiometry& radiometry, CountRange range)
    : degrees_(kCounts), range_(range) {
  require_range(range);
  for (std::size_t i = 0; i < kCounts; ++i) {
    degrees_[i] = static_cast<float>(radiometry.temperature(static_cast<double>(i)));
  }
}

TemperatureTable::TemperatureTable(double gain, double offset, CountRange range)
    : degrees_(kCounts), range_(range) {
  require("gain", gain, gain > 0, "(0, inf) K per count");
  require("offset", offset, true, "(-inf, inf) degC");
  require_range(range);
  for (std::size_t i = 0; i < kCounts; ++i) {
    const double degrees = gain * static_cast<double>(i) + offset;
    degrees_[i] =
        degrees > -kZeroCelsius && degrees < kHottestBody ? static_cast<float>(degrees) : kNaN;
  }
}

TemperatureTable TemperatureTable::of_grey(double black, double white) {
  require("black", black, true, "(-inf, inf) degC");
  require("white", white, white > black, "(black, inf) degC");
  TemperatureTable table;
  table.degrees_.assign(kCounts, kNaN);
  table.range_ = {.least = 0, .most = 255};
  for (std::size_t i = 0; i < 256; ++i) {
    table.degrees_[i] = static_cast<float>(black + (white - black) * static_cast<double>(i) / 255);
  }
  return table;
}

std::uint32_t TemperatureTable::first_at_least(double temperature) const noexcept {
  // NaN stands at the low end of a radiometry's table and at the high end of a grey one: the first
  // part must be passed by, the second not reached.
  const auto* const first = degrees_.data();
  const auto* const low = std::find_if(first, first + kCounts, [](float t) { return t == t; });
  const auto* const found = std::partition_point(low, first + kCounts, [temperature](float t) {
    return static_cast<double>(t) < temperature;
  });
  return found == first + kCounts || std::isnan(*found) ? static_cast<std::uint32_t>(kCounts)
                                                        : static_cast<std::uint32_t>(found - first);
}

PixelCount TemperatureTable::convert(std::span<const std::uint16_t> counts,
                                     std::span<float> degrees) const {
  require_size(counts.size(), degrees.size());
  PixelCount result;
  result.pixels = counts.size();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::uint16_t count = counts[i];
    const float degree = degrees_[count];
    degrees[i] = degree;
    result.without_temperature += std::isnan(degree) ? 1U : 0U;
    result.below_range += count <= range_.least ? 1U : 0U;
    result.above_range += count >= range_.most ? 1U : 0U;
  }
  return result;
}

PixelCount TemperatureTable::convert(const CountView& counts, std::span<float> degrees) const {
  require_picture(counts, degrees);
  const auto width = static_cast<std::size_t>(counts.width);
  PixelCount result;
  for (int y = 0; y < counts.height; ++y) {
    result += convert(std::span(counts.row(y), width),
                      degrees.subspan(static_cast<std::size_t>(y) * width, width));
  }
  return result;
}

RegionTables::RegionTables(const CameraConstants& camera, const ObjectParameters& background,
                           std::span<const Region> regions, CountRange range)
    : background_(Radiometry(camera, background), range) {
  regions_.reserve(regions.size());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Region& region = regions[i];
    if (region.x < 0 || region.y < 0) {
      refuse("regions[", i, "]: begins at (", region.x, ", ", region.y, "), outside [0, inf)");
    }
    if (region.width < 1 || region.height < 1) {
      refuse("regions[", i, "]: ", region.width, " x ", region.height,
             " pixels is outside [1, inf)");
    }
    try {
      regions_.push_back({region, TemperatureTable(Radiometry(camera, region.object), range)});
    } catch (const std::invalid_argument& error) {
      refuse("regions[", i, "].", error.what());
    }
  }
}

PixelCount RegionTables::convert(const CountView& counts, std::span<float> degrees) const {
  require_picture(counts, degrees);
  const int width = counts.width;
  // Every pixel is counted once, by the table that it is converted with: a row falls into
  // stretches between the borders of the regions that cross it.
  PixelCount result;
  for (int y = 0; y < counts.height; ++y) {
    const std::span row(counts.row(y), static_cast<std::size_t>(width));
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (int x = 0; x < width;) {
      const TemperatureTable* table = &background_;
      int end = width;
      for (const RegionTable& candidate : regions_) {
        const Region& r = candidate.region;
        if (y < r.y || y - r.y >= r.height) {
          continue;
        }
        if (x < r.x) {
          end = std::min(end, r.x);
        } else if (x - r.x < r.width) {
          table = &candidate.table;
          end = std::min(end, r.x + std::min(r.width, width - r.x));
        }
      }
      const auto begin = static_cast<std::size_t>(x);
      const auto size = static_cast<std::size_t>(end - x);
      result += table->convert(row.subspan(begin, size), degrees.subspan(first + begin, size));
      x = end;
    }
  }
  return result;
}

}  // namespace pipescout::thermal
