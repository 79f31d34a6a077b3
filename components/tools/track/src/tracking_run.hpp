// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "image_source.hpp"
#include "pipe_tracks.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal/preset_trial.hpp"

namespace pipescout::track {

struct RunOptions {
  std::uint64_t seed = 1;
  std::filesystem::path overlays;  ///< folder of the pictures, made with the first
  std::size_t overlay_count = 0;   ///< of pictures, spread over the images
};

/// The images of one recording: their tracks, pictures of them, and what to tell at the end.
class TrackingRun {
 public:
  TrackingRun(const SurveySettings& survey, const RunOptions& options);

  /// How many images there will be; before the first.
  void expect(std::size_t images) noexcept { expected_ = images; }
  /// Throws std::runtime_error for a picture that cannot be written.
  void take(const SourceImage& image);
  void fail(const std::string& name, const std::string& problem, const std::string& advice);

  [[nodiscard]] const PipeTracks& tracks() const noexcept { return tracks_; }
  [[nodiscard]] std::size_t overlays() const noexcept { return overlays_; }
  /// Problems of images, those of the same text together.
  [[nodiscard]] std::vector<std::string> problems() const;
  /// What to do: for images that could not be used, for a recording without pipes or tracks.
  [[nodiscard]] std::vector<std::string> advice() const;

 private:
  struct Problem {
    std::string name;  // of the first image
    std::string text;
    std::size_t images = 1;
  };
  void draw(const SourceImage& image);
  void try_presets(const SourceImage& image);

  SurveySettings survey_;
  RunOptions options_;
  PipeTracks tracks_;
  thermal::PresetTrial trial_;
  std::vector<float> degrees_;
  std::vector<Problem> problems_;
  std::vector<std::string> advice_;
  std::size_t expected_ = 0;
  std::size_t overlays_ = 0;
  bool unit_is_doubted_ = false;
};

}  // namespace pipescout::track
