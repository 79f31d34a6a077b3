// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/rack_study/image_flight.hpp"

/// Starts and predictions that are wrong, on images: the tracker has to find the right pose or say
/// that it is lost.
namespace pipescout::rack_study {

struct WrongStartSettings {
  simulation::RackScene scene{};  ///< its seed is drawn from that of the trials
  rack_vision::RackTrackerParameters tracker{};
  double position_error = 0.05;                      ///< m, in a random direction
  double rotation_error = 5 * 0.017453292519943295;  ///< rad, about a random axis
  std::size_t images = 10;                           ///< after which it is judged
  /// Of predictions: what they say that they are off by, per axis. They are off by far more.
  double stated_position_deviation = 0.01;  ///< m
  double stated_rotation_deviation = 0.01;  ///< rad
};

enum class WrongStart : std::uint8_t {
  kFirstPose,   ///< the pose that the tracker is started with; its covariance is that of the error
  kPrediction,  ///< the motion since the image before, of a tracker that tracks
};

struct WrongStartTrial {
  WrongStart kind = WrongStart::kFirstPose;
  geometry::Vector6d start_error = geometry::Vector6d::Zero();  ///< form of FrameScore::error
  FrameScore last{};                                            ///< the last image's
};

struct WrongStartScore {
  std::size_t trials = 0;
  std::size_t converged = 0;  ///< a pose that is right
  std::size_t lost = 0;       ///< no pose
  /// A pose that is wrong, `is_wrong`, as its covariance admits: the truth is within the ellipsoid
  /// that should hold it in 99 of 100 cases.
  std::size_t admitted_wrong = 0;
  std::size_t silent_wrong = 0;  ///< a pose that is wrong, and its covariance denies it

  WrongStartScore& operator+=(const WrongStartScore& other) noexcept;
};

/// `trials` of each kind at one place of a flight over the rack, which the seed draws; they share
/// its images. The same arguments give the same bits.
[[nodiscard]] std::vector<WrongStartTrial> try_wrong_starts(const WrongStartSettings& settings,
                                                            std::size_t trials, std::uint64_t seed);

[[nodiscard]] WrongStartScore score_wrong_starts(std::span<const WrongStartTrial> trials) noexcept;

}  // namespace pipescout::rack_study
