// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
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

/// One leak, or what may be one: the finding, and what has been seen of it in the pass that goes
/// on.
class Follow {
 public:
  Finding finding{};
  double log_odds = 0;
  double event_time = -std::numeric_limits<double>::infinity();  ///< of the latest event
  bool news = false;                                             ///< something has changed since
  bool taken = false;  ///< has an observation in this frame

  /// Whether a pass goes on at that time.
  [[nodiscard]] bool in_pass(double time, const LeakFindingsParameters& p) const {
    return frames_ > 0 && time - finding.last_time <= p.pass_gap;
  }
  /// In the map, from the pass that goes on; nothing before a bearing was seen.
  [[nodiscard]] const PlaceEstimate& place() const { return place_; }
  [[nodiscard]] const Eigen::Vector2d& pixel() const { return pixel_; }
  /// Pixels: where it is in the picture when it moves on as it did.
  [[nodiscard]] Eigen::Vector2d pixel_at(double time) const {
    return pixel_ + (time - finding.last_time) * velocity_;
  }
  [[nodiscard]] bool has_velocity() const { return has_velocity_; }

  /// Takes an observation in. Begins another pass when none goes on.
  void add(const Frame& frame, const Observation& observation, const std::optional<Eye>& eye,
           const Observer& observer, const geometry::Camera& camera,
           const LeakFindingsParameters& p);
  /// Takes in what another has seen of the same leak.
  void absorb(const Follow& other, const LeakFindingsParameters& p);

 private:
  void begin_pass(double time, const LeakFindingsParameters& p);
  void summarise(const LeakFindingsParameters& p);
  void place_finding(PassSummary& pass, const LeakFindingsParameters& p);
  void find_growth();

  std::size_t frames_ = 0;  // of this pass
  PlaceEstimate place_{};
  int line_ = -1;
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  // sum
  Eigen::Vector3d ray_ = Eigen::Vector3d::UnitX();       // the latest
  std::optional<MapPosition> past_{};                    // from passes before
  Eigen::Vector2d pixel_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();  // pixels/s
  bool has_velocity_ = false;
  RunningMean delta_{};  // of whole views
  RunningMean partial_delta_{};
  RunningMean peak_{};
  double largest_peak_ = 0;
  RunningMean length_{};
};

}  // namespace pipescout::leak_findings
