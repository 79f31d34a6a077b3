// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "observation.hpp"
#include "pipescout/leak_findings/finding.hpp"
#include "place_estimate.hpp"

namespace pipescout::leak_findings {

/// Mean and deviation of values one after the other.
class RunningMean {
 public:
  void add(double value) {
    ++count_;
    const double before = value - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before * (value - mean_);
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// NaN without values.
  [[nodiscard]] double mean() const {
    return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : mean_;
  }
  /// Of the values, standard; 0 with one.
  [[nodiscard]] double deviation() const {
    return count_ < 2 ? 0 : std::sqrt(squares_ / static_cast<double>(count_ - 1));
  }
  /// Of their mean.
  [[nodiscard]] double mean_deviation() const {
    return count_ == 0 ? std::numeric_limits<double>::quiet_NaN()
                       : deviation() / std::sqrt(static_cast<double>(count_));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0;
  double squares_ = 0;
};

/// Where a leak is along its pipe, m from `origin`: what has been seen of it in the pass that goes
/// on. Its ends are seen at different times when it is longer than the picture.
struct Extent {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< unit
  double low = 0;                                    ///< of all that was seen of it
  double high = 0;
  std::array<bool, 2> known{};  ///< whether the lower and the upper end were seen
  std::array<double, 2> end{};  ///< where
  std::array<double, 2> variance{};
};

/// One leak, or what may be one: the finding, and what has been seen of it in the pass that goes
/// on.
class Follow {
 public:
  Finding finding{};
  double log_odds = 0;
  double persistence = 0;  ///< the part of them that is from being detected
  double event_time = -std::numeric_limits<double>::infinity();  ///< of the latest event
  bool news = false;                                             ///< something has changed since
  bool taken = false;  ///< has an observation in this frame
  /// Of the first frame with a pose since it was seen, while it has no place; and when that was.
  std::optional<Eye> next_eye{};
  double next_eye_time = 0;

  /// Whether a pass goes on at that time.
  [[nodiscard]] bool in_pass(double time, const LeakFindingsParameters& p) const {
    return frames_ > 0 && time - finding.last_time <= p.pass_gap;
  }
  /// In the map, of the middle of what was seen of it in the pass that goes on; nothing before a
  /// bearing was.
  [[nodiscard]] const PlaceEstimate& place() const { return pass_.place; }
  /// Of the lower and the upper end along the pipe, likewise.
  [[nodiscard]] const PlaceEstimate& end(std::size_t which) const { return pass_.ends[which]; }
  /// Of where the rise begins at either end, likewise.
  [[nodiscard]] const PlaceEstimate& onset(std::size_t which) const { return pass_.onsets[which]; }
  /// While there is a place.
  [[nodiscard]] Extent extent() const;
  [[nodiscard]] const Eigen::Vector2d& pixel() const { return pixel_; }
  /// Pixels: where it is in the picture when it moves on as it did.
  [[nodiscard]] Eigen::Vector2d pixel_at(double time) const {
    return pixel_ + (time - finding.last_time) * velocity_;
  }
  [[nodiscard]] bool has_velocity() const { return has_velocity_; }

  /// Takes an observation in. Begins another pass when none goes on.
  void add(const Frame& frame, const Observation& observation, const geometry::Camera& camera,
           const LeakFindingsParameters& p);
  /// Takes in what another has seen of the same leak.
  void absorb(const Follow& other, const LeakFindingsParameters& p);

 private:
  /// What belongs to one pass.
  struct Pass {
    PlaceEstimate place{};
    std::array<PlaceEstimate, 2> ends{};
    std::array<PlaceEstimate, 2> onsets{};
    int line = -1;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // sum
    Eigen::Vector3d ray = Eigen::Vector3d::UnitX();       // the latest
    Eigen::Vector3d anchor = Eigen::Vector3d::Zero();     // `low` and `high` count from here
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    RunningMean delta{};  // of whole views
    RunningMean partial_delta{};
    RunningMean peak{};
    // Of single frames: what the deviations are from is the same in all of them.
    RunningMean delta_deviation{};
    std::array<RunningMean, 2> delta_margins{};
    std::array<RunningMean, 2> peak_delta_margins{};
    double largest_peak = std::numeric_limits<double>::quiet_NaN();
  };

  void begin_pass(double time, const LeakFindingsParameters& p);
  void add_places(const Observation& observation, const LeakFindingsParameters& p);
  void add_on_pipe(PlaceEstimate& place, const Bearing& bearing, double gate) const;
  void summarise(const LeakFindingsParameters& p);
  void place_finding(PassSummary& pass, const LeakFindingsParameters& p);
  void find_growth();

  std::size_t frames_ = 0;  // of this pass
  Pass pass_{};
  std::optional<MapPosition> past_{};  // from passes before
  Eigen::Vector2d pixel_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();  // pixels/s
  bool has_velocity_ = false;
};

}  // namespace pipescout::leak_findings
