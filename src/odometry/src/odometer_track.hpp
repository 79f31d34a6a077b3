// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry::internal {

/// Tick k is at origin + k * period.
struct TickGrid {
  double origin = 0.0;  ///< s
  double period = 1.0;  ///< s

  [[nodiscard]] double time(std::int64_t tick) const {
    return origin + static_cast<double>(tick) * period;
  }
  /// The last tick that is not after `time`. A stamp that misses its tick by rounding is on it.
  [[nodiscard]] std::int64_t at(double time) const;
};

/// Where an odometer was at a tick. Positions of one epoch differ by the distance between them;
/// from one epoch to the next, distance may be missing.
struct TickMark {
  std::int64_t tick = -1;
  std::uint32_t epoch = 0;
  double position = 0.0;  ///< m, corrected
  double measured = 0.0;  ///< m, not corrected
  double path = 0.0;      ///< m, never decreases
};

/// One odometer's samples, made into positions at ticks: counter arithmetic, gaps, interpolation.
class OdometerTrack {
 public:
  /// Ticks that can be marked and not yet fused.
  static constexpr std::int64_t kRing = 64;

  OdometerTrack(const OdometerParameters& parameters, const OdometerStreamParameters& stream);

  /// A sample whose stamp is near those of the others. When accepted, the ticks from
  /// `first_tick()` to `last_tick()` can be marked.
  SampleOutcome take(double time, double value, const TickGrid& grid);

  /// A sample that could not be used came: of an incremental odometer, distance is lost with it.
  void note_unusable();

  /// The clocks were set: what came before happened one period before `time`, at ticks below
  /// `next`.
  void resume(double time, double leap, std::int64_t next);

  [[nodiscard]] std::int64_t first_tick() const { return first_tick_; }
  [[nodiscard]] std::int64_t last_tick() const { return last_tick_; }
  void mark(std::int64_t tick, const TickGrid& grid);

  /// nullptr when the odometer has no position for the tick.
  [[nodiscard]] const TickMark* at(std::int64_t tick) const;

  /// Distances count from this tick on; from when it is known, if it is not known yet.
  void set_anchor(std::int64_t tick);
  /// Whether all distance from the anchor to the mark is known.
  [[nodiscard]] bool spans(const TickMark& mark) const {
    return anchor_.tick >= 0 && anchor_.epoch == mark.epoch;
  }
  [[nodiscard]] const TickMark& anchor() const { return anchor_; }
  [[nodiscard]] std::int64_t anchor_wanted() const { return anchor_wanted_; }

  void set_scale(double scale) { scale_ = scale; }
  [[nodiscard]] bool started() const { return started_; }
  [[nodiscard]] double time() const { return time_; }  ///< s, of the last accepted sample
  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }

 private:
  struct Step {
    double distance = 0.0;  ///< m, raw
    bool known = true;      ///< false: distance is missing
    bool plausible = true;
  };
  [[nodiscard]] Step step_of(double time, double value) const;
  void begin_epoch();

  OdometerKind kind_;
  double wrap_;
  double period_;
  double maximum_gap_;
  double maximum_speed_;
  double tick_period_;
  double window_distance_;
  double scale_;

  bool started_ = false;
  bool resumed_ = false;  // the clocks were set since the last sample
  bool lost_ = false;     // increments were lost since the last sample
  double leap_ = 0.0;     // s, by which the clocks were set
  double value_ = 0.0;    // m, of the counter
  double time_ = 0.0;
  double position_ = 0.0;
  double measured_ = 0.0;
  double path_ = 0.0;
  double marked_position_ = 0.0;
  double before_time_ = 0.0;
  double before_position_ = 0.0;
  double before_measured_ = 0.0;
  std::uint32_t epoch_ = 0;
  std::uint64_t gaps_ = 0;
  std::int64_t first_tick_ = 0;
  std::int64_t last_tick_ = -1;
  std::int64_t anchor_wanted_ = -1;
  TickMark anchor_;
  std::array<TickMark, kRing> ring_{};
};

}  // namespace pipescout::odometry::internal
