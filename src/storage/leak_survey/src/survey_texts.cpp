// SPDX-License-Identifier: Apache-2.0
#include "survey_texts.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "pipescout/statistics/normal.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kMostLeaksTold = 3;  // of one picture

std::string digits(double value, std::chars_format format, int precision) {
  // Long enough for the largest number, whose value has 309 digits.
  std::array<char, 400> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
  return {text.data(), end};
}

std::string rounded(double value) {
  return digits(value, std::chars_format::general, 4);
}

std::string fixed_tenth(double value) {
  return digits(value, std::chars_format::fixed, 1);
}

/// "emissivity 0.95 +- 0.02"
std::string with_deviation(const char* name, double value, double deviation, const char* unit) {
  return std::string(name) + " " + rounded(value) + " +- " + rounded(deviation) + unit;
}

std::string parameters_text(const ThermalPicture& picture, const ThermalSettings& thermal) {
  const thermal::ParameterDeviations& d = thermal.deviations;
  if (picture.radiometry) {
    const thermal::ObjectParameters& o = picture.radiometry->object();
    std::vector<std::string> lines = {
        with_deviation("emissivity", o.emissivity, d.emissivity, ""),
        with_deviation("reflected", o.reflected_temperature, d.reflected_temperature, " degC"),
        with_deviation("distance", o.distance, d.distance, " m"),
        with_deviation("air", o.atmospheric_temperature, d.atmospheric_temperature, " degC"),
        with_deviation("humidity", o.relative_humidity, d.relative_humidity, "")};
    if (o.window_transmission < 1) {
      lines.push_back(
          with_deviation("window transmission", o.window_transmission, d.window_transmission, ""));
      lines.push_back(
          with_deviation("window", o.window_temperature, d.window_temperature, " degC"));
    }
    lines.push_back("calibration +- " + rounded(d.calibration) + " K");
    return joined_lines(lines);
  }
  if (picture.kind == ThermalFileKind::kCounts16 && thermal.scale) {
    return "degC = " + rounded(thermal.scale->gain) + " count + " + rounded(thermal.scale->offset);
  }
  if (picture.levels) {
    return "automatic gain: grey levels without degrees";
  }
  if (picture.kind == ThermalFileKind::kGrey8 && thermal.grey) {
    return "black " + rounded(thermal.grey->black) + " degC, white " +
           rounded(thermal.grey->white) + " degC";
  }
  return "temperatures as in the file";
}

std::string calibration_text(const ThermalPicture& picture, const SurveySettings& survey) {
  std::string text = survey.calibration;
  if (picture.radiometry) {
    const thermal::PlanckConstants& p = picture.radiometry->camera().planck;
    text += (text.empty() ? "" : "\n");
    text += "Planck: R1 " + rounded(p.r1) + ", R2 " + rounded(p.r2) + ", B " + rounded(p.b) +
            ", F " + rounded(p.f) + ", O " + rounded(p.o);
  }
  return text;
}

std::string count_of(std::size_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// "+85.3 +- 4.1 K"
std::string delta_text(const thermal::LeakDetection& found) {
  if (std::isnan(found.delta)) {
    return "by contrast";
  }
  std::string text = "+" + fixed_tenth(found.delta);
  if (std::isfinite(found.delta_low)) {
    return text + " K (" + fixed_tenth(found.delta_low) + " to " + fixed_tenth(found.delta_high) +
           ")";
  }
  if (std::isfinite(found.delta_deviation)) {
    text += " +- " + fixed_tenth(statistics::kNormal95 * found.delta_deviation);
  }
  return text + " K";
}

}  // namespace

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

std::string fault_text(thermal::FrameFault fault) {
  switch (fault) {
    case thermal::FrameFault::kNone:
      return "";
    case thermal::FrameFault::kBadShape:
      return "has no pixels";
    case thermal::FrameFault::kBadTable:
      return "contains counts without a temperature";
    case thermal::FrameFault::kNoTemperature:
      return "no pixel has a temperature";
    case thermal::FrameFault::kSaturated:
      return "all pixels are the same: saturated, or covered";
    case thermal::FrameFault::kCluttered:
      return "too cluttered: the threshold is within the background";
  }
  return "is at fault";
}

std::string picture_summary(const ThermalPicture& picture, const thermal::Detections& detections) {
  float coldest = std::numeric_limits<float>::infinity();
  float hottest = -coldest;
  for (const float degrees : picture.degrees) {
    if (std::isfinite(degrees)) {
      coldest = std::min(coldest, degrees);
      hottest = std::max(hottest, degrees);
    }
  }
  std::string text = std::to_string(picture.width) + " x " + std::to_string(picture.height) + ", " +
                     std::string(to_string(picture.kind));
  if (coldest <= hottest) {
    text += ", " + rounded(double{coldest}) + " to " + rounded(double{hottest}) +
            (picture.levels ? " of 255 grey levels" : " degC");
  }
  text += "; " + (detections.pipes.empty() ? "no pipe" : count_of(detections.pipes.size(), "pipe"));
  for (std::size_t i = 0; i < detections.pipes.size(); ++i) {
    text += (i == 0 ? " (" : ", ") + std::to_string(std::lround(detections.pipes[i].length()));
  }
  text += detections.pipes.empty() ? "" : " pixels long)";
  if (!detections.leaks.empty()) {
    text += ", " + count_of(detections.leaks.size(), "leak");
  }
  const std::size_t told = std::min(detections.leaks.size(), kMostLeaksTold);
  for (std::size_t i = 0; i < told; ++i) {
    text += (i == 0 ? " (" : ", ") + delta_text(detections.leaks[i]);
  }
  text += told < detections.leaks.size() ? ", ...)" : told > 0 ? ")" : "";
  const thermal::PixelCount& count = picture.count;
  if (count.without_temperature > 0) {
    text += "; " + count_of(count.without_temperature, "pixel") + " without temperature";
  }
  if (count.below_range + count.above_range > 0) {
    text += "; " + count_of(count.below_range + count.above_range, "saturated pixel");
  }
  return text;
}

ConditionRecord condition_record(const ThermalPicture& picture, const ThermalSettings& thermal,
                                 const SurveySettings& survey, double time,
                                 const std::string& source) {
  ConditionRecord record;
  record.time = time;
  record.source = source;
  record.camera = picture.camera + (picture.lens.empty() ? "" : ", lens " + picture.lens);
  record.parameters = parameters_text(picture, thermal);
  record.weather = survey.weather;
  record.calibration = calibration_text(picture, survey);
  record.doubts = joined_lines(picture.doubts);
  return record;
}

}  // namespace pipescout
