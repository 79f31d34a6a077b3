// SPDX-License-Identifier: Apache-2.0
#include "scene_check.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "pipescout/statistics/quantile.hpp"
#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {
namespace {

using validation::fixed_text;
using validation::number_text;

/// degC: below liquid nitrogen, -196 degC, the coldest that is carried in pipes in the open.
constexpr double kColdestBody = -200;
/// degC: the background of nearly all scenes on Earth; what half of an image has.
constexpr double kUsualLeast = -40;
constexpr double kUsualMost = 60;
/// K per count of cameras that output temperatures (FLIR: Duo Pro R user guide, 6.2.2, and Lepton
/// engineering data sheet, TLinear).
constexpr std::array kUsualGains{0.4, 0.1, 0.04, 0.01};
/// Of the pixels, at either end of what is told as the range: a few may be anything.
constexpr double kTail = 0.01;

bool is_usual(double degrees) {
  return degrees >= kUsualLeast && degrees <= kUsualMost;
}

struct Spread {
  double low = 0;
  double middle = 0;
  double high = 0;
};

Spread spread_of(std::vector<double>& values) {
  return {statistics::quantile_in_place(values, kTail), statistics::quantile_in_place(values, 0.5),
          statistics::quantile_in_place(values, 1 - kTail)};
}

std::string range_text(double low, double high) {
  return fixed_text(low, 1) + " to " + fixed_text(high, 1) + " degC";
}

[[noreturn]] void refuse_scale(const LinearScale& scale, const Spread& counts) {
  std::string text =
      "scale {gain: " + number_text(scale.gain) + ", offset: " + number_text(scale.offset) +
      "} of thermal.yaml makes its counts " +
      range_text(scale.gain * counts.low + scale.offset, scale.gain * counts.high + scale.offset) +
      ", which no body here has";
  std::string likely;
  for (const double gain : kUsualGains) {
    if (is_usual(gain * counts.middle - thermal::kZeroCelsius)) {
      likely += (likely.empty() ? "; likely is " : ", or ") + std::string("scale {gain: ") +
                number_text(gain) + ", offset: -273.15}: " +
                range_text(gain * counts.low - thermal::kZeroCelsius,
                           gain * counts.high - thermal::kZeroCelsius);
    }
  }
  throw ThermalFileError(text + likely);
}

}  // namespace

void require_scene(const ThermalPicture& picture, std::span<const std::size_t> missing,
                   const ThermalSettings& settings) {
  const bool scaled = picture.kind == ThermalFileKind::kCounts16 && settings.scale;
  if (!scaled && picture.kind != ThermalFileKind::kTemperature32) {
    return;
  }
  const auto each_pixel = [&](const auto& use) {
    auto next_missing = missing.begin();
    for (std::size_t i = 0; i < picture.degrees.size(); ++i) {
      const bool is_missing = next_missing != missing.end() && *next_missing == i;
      next_missing += is_missing ? 1 : 0;
      // Of 32-bit temperatures any number that no body has marks missing data.
      if (!is_missing && (scaled || !std::isnan(picture.degrees[i]))) {
        use(i);
      }
    }
  };
  std::size_t pixels = 0;
  std::size_t impossible = 0;
  each_pixel([&](std::size_t i) {
    const float degrees = picture.degrees[i];
    ++pixels;
    impossible += degrees > kColdestBody && degrees < thermal::kHottestBody ? 0U : 1U;
  });
  if (2 * impossible <= pixels) {
    return;
  }
  std::vector<double> values;
  each_pixel([&](std::size_t i) {
    values.push_back(
        static_cast<double>(scaled ? static_cast<float>(picture.counts[i]) : picture.degrees[i]));
  });
  const Spread spread = spread_of(values);
  if (scaled) {
    refuse_scale(*settings.scale, spread);
  }
  const bool kelvin = settings.float_unit == TemperatureUnit::kKelvin;
  const double zero = thermal::kZeroCelsius;
  throw ThermalFileError("its temperatures are " + range_text(spread.low, spread.high) +
                         ", which no body here has" +
                         (kelvin && is_usual(spread.middle + zero)
                              ? "; likely is float_unit: celsius in thermal.yaml: " +
                                    range_text(spread.low + zero, spread.high + zero)
                              : ""));
}

std::string unit_doubt(const ThermalPicture& picture, const ThermalSettings& settings) {
  if (picture.kind != ThermalFileKind::kTemperature32 ||
      settings.float_unit != TemperatureUnit::kCelsius) {
    return {};
  }
  const double zero = thermal::kZeroCelsius;
  std::size_t pixels = 0;
  std::size_t usual = 0;
  for (const float degrees : picture.degrees) {
    pixels += std::isnan(degrees) ? 0U : 1U;
    usual += is_usual(double{degrees} - zero) ? 1U : 0U;
  }
  if (2 * usual <= pixels) {
    return {};
  }
  std::vector<double> values;
  for (const float degrees : picture.degrees) {
    if (!std::isnan(degrees)) {
      values.push_back(double{degrees});
    }
  }
  const Spread spread = spread_of(values);
  // Nothing in view is as cold as what surrounds a scene.
  if (spread.low < kUsualLeast + zero) {
    return {};
  }
  return "temperatures of " + range_text(spread.low, spread.high) +
         " and nothing colder: if they are kelvin (" +
         range_text(spread.low - zero, spread.high - zero) +
         "), set float_unit: kelvin in thermal.yaml";
}

}  // namespace pipescout
