// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

/// Racks some of whose pipes have another height, direction and radius than the rack file has them,
/// on images.
namespace pipescout::rack_study {

struct ShapedPipesSettings {
  rack_vision::RackModel rack{};  ///< the true one
  World world = World::kRayCaster;
  /// What of the file is wrong, one sigma, and what a file that states it states. Normal, and at
  /// most two sigma. Pipes steeper than 45 degrees have no error of height.
  rack_vision::ShapeDeviation drawn{.height = 0.03, .direction = 0.006, .radius = 0.02};
  std::vector<std::size_t> pipes{1, 3};  ///< of which pipes; not of the first, which is 0
  double duration = 10;                  ///< s, of images, at 25 Hz
  double start_position = 0.01;   ///< m, one sigma, of the first pose; the localisation is told it
  double start_rotation = 0.005;  ///< rad
};

/// What `truth` is relative to `file`. Both have the same radii but for a sum.
[[nodiscard]] rack_vision::PipeShape shape_of(const rack_vision::Pipe& truth,
                                              const rack_vision::Pipe& file);

struct ShapedPipesTrial {
  std::vector<FrameScore> frames;
  std::vector<rack_vision::PipeShape> shapes;             ///< the truth, one per pipe of the rack
  std::vector<rack_vision::PipeShapeEstimate> estimates;  ///< after the last image
};

/// One flight, of which the seed draws the place, the errors of the file and the error of the first
/// pose. `told`: whether the file states the deviations (Pipe::shape_deviation); nothing else
/// depends on it. The same arguments give the same bits. Throws std::invalid_argument for a pipe
/// that the rack does not have, the first one, and deviations with which no valid file is drawn.
[[nodiscard]] ShapedPipesTrial try_shaped_pipes(const ShapedPipesSettings& settings, bool told,
                                                std::uint64_t seed);

struct ShapedPipesPair {
  ShapedPipesTrial told, not_told;
};

/// Both, on the same images, which are rendered once.
[[nodiscard]] ShapedPipesPair compare_shaped_pipes(const ShapedPipesSettings& settings,
                                                   std::uint64_t seed);

struct ShapedPipesScore {
  std::size_t trials = 0;
  std::size_t converged = 0;     ///< the last image has a pose that is not wrong
  std::size_t lost = 0;          ///< the last image has no pose
  std::size_t silent_wrong = 0;  ///< in some image a pose was wrong and its covariance denied it
  ImageFlightScore images{};     ///< all of them
  std::size_t shapes = 0;        ///< stated to be uncertain
  std::size_t shapes_found = 0;
  std::size_t values = 0;          ///< of the shapes found: height, two turns, radius
  std::size_t values_covered = 0;  ///< of them: the truth within 2.58 stated deviations

  ShapedPipesScore& operator+=(const ShapedPipesScore& other);
  /// m, root mean square over images with a pose; 0 without any.
  [[nodiscard]] double position_rms() const noexcept;
};

[[nodiscard]] ShapedPipesScore score_shaped_pipes(std::span<const ShapedPipesTrial> trials);

}  // namespace pipescout::rack_study
