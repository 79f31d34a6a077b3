// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {

using validation::refuse;
using validation::require;

std::string_view to_string(Severity severity) noexcept {
  switch (severity) {
    case Severity::kMinor:
      return "minor";
    case Severity::kModerate:
      return "moderate";
    case Severity::kSevere:
      return "severe";
    case Severity::kCritical:
      return "critical";
  }
  return "unknown";
}

std::string_view to_string(FrameFault fault) noexcept {
  switch (fault) {
    case FrameFault::kNone:
      return "none";
    case FrameFault::kBadShape:
      return "bad_shape";
    case FrameFault::kBadTable:
      return "bad_table";
    case FrameFault::kNoTemperature:
      return "no_temperature";
    case FrameFault::kSaturated:
      return "saturated";
    case FrameFault::kCluttered:
      return "cluttered";
  }
  return "unknown";
}

std::string_view to_string(DetectorPreset preset) noexcept {
  switch (preset) {
    case DetectorPreset::kCollectors:
      return "collectors";
    case DetectorPreset::kTorresol:
      return "torresol";
    case DetectorPreset::kHotPipes:
      return "hot_pipes";
    case DetectorPreset::kColdPipes:
      return "cold_pipes";
    case DetectorPreset::kContrast:
      return "contrast";
  }
  return "unknown";
}

std::optional<DetectorPreset> detector_preset(std::string_view name) noexcept {
  for (const DetectorPreset preset : kDetectorPresets) {
    if (to_string(preset) == name) {
      return preset;
    }
  }
  return std::nullopt;
}

Severity SeverityScale::of(double delta, double length) const noexcept {
  int level = delta >= severe_delta ? 2 : delta >= moderate_delta ? 1 : 0;
  level += length >= long_leak ? 1 : 0;
  return static_cast<Severity>(level);
}

void SeverityScale::validate() const {
  require("moderate_delta", moderate_delta, moderate_delta > 0, "(0, inf) K");
  require("severe_delta", severe_delta, severe_delta > moderate_delta, "(moderate_delta, inf) K");
  require("long_leak", long_leak, long_leak > 0, "(0, inf) m");
}

LeakDetectorParameters LeakDetectorParameters::of(DetectorPreset preset) {
  switch (preset) {
    case DetectorPreset::kCollectors:
      return {};
    case DetectorPreset::kTorresol:
      return torresol();
    case DetectorPreset::kHotPipes:
      return adaptive(Polarity::kHot);
    case DetectorPreset::kColdPipes:
      return adaptive(Polarity::kCold);
    case DetectorPreset::kContrast:
      return by_contrast();
  }
  refuse("preset: not an enumerator");
}

LeakDetectorParameters LeakDetectorParameters::torresol() {
  LeakDetectorParameters p;
  p.profile = ProfileParameters::torresol();
  return p;
}

LeakDetectorParameters LeakDetectorParameters::adaptive(Polarity polarity) {
  LeakDetectorParameters p;
  p.threshold_rule = ThresholdRule::kLocal;
  p.polarity = polarity;
  p.min_contrast = 0.2;
  p.min_length = 0.1;
  p.profile.split_delta = 3.0;
  p.profile.leak_delta = 5.0;
  p.severity.moderate_delta = 15.0;
  p.severity.severe_delta = 40.0;
  return p;
}

LeakDetectorParameters LeakDetectorParameters::by_contrast() {
  LeakDetectorParameters p;
  p.threshold_rule = ThresholdRule::kContrast;
  p.min_contrast = 2.0;
  // Least rise of what is flat: a level of grey, or ten times the noise of a camera.
  p.profile.leak_delta = 1.0;
  p.profile.split_delta = 0.7;
  // Leaks that nearly fill the view, where no other image tells the level of the tube.
  p.profile.reference_quantile = 0.1;
  p.profile.leak_spreads = 12.0;
  p.profile.leak_share = 0.08;
  return p;
}

void LeakDetectorParameters::validate() const {
  require("threshold", threshold, threshold > -273.15, "(-273.15, inf) degC");
  require("min_contrast", min_contrast, min_contrast > 0, "(0, inf) K");
  require("local_radius", local_radius, local_radius > 0 && local_radius <= 1, "(0, 1]");
  require("contrast_level", contrast_level, contrast_level > 0 && contrast_level < 1, "(0, 1)");
  require("min_width", min_width, min_width >= 1, "[1, inf) pixels");
  require("max_width", max_width, max_width > 0 && max_width <= 1, "(0, 1]");
  require("min_length", min_length, min_length > 0 && min_length <= 1, "(0, 1]");
  require("min_elongation", min_elongation, min_elongation >= 1, "[1, inf)");
  require("min_visible", min_visible, min_visible >= 0 && min_visible <= 1, "[0, 1]");
  require("straightness", straightness, straightness > 0, "(0, inf) pixels");
  require("max_gap", max_gap, max_gap >= 0, "[0, inf)");
  require("profile_width", profile_width, profile_width > 0 && profile_width <= 1, "(0, 1]");
  require("pipe_diameter", pipe_diameter, pipe_diameter >= 0, "[0, inf) m");
  require("max_pipes", static_cast<double>(max_pipes), max_pipes >= 1 && max_pipes <= 64,
          "[1, 64]");
  severity.validate();
  profile.validate();
  if (polarity == Polarity::kCold && !profile.leak_delta) {
    refuse(
        "leak_delta: is not set; on cold pipes a leak is colder than the pipe, and "
        "maximum_temperature does not detect it");
  }
}

}  // namespace pipescout::thermal
