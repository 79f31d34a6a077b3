// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/ibarguren2013_figure7.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "pipescout/csv/csv_reader.hpp"

namespace pipescout::leak_study {
namespace {

using thermal::PartKind;
using thermal::PipePart;

constexpr std::size_t kPartSamples = 20;
constexpr std::size_t kJointSamples = 3;
constexpr double kJointRise = 100.0;
constexpr double kHighest = 300.0;  // degC, of the camera

/// The cell of the current row as a number.
double number(const CsvReader& file, std::size_t column) {
  const std::optional<double> value = file.number(column);
  if (!value || !std::isfinite(*value)) {
    file.refuse(column, "a finite number");
  }
  return *value;
}

/// The cell of the current row as a number of a stretch or part, from 1 on.
int ordinal(const CsvReader& file, std::size_t column) {
  constexpr int kMost = 1000;
  const double value = number(file, column);
  if (!(value >= 1 && value <= kMost && std::floor(value) == value)) {
    file.refuse(column, "an integer from 1 to 1000");
  }
  return static_cast<int>(value);
}

bool continues(const Figure7Part& before, const Figure7Part& next) {
  return before.sequence == next.sequence && before.stretch == next.stretch;
}

/// Of the middle of a part.
PartKind kind_at(std::span<const PipePart> parts, double place) {
  const auto found = std::find_if(parts.begin(), parts.end(),
                                  [place](const PipePart& part) { return place < part.to; });
  return found == parts.end() ? PartKind::kHidden : found->kind;
}

}  // namespace

std::vector<Figure7Part> read_figure7(std::string_view csv, std::string_view path) {
  CsvReader file(csv, path);
  const std::vector<std::string> columns{"sequence", "stretch", "part", "mean_temperature"};
  if (file.columns() != columns) {
    throw CsvError(file.path(), file.header_line(),
                   "the columns are not sequence, stretch, part, mean_temperature");
  }
  std::vector<Figure7Part> parts;
  while (file.next()) {
    parts.push_back({.sequence = std::string(file.cells()[0]),
                     .stretch = ordinal(file, 1),
                     .part = ordinal(file, 2),
                     .mean = number(file, 3)});
  }
  return parts;
}

Figure7Labels label_figure7(std::span<const Figure7Part> parts,
                            const thermal::ProfileParameters& parameters) {
  thermal::ProfileAnalysis analysis(parameters);
  Figure7Labels labels;
  std::vector<float> profile;
  bool flagged = false;
  for (std::size_t first = 0; first < parts.size();) {
    std::size_t last = first;
    while (last + 1 < parts.size() && continues(parts[last], parts[last + 1])) {
      ++last;
    }
    profile.clear();
    for (std::size_t i = first; i <= last; ++i) {
      if (i > first) {
        const double warmer = std::max(parts[i - 1].mean, parts[i].mean);
        const double colder = std::min(parts[i - 1].mean, parts[i].mean);
        const double joint =
            warmer + kJointRise <= kHighest ? warmer + kJointRise : colder - kJointRise;
        profile.insert(profile.end(), kJointSamples, static_cast<float>(joint));
      }
      profile.insert(profile.end(), kPartSamples, static_cast<float>(parts[i].mean));
    }
    analysis.analyse(profile, {}, {});
    for (std::size_t i = first; i <= last; ++i) {
      const std::size_t start = (i - first) * (kPartSamples + kJointSamples);
      labels.kinds.push_back(
          kind_at(analysis.parts(), static_cast<double>(start) + 0.5 * kPartSamples));
      flagged = flagged || labels.kinds.back() == PartKind::kLeak;
    }
    first = last + 1;
    if (first == parts.size() || parts[first].sequence != parts[last].sequence) {
      ++labels.sequences;
      labels.flagged += flagged ? 1U : 0U;
      flagged = false;
    }
  }
  labels.warmest_sound = -std::numeric_limits<double>::infinity();
  labels.coldest_leak = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (labels.kinds[i] == PartKind::kLeak) {
      labels.coldest_leak = std::min(labels.coldest_leak, parts[i].mean);
    } else {
      labels.warmest_sound = std::max(labels.warmest_sound, parts[i].mean);
    }
  }
  labels.cut_off = labels.warmest_sound < labels.coldest_leak
                       ? 0.5 * (labels.warmest_sound + labels.coldest_leak)
                       : std::numeric_limits<double>::quiet_NaN();
  return labels;
}

}  // namespace pipescout::leak_study
