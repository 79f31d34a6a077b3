// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/misplaced_pipes.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/statistics/draw.hpp"
#include "place_images.hpp"

namespace pipescout::rack_study {
namespace {

using rack_vision::RackModel;

/// The images of one place, and what is tried on them.
class MisplacedPlace {
 public:
  MisplacedPlace(const MisplacedPipesSettings& settings, std::uint64_t seed)
      : settings_(settings),
        engine_(seed),
        images_(settings.rack, settings.world, settings.duration, engine_) {}

  MisplacedPipesTrial fly(const RackModel& file) {
    rack_vision::RackLocalizationParameters parameters;
    if (settings_.stated_deviation > 0) {
      parameters.tracker.offset_sigma = settings_.stated_deviation;
    }
    MisplacedPipesTrial trial;
    trial.frames = images_.localize(
        file, parameters,
        draw_first_pose(settings_.start_position, settings_.start_rotation, engine_),
        [&](const rack_vision::RackTrackerResult& result, const FrameScore& frame) {
          if (frame.has_pose) {
            trial.largest_offset_error = largest_error(file, result);
          }
        });
    return trial;
  }

  RackModel draw_file() {
    constexpr int kMostDraws = 1000;
    for (int i = 0; i < kMostDraws; ++i) {
      RackModel file = settings_.rack;
      for (rack_vision::Pipe& pipe : file.pipes) {
        if (pipe.movable) {
          pipe.start.x() +=
              statistics::uniform(engine_, -settings_.largest_offset, settings_.largest_offset);
        }
      }
      try {
        file.validate();
        return file;
      } catch (const rack_vision::InvalidRack&) {
        continue;  // some pipes ran through each other
      }
    }
    return settings_.rack;
  }

 private:
  [[nodiscard]] double largest_error(const RackModel& file,
                                     const rack_vision::RackTrackerResult& result) const {
    // Where nothing is observed, all count: to say nothing is not to be right.
    const bool any = std::ranges::any_of(result.offset_observed,
                                         [](std::uint8_t observed) { return observed != 0; });
    double largest = 0;
    for (std::size_t i = 0; i < file.pipes.size(); ++i) {
      if (file.pipes[i].movable && (!any || result.offset_observed[i] != 0)) {
        const double truth = settings_.rack.pipes[i].start.x() - file.pipes[i].start.x();
        largest = std::max(largest, std::abs(result.offsets[i] - truth));
      }
    }
    return largest;
  }

  const MisplacedPipesSettings& settings_;
  std::mt19937_64 engine_;
  PlaceImages images_;
};

}  // namespace

MisplacedPipesScore& MisplacedPipesScore::operator+=(const MisplacedPipesScore& other) noexcept {
  trials += other.trials;
  converged += other.converged;
  lost += other.lost;
  silent_wrong += other.silent_wrong;
  images_with_pose += other.images_with_pose;
  images_silent += other.images_silent;
  images_covered += other.images_covered;
  return *this;
}

std::vector<MisplacedPipesTrial> try_misplaced_pipes(const MisplacedPipesSettings& settings,
                                                     std::size_t trials, std::uint64_t seed) {
  MisplacedPlace place(settings, seed);
  std::vector<MisplacedPipesTrial> results;
  for (std::size_t i = 0; i < trials; ++i) {
    results.push_back(place.fly(place.draw_file()));
  }
  return results;
}

MisplacedPipesTrial try_misplaced_pipes(const MisplacedPipesSettings& settings,
                                        std::span<const double> file_offsets, std::uint64_t seed) {
  RackModel file = settings.rack;
  for (std::size_t i = 0; i < file.pipes.size() && i < file_offsets.size(); ++i) {
    file.pipes[i].start.x() += file_offsets[i];
  }
  return MisplacedPlace(settings, seed).fly(file);
}

MisplacedPipesScore score_misplaced_pipes(std::span<const MisplacedPipesTrial> trials) {
  MisplacedPipesScore score;
  for (const MisplacedPipesTrial& trial : trials) {
    ++score.trials;
    const PlaceOutcome outcome = outcome_of(trial.frames);
    score.images_with_pose += outcome.images.with_pose;
    score.images_covered += outcome.images.pose_covered_99;
    score.images_silent += outcome.images.silent_wrong;
    score.silent_wrong += outcome.images.silent_wrong > 0 ? 1 : 0;
    score.lost += outcome.lost ? 1 : 0;
    score.converged += outcome.converged ? 1 : 0;
  }
  return score;
}

}  // namespace pipescout::rack_study
