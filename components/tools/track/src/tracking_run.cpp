// SPDX-License-Identifier: Apache-2.0
#include "tracking_run.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <variant>

#include "overlay.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/leak_survey/preset_advice.hpp"

namespace pipescout::track {

TrackingRun::TrackingRun(const SurveySettings& survey, const RunOptions& options)
    : survey_(survey), options_(options), tracks_(survey.detector, options.seed) {}

void TrackingRun::take(const SourceImage& image) {
  tracks_.take(image);
  if (tracks_.with_pipes() == 0) {
    try_presets(image);
  }
  if (!image.unit_doubt.empty() && !unit_is_doubted_) {
    unit_is_doubted_ = true;
    problems_.push_back({.name = image.name, .text = image.unit_doubt});
  }
  draw(image);
}

void TrackingRun::try_presets(const SourceImage& image) {
  std::visit(
      [&](const auto& view) {
        if constexpr (std::is_same_v<std::decay_t<decltype(view)>, thermal::TemperatureView>) {
          trial_.keep(view);
        } else {
          degrees_.clear();
          for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
              const std::size_t value = view(x, y);
              degrees_.push_back(value < image.celsius.size()
                                     ? image.celsius[value]
                                     : std::numeric_limits<float>::quiet_NaN());
            }
          }
          trial_.keep({degrees_.data(), view.width, view.height, view.width});
        }
      },
      image.pixels);
}

void TrackingRun::draw(const SourceImage& image) {
  const std::size_t number = tracks_.images() - 1;
  const std::size_t step = options_.overlay_count == 0
                               ? 0
                               : std::max<std::size_t>(1, expected_ / options_.overlay_count);
  const bool has_pixels = std::visit([](const auto& view) { return view.valid(); }, image.pixels);
  if (step == 0 || number % step != 0 || !has_pixels) {
    return;
  }
  std::filesystem::create_directories(options_.overlays);
  write_overlay(command_line::numbered_picture(options_.overlays, number, image.name), image,
                tracks_.regions(), tracks_.track());
  ++overlays_;
}

void TrackingRun::fail(const std::string& name, const std::string& problem,
                       const std::string& advice) {
  tracks_.fail(name, problem);
  const auto same = std::ranges::find(problems_, problem, &Problem::text);
  if (same != problems_.end()) {
    ++same->images;
  } else {
    problems_.push_back({.name = name, .text = problem});
  }
  if (!advice.empty() && std::ranges::find(advice_, advice) == advice_.end()) {
    advice_.push_back(advice);
  }
}

std::vector<std::string> TrackingRun::problems() const {
  std::vector<std::string> texts;
  for (const Problem& problem : problems_) {
    std::string text = problem.text.find(problem.name + ":") == std::string::npos
                           ? problem.name + ": " + problem.text
                           : problem.text;
    if (problem.images > 1) {
      text += ", and so " + std::to_string(problem.images - 1) +
              (problem.images == 2 ? " more image" : " more images");
    }
    texts.push_back(std::move(text));
  }
  return texts;
}

std::vector<std::string> TrackingRun::advice() const {
  std::vector<std::string> all = advice_;
  const std::string of_tracks = tracks_.advice();
  const std::string of_presets = tracks_.with_pipes() == 0 && tracks_.images() > 0
                                     ? preset_advice(trial_, survey_, tracks_.images())
                                     : "";
  for (const std::string& each : {of_tracks, of_presets}) {
    if (!each.empty()) {
      all.push_back(each);
    }
  }
  return all;
}

}  // namespace pipescout::track
