// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "pipescout/tracking/shape_tracker.hpp"
#include "pipescout/tracking_study/recording.hpp"

/// The tracking beside the truth: Ibarguren and others (2013), section 7.2.
namespace pipescout::tracking_study {

/// Mean and standard deviation of values that are not kept.
class Moments {
 public:
  void add(double value);
  Moments& operator+=(const Moments& other);
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] double mean() const noexcept;       ///< NaN without values
  [[nodiscard]] double deviation() const noexcept;  ///< of the values as a whole; NaN without

 private:
  std::size_t count_ = 0;
  double sum_ = 0;
  double squares_ = 0;
};

/// 95 % interval of the standard deviation of values that come in sequences, by the bootstrap over
/// sequences (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, sections 8.3 and 13.3):
/// errors of one sequence have a cause in common, so that a few of them decide the deviation. NaN
/// without values.
struct DeviationInterval {
  double low = 0;
  double high = 0;
};
[[nodiscard]] DeviationInterval deviation_interval(std::span<const Moments> sequences,
                                                   std::uint64_t seed);

/// Absolute errors of an estimate, against the section in view.
struct EstimateErrors {
  Moments position{};  ///< px, of the middle
  Moments angle{};     ///< degrees
  Moments length{};    ///< px

  void add(const tracking::PipeShape::State& estimate, const tracking::PipeShape::State& truth);
  EstimateErrors& operator+=(const EstimateErrors& other);
};

enum Estimate : std::size_t { kBestParticle, kRobustMean, kWeightedMean, kOurs };
inline constexpr std::size_t kEstimates = 4;

struct TrackingScore {
  /// Of pictures from the first lock on in which the tube is in view and the track not lost, those
  /// in gaps included.
  std::array<EstimateErrors, kEstimates> errors{};
  EstimateErrors in_gaps{};  ///< of ours, in pictures without anything
  std::size_t pictures = 0;
  /// Times that a track in view was not on the tube for a second: it is not locked, or farther from
  /// its axis than 10 px, or the number has changed. Gaps do not count into the second.
  std::size_t lost_tracks = 0;

  TrackingScore& operator+=(const TrackingScore& other);
};

struct TrackingSettings {
  tracking::PipeShape shape{};
  tracking::PipeTrackerParameters tracker{};
  bool odometry = true;  ///< the motion of the camera is told

  /// Sections below this are at the border, where there is no telling, px.
  static constexpr double kLeastLength = 40;
};

[[nodiscard]] TrackingScore score_tracking(const Recording& recording,
                                           const TrackingSettings& settings, std::uint64_t seed);

/// The paper's particle filter alone, section 6.2: it starts at the longest section in view, moves
/// all particles by what its robust mean moved by in the picture before (equation (10)) and weighs
/// them by the nearest section (equation (14)). It starts again when its robust mean has left the
/// image, of which the paper says nothing. No Kalman filter, no data association, and it is
/// told nothing of the camera's motion. Scored from the start on; `kOurs` has no values.
[[nodiscard]] TrackingScore score_paper_filter(const Recording& recording,
                                               const TrackingSettings& settings,
                                               std::uint64_t seed);

/// What is to be tracked next: for whoever drives the tracker over a recording himself.
[[nodiscard]] tracking::TrackingFrame<tracking::PipeShape> frame_of(
    const Recording& recording, const RecordedPicture& picture, const tracking::PipeTrack& track,
    bool odometry);

/// A row of the paper's Table 1.
struct TableRow {
  std::string_view name;
  std::size_t particles;
  Estimate estimate;
  double position_mean, position_deviation;  ///< px
  double angle_mean, angle_deviation;        ///< degrees
  double length_mean, length_deviation;      ///< px

  /// Mean errors are no greater than these.
  [[nodiscard]] bool covers(const EstimateErrors& errors) const;
  /// The same of their standard deviations.
  [[nodiscard]] bool covers_deviations(const EstimateErrors& errors) const;
};
inline constexpr std::array<TableRow, 6> kTableOne{{
    {"best particle, 500", 500, kBestParticle, 1.80, 1.27, 0.96, 0.86, 3.16, 2.58},
    {"best particle, 1000", 1000, kBestParticle, 1.42, 0.95, 0.72, 0.63, 2.94, 2.51},
    {"robust mean of 10, 500", 500, kRobustMean, 1.82, 2.11, 0.51, 0.41, 2.86, 5.35},
    {"robust mean of 10, 1000", 1000, kRobustMean, 1.57, 1.83, 0.41, 0.34, 2.65, 5.66},
    {"weighted mean, 500", 500, kWeightedMean, 6.34, 5.39, 0.43, 0.36, 3.67, 7.68},
    {"weighted mean, 1000", 1000, kWeightedMean, 6.11, 4.67, 0.35, 0.38, 3.45, 6.64},
}};

}  // namespace pipescout::tracking_study
