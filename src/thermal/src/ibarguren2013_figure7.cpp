// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/ibarguren2013_figure7.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

using validation::refuse;

constexpr std::size_t kPartSamples = 20;
constexpr std::size_t kJointSamples = 3;
constexpr double kJointRise = 100.0;
constexpr double kHighest = 300.0;  // degC, of the camera

template <class Number>
Number number(std::string_view text, int line) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    refuse("line ", line, ": '", text, "' is not a number");
  }
  return value;
}

/// Takes off what is before the separator, or all.
std::string_view take(std::string_view& text, char separator) {
  const std::size_t end = text.find(separator);
  const std::string_view before = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  return before;
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

std::vector<Figure7Part> read_figure7(std::string_view csv) {
  std::vector<Figure7Part> parts;
  int line = 1;
  take(csv, '\n');
  while (!csv.empty()) {
    ++line;
    std::string_view rest = take(csv, '\n');
    if (std::count(rest.begin(), rest.end(), ',') != 3) {
      refuse("line ", line, ": '", rest, "' does not have 4 columns");
    }
    Figure7Part part;
    part.sequence = take(rest, ',');
    part.stretch = number<int>(take(rest, ','), line);
    part.part = number<int>(take(rest, ','), line);
    part.mean = number<double>(rest, line);
    parts.push_back(part);
  }
  return parts;
}

Figure7Labels label_figure7(std::span<const Figure7Part> parts,
                            const ProfileParameters& parameters) {
  ProfileAnalysis analysis(parameters);
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

}  // namespace pipescout::thermal
