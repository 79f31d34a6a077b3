// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "distance_book.hpp"
#include "odometer_monitor.hpp"
#include "odometer_track.hpp"
#include "pipe_bends.hpp"
#include "pipescout/odometry/odometer_stream.hpp"
#include "turn_track.hpp"

namespace pipescout::odometry {

/// odometer_stream.cpp: samples, time, ticks. odometer_stream_fusion.cpp: what happens at a tick.
class OdometerStream::Implementation {
 public:
  explicit Implementation(OdometerStreamParameters parameters);

  SampleOutcome push(const OdometerSample& sample);
  void flush();
  void set_correction(std::size_t odometer, const OdometerCorrection& correction);
  void end_segment();
  void set_roll(double roll);
  void push_yaw_rate(double time, double rate) { turn_.push(time, rate); }
  [[nodiscard]] const FusedStream& state() const { return state_; }
  [[nodiscard]] const OdometerStreamParameters& parameters() const { return parameters_; }

 private:
  struct Wheel {
    internal::OdometerTrack track;
    internal::OdometerMonitor monitor;
    /// s, stamp of the last sample, usable or not
    double heard = -std::numeric_limits<double>::infinity();
    double scale = 1.0;
    double scale_variance = 0.0;
  };
  /// The stretch from one anchor to the next.
  struct Window {
    internal::WindowSum sum;
    std::array<double, kMaxOdometers> deviation{};  ///< m, of the increments
    OdometerSet spanning;                           ///< odometers with an increment over all of it
    OdometerSet usable;                             ///< of these, not left out for their health
    OdometerSet trusted;                  ///< of these, ok or worn: what a fallback is made of
    double median = 0.0;                  ///< m, of the usable increments
    OdometerSet drifted;                  ///< off over this window and its neighbours together
    double duration = 0.0;                ///< s
    internal::Explanation explanation{};  ///< with `FusionRule::kCircumference`
  };
  static constexpr std::size_t kMostWindows = 17;
  /// Closed windows [begin, end).
  struct Drift {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  struct Leap {
    double time = 0.0;
    std::size_t odometer = 0;
    int samples = 0;
  };

  SampleOutcome judge(const OdometerSample& sample);
  bool near_the_others(const OdometerSample& sample);
  void follow_leap(double time);
  void fuse_due();
  [[nodiscard]] bool awaited(const Wheel& wheel, std::int64_t tick) const;

  void fuse_tick(std::int64_t tick);
  void begin(std::int64_t tick);
  void read_increments(std::int64_t tick);
  ConsensusFusionResult fuse_window(Window& window) const;
  void agree(Window& window, const OdometerSet& members, double distance) const;
  static void average(Window& window);
  void weigh(Window& window) const;
  [[nodiscard]] internal::WheelSums sums_of(const Window& window) const;
  void judge_bends(double begin);
  void apply(const internal::BendFinder::Judgement& judgement);
  void fall_back(Window& window, const OdometerSet& chosen) const;
  void explain(const ConsensusFusionResult& result);
  void coast(double duration);
  [[nodiscard]] bool anchor_is_due(std::int64_t tick) const;
  void anchor(std::int64_t tick);
  void judge_window();
  [[nodiscard]] double median_of_usable(const std::array<double, kMaxOdometers>& values) const;
  void estimate_deviations();
  void look_back();
  [[nodiscard]] Drift find_drift(std::size_t odometer) const;
  void settle();
  void publish();

  OdometerStreamParameters parameters_;
  ConsensusFusion consensus_;
  std::vector<Wheel> wheels_;
  internal::DistanceBook book_;   ///< of what is past changing
  internal::DistanceBook ahead_;  ///< with the closed windows that can still change
  FusedStream state_;
  std::optional<internal::BendFinder> bends_;
  double roll_ = 0.0;  // rad
  internal::TurnTrack turn_;
  double heading_ = 0.0;         // rad, at the last fused tick
  double anchor_heading_ = 0.0;  // rad, at the anchor

  internal::TickGrid grid_;
  bool started_ = false;   // a sample has come
  bool anchored_ = false;  // there is a first anchor
  double newest_ = 0.0;    // s
  double origin_ = 0.0;    // s, stamp of the first sample, or of the first after a leap
  Leap leap_;
  std::int64_t next_ = 0;  // tick to fuse next
  double anchor_time_ = 0.0;
  Window window_;               ///< from the anchor to the last fused tick
  std::vector<Window> closed_;  ///< before it, oldest first
  OdometerSet drifting_;        ///< drifted up to the anchor
  bool window_open_ = false;    // something was fused since the anchor
};

}  // namespace pipescout::odometry
