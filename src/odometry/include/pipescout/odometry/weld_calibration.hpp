// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipescout/odometry/odometer_calibration.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

/// Closes the loop from welds to odometers: keeps what every odometer of a stream has shown, and
/// when the distance between two welds that were passed becomes known, calibrates the stream by it.
///
/// Metres, and seconds of the stream's time. Deterministic; memory is taken at construction.
namespace pipescout::odometry {

struct WeldCalibrationParameters {
  /// Offsets are calibrated only when their standard deviation is not 0: wheels lose in proportion.
  OdometerCalibrationParameters calibration{.initial_offset_standard_deviation = 0.0};
  /// Ticks of the stream that are remembered, [16, 1e6]: a weld that was passed before is too old.
  std::size_t history = 8192;
  /// A correction is put into effect when scale or offset have changed by so much, [0, 0.1], or by
  /// the standard deviation of the scale: each change ends the window of the stream, which costs
  /// precision.
  double least_change = 2e-4;
  /// (0, 0.5). An odometer is worn when its scale is off the first that was known by more.
  double worn_tolerance = 0.01;
  double worn_release = 0.7;  ///< (0, 1): and no longer below this share of the tolerance

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The known distance between the welds that were passed at two times.
struct KnownSpacing {
  double from = std::numeric_limits<double>::quiet_NaN();                ///< s
  double to = std::numeric_limits<double>::quiet_NaN();                  ///< s
  double length = std::numeric_limits<double>::quiet_NaN();              ///< m, > 0
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, >= 0
  std::size_t joints = 1;  ///< between the two, >= 1; an offset counts once per joint
};

enum class SpacingOutcome : std::uint8_t {
  kUsed = 0,
  kBadValue = 1,       ///< not finite, not positive, times in the wrong order
  kTooOld = 2,         ///< the history does not hold it: too old, or the odometers' time has leapt
  kSeveralJoints = 3,  ///< not used: offsets are calibrated too, from single joints only
};

class WeldCalibration {
 public:
  /// Throws std::invalid_argument when there are not 2 to 16 odometers, and what `validate` throws.
  WeldCalibration(WeldCalibrationParameters parameters, std::size_t odometers);

  /// To be called with the state of the stream after each tick.
  void record(const FusedStream& state) noexcept;

  /// Calibrates the odometers that have counted all the way and were not rejected on it, and puts
  /// what has changed enough into effect in `stream`, the one that `record` was called for. With
  /// offsets it also ends the stream's segment. Never throws for a value of `spacing`.
  SpacingOutcome observe(const KnownSpacing& spacing, OdometerStream& stream);

  /// The latest, in effect or not. Throws std::out_of_range when there is no such odometer.
  [[nodiscard]] const OdometerCorrection& correction(std::size_t odometer) const;
  [[nodiscard]] bool is_worn(std::size_t odometer) const;

 private:
  struct Entry {
    double time = 0.0;
    std::array<double, kMaxOdometers> measured{};
    std::array<std::uint64_t, kMaxOdometers> gaps{};
    std::array<std::uint64_t, kMaxOdometers> unsupported{};
  };
  struct Wear {
    double first_scale = std::numeric_limits<double>::quiet_NaN();
    bool worn = false;
  };

  [[nodiscard]] const Entry& entry(std::size_t k) const noexcept;  ///< from 0, the oldest
  /// The two entries around a time, and the part of the way from the first to the second.
  struct Place {
    const Entry* before = nullptr;
    const Entry* after = nullptr;
    double share = 0.0;
    [[nodiscard]] double measured(std::size_t odometer) const noexcept;
  };
  [[nodiscard]] bool find(double time, Place& place) const noexcept;
  [[nodiscard]] bool is_effective(const OdometerCorrection& in_use,
                                  const OdometerCorrection& latest) const noexcept;
  void judge_wear(std::size_t odometer) noexcept;

  WeldCalibrationParameters parameters_;
  OdometerCalibration calibration_;
  std::vector<Entry> entries_;  // a ring
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<Wear, kMaxOdometers> wear_{};
};

/// For people: "used", "bad value", "too old", "several joints"; "unknown" for a value that is
/// none.
[[nodiscard]] const char* to_string(SpacingOutcome outcome) noexcept;

}  // namespace pipescout::odometry
