// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "pipescout/odometry/odometer_stream.hpp"

/// Estimation of scale and offset of every odometer from known distances between welds. Section 4
/// of Wang, Cao, Luan and Zhang (Robot 30(3), 2008) has constants for them, "compensation from
/// prior knowledge" (0.18, 0.155, 0.165 m on 5.5 m).
///
/// From weld to weld: true length = scale * measured length + offset. Recursive least squares per
/// odometer with a scale that drifts (wear). An outlier (slip) gets a low weight; after several in
/// a row the odometer itself has changed, and its estimation is restarted. If all lengths are
/// equal, scale and offset are not separately observable: the covariance contains that, and scale *
/// length + offset is still precise.
///
/// Metres. Deterministic; bounded memory; nothing allocates unless it throws.
namespace pipescout::odometry {

struct OdometerCalibrationParameters {
  double initial_scale = 1.0;                      ///< [0.5, 2]
  double initial_scale_standard_deviation = 0.02;  ///< (0, 0.5]
  double initial_offset = 0.0;                     ///< m, finite
  double initial_offset_standard_deviation = 0.2;  ///< m, >= 0; 0: the offset is known
  double scale_drift = 4e-9;  ///< random walk of the scale, variance per metre; [0, 1e-4]
  /// Standard deviations beyond which a measurement loses weight; [1, 10]. Its variance is then
  /// multiplied by the square of the ratio of the residual to that limit.
  double gate = 3.0;
  std::size_t change_after = 8;  ///< outliers in a row that indicate a change; >= 2

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Measurement of an odometer between two welds of known distance.
struct WeldSpacing {
  double measured = std::numeric_limits<double>::quiet_NaN();                     ///< m, raw, > 0
  double measured_standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, >= 0
  double length = std::numeric_limits<double>::quiet_NaN();                       ///< m, true, > 0
  /// m, >= 0, of `length` and of the detection of both welds. The two must not both be 0.
  double length_standard_deviation = std::numeric_limits<double>::quiet_NaN();
};

enum class CalibrationOutcome : std::uint8_t {
  kUsed = 0,
  kFarOff = 1,    ///< outlier, used with low weight
  kChanged = 2,   ///< the last of `change_after` outliers: estimation restarted
  kBadValue = 3,  ///< not used
};

class OdometerCalibration {
 public:
  struct Counts {
    std::uint64_t used = 0;
    std::uint64_t far_off = 0;
    std::uint64_t changes = 0;
    std::uint64_t bad_values = 0;
  };

  /// Throws std::invalid_argument when there are not 2 to 16 odometers, and what `validate` throws.
  OdometerCalibration(OdometerCalibrationParameters parameters, std::size_t odometers);

  /// Invalid values are counted and are not an error. Throws std::out_of_range when there is no
  /// such odometer.
  CalibrationOutcome observe(std::size_t odometer, const WeldSpacing& spacing);

  /// For `OdometerStream`; the initial values until the first observation. Throws std::out_of_range
  /// when there is no such odometer.
  [[nodiscard]] const OdometerCorrection& correction(std::size_t odometer) const;
  [[nodiscard]] const Counts& counts(std::size_t odometer) const;
  [[nodiscard]] std::size_t odometers() const noexcept { return odometers_; }

 private:
  struct Track {
    OdometerCorrection correction;
    Counts counts;
    std::size_t far_off_in_a_row = 0;
  };

  [[nodiscard]] const Track& track(std::size_t odometer) const;

  OdometerCalibrationParameters parameters_;
  std::size_t odometers_;
  std::array<Track, kMaxOdometers> tracks_;
};

/// For messages: "used", "far off", "changed", "bad value"; "unknown" for any other value.
[[nodiscard]] const char* to_string(CalibrationOutcome outcome) noexcept;

}  // namespace pipescout::odometry
