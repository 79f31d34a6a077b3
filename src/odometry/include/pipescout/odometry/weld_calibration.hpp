// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipescout/odometry/odometer_calibration.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

/// Calibration of odometers by welds: stores the path of every odometer of a stream, and calibrates
/// the stream when the distance between two passed welds becomes known.
///
/// Metres, and seconds of the stream's time. Deterministic; memory is taken at construction.
namespace pipescout::odometry {

struct WeldCalibrationParameters {
  /// Offsets are calibrated only when their standard deviation is not 0, because the errors of
  /// wheels are proportional to the distance.
  OdometerCalibrationParameters calibration{.initial_offset_standard_deviation = 0.0};
  /// Stored ticks of the stream, [16, 1e6]: a weld passed before the oldest one is too old.
  std::size_t history = 8192;
  /// A correction is applied when scale or offset have changed by this much, [0, 0.1], or by the
  /// standard deviation of the scale: each change ends the window of the stream, which reduces
  /// precision.
  double least_change = 2e-4;
  /// (0, 0.5). An odometer is worn when its scale deviates more from its first estimate.
  double worn_tolerance = 0.01;
  double worn_release = 0.7;  ///< (0, 1): not worn any more below this share of the tolerance

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The known distance between the welds passed at two times.
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
  kTooOld = 2,         ///< not in the history: too old, or the odometers' time has jumped
  kSeveralJoints = 3,  ///< not used: calibration with offsets needs single joints
  kUneven = 4,  ///< not used: a bend, or a fault of a wheel, see `FusedStream::uneven_windows`
};

class WeldCalibration {
 public:
  /// Throws std::invalid_argument when there are not 2 to 16 odometers, and what `validate` throws.
  WeldCalibration(WeldCalibrationParameters parameters, std::size_t odometers);

  /// To be called with the state of the stream after each tick.
  void record(const FusedStream& state) noexcept;

  /// Calibrates the odometers that have no gap and were not rejected between the welds, and applies
  /// sufficiently changed corrections to `stream`, the stream of the `record` calls. With offsets
  /// it also ends the stream's segment. Never throws for a value of `spacing`.
  SpacingOutcome observe(const KnownSpacing& spacing, OdometerStream& stream);

  /// The latest estimate, applied or not. Throws std::out_of_range when there is no such odometer.
  [[nodiscard]] const OdometerCorrection& correction(std::size_t odometer) const;
  [[nodiscard]] bool is_worn(std::size_t odometer) const;

 private:
  struct Entry {
    double time = 0.0;
    std::uint64_t uneven_windows = 0;
    std::array<double, kMaxOdometers> measured{};
    std::array<std::uint64_t, kMaxOdometers> gaps{};
    std::array<std::uint64_t, kMaxOdometers> unsupported{};
  };
  struct Wear {
    double first_scale = std::numeric_limits<double>::quiet_NaN();
    bool worn = false;
  };

  [[nodiscard]] const Entry& entry(std::size_t k) const noexcept;  ///< from 0, the oldest
  /// The two entries around a time, and the interpolation fraction between them.
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
  std::vector<Entry> entries_;  // ring buffer
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<Wear, kMaxOdometers> wear_{};
};

/// For messages: "used", "bad value", "too old", "several joints", "uneven"; "unknown" for any
/// other value.
[[nodiscard]] const char* to_string(SpacingOutcome outcome) noexcept;

}  // namespace pipescout::odometry
