// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/mission_tables/error_histogram.hpp"
#include "pipescout/mission_tables/true_track.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::summary {

/// Report of a run of an estimator: its pose errors if the truth is known, their consistency with
/// the covariance, and the statistics of each source. Bounded in memory for any length of the run.
/// Pure; not thread-safe.
class EstimatorReport {
 public:
  struct Estimate {
    Time stamp{};
    geometry::SE3 T_map_base;
    /// Over (x, y, z, rotation about the fixed axes x, y, z of the map), m and rad; positive
    /// definite.
    geometry::Matrix6d covariance = geometry::Matrix6d::Identity();
    /// Whether it is in the recording; then its error is recorded too.
    bool recorded = false;
  };
  /// Of an estimate against the truth at its stamp.
  struct Error {
    /// Estimate minus truth, m, and the rotation from the true to the estimated orientation about
    /// the fixed axes of the map, rad.
    geometry::Vector6d error = geometry::Vector6d::Zero();
    /// Its square in units of the covariance (normalised estimation error squared): of the
    /// position, 3 on average when the covariance is right, and of the pose, 6.
    double position_nees = 0;
    double pose_nees = 0;
  };
  using UseError = std::function<void(const Estimate&, const Error&)>;
  using State = pipescout_msgs::msg::EstimatorState;

  /// `use` gets the error of each estimate once its truth is known.
  explicit EstimatorReport(UseError use) : use_(std::move(use)) {}

  /// In any order: of estimates without a truth yet the last 1024 wait for it.
  void add_estimate(const Estimate& estimate);
  void add_truth(Time stamp, const geometry::SE3& T_map_base);
  /// Returns the rows of the sources that are new or whose state has changed. No more than the
  /// first 32 names of sources are followed. The lists of sources are of one length. Not checked.
  [[nodiscard]] std::vector<std::size_t> add_state(const State& state);

  [[nodiscard]] std::uint64_t estimates() const noexcept { return estimates_; }
  [[nodiscard]] std::uint64_t keyframes() const noexcept { return keyframes_; }

  /// Title, table, figures and notes. `figure_prefix` comes before the names of the figures:
  /// "robot_1." or nothing.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  /// A count that begins anew when the estimator is started again.
  class Count {
   public:
    void said(std::uint64_t value) noexcept {
      total_ += value >= last_ ? value - last_ : value;
      last_ = value;
    }
    [[nodiscard]] std::uint64_t total() const noexcept { return total_; }

   private:
    std::uint64_t total_ = 0;
    std::uint64_t last_ = 0;
  };
  struct Source {
    std::string state;
    Count accepted;
    Count gated;
    Count held;
    Count refused;
    std::uint64_t trusted = 0;  // of the keyframes
  };

  void follow_phase(const State& state);
  void compare(const Estimate& estimate, const geometry::SE3& truth);
  void add_error_figures(const std::function<void(const std::string&, double)>& set) const;
  void add_table(MissionSection& section) const;
  void add_notes(MissionSection& section) const;

  UseError use_;
  TruthPairing<Estimate> pairing_;
  std::uint64_t estimates_ = 0;
  ErrorHistogram position_;
  ErrorHistogram orientation_;
  std::uint64_t in_ellipsoid_ = 0;
  double sum_of_position_nees_ = 0;
  double sum_of_pose_nees_ = 0;

  std::uint64_t keyframes_ = 0;
  std::optional<Time> first_state_;
  std::optional<Duration> until_running_;
  std::string waits_for_;
  Count restarts_;
  std::string restart_reason_;
  std::map<std::string, Source> sources_;
};

}  // namespace pipescout::summary
