// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// Racks whose pipes lie elsewhere than the rack file has them, on images: Lippiello and Cacace,
/// equations (23) to (26) and Figure 8, from the first image on.
namespace pipescout::rack_study {

struct MisplacedPipesSettings {
  rack_vision::RackModel rack{};  ///< the true one; its pipes are where they are
  World world = World::kRayCaster;
  /// The pipes that are movable lie up to this far beside the file's places, m, each drawn evenly;
  /// neighbours do not run through each other.
  double largest_offset = 0.06;
  /// What the localisation is told of them, m, one sigma; 0: nothing, its default stands.
  double stated_deviation = 0;
  double duration = 3;            ///< s, of images, at 25 Hz
  double start_position = 0.01;   ///< m, one sigma, of the first pose; the localisation is told it
  double start_rotation = 0.005;  ///< rad
};

struct MisplacedPipesTrial {
  std::vector<FrameScore> frames;
  /// m, of the pipes observed in the last image with a pose; of all where none is.
  double largest_offset_error = 0;
};

struct MisplacedPipesScore {
  std::size_t trials = 0;
  std::size_t converged = 0;  ///< the last image has a pose that is not wrong
  std::size_t lost = 0;       ///< the last image has no pose
  /// In some image a pose was wrong, `is_wrong`, and the covariance denied it (99 %).
  std::size_t silent_wrong = 0;
  std::size_t images_with_pose = 0;
  std::size_t images_silent = 0;   ///< of them: wrong and denied
  std::size_t images_covered = 0;  ///< of them: the truth in the ellipsoid of 99 %

  MisplacedPipesScore& operator+=(const MisplacedPipesScore& other) noexcept;
};

/// `trials` at one place of a flight over the rack, which the seed draws; they share its images and
/// have a rack file each. The same arguments give the same bits.
[[nodiscard]] std::vector<MisplacedPipesTrial> try_misplaced_pipes(
    const MisplacedPipesSettings& settings, std::size_t trials, std::uint64_t seed);

/// One trial with these offsets of the file: each pipe of the file lies so far from its true place
/// along rack x, m, one entry per pipe.
[[nodiscard]] MisplacedPipesTrial try_misplaced_pipes(const MisplacedPipesSettings& settings,
                                                      std::span<const double> file_offsets,
                                                      std::uint64_t seed);

[[nodiscard]] MisplacedPipesScore score_misplaced_pipes(
    std::span<const MisplacedPipesTrial> trials);

}  // namespace pipescout::rack_study
