// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// A pipe of welded joints: their true lengths, the tally of the construction, and its centre line
/// with bends and slopes. Metres and radians; x east, y north, z up; chainage is the distance along
/// the centre line from the first weld. The same seed gives the same bits.
namespace pipescout::simulation {

struct JointedPipeParameters {
  std::size_t joints = 100;     ///< [1, 1e6]
  double joint_length = 12.0;   ///< m, > 0, mean
  double length_spread = 0.01;  ///< [0, 0.3]: standard deviation / mean, cut off at 3
  double tally_sigma = 0.005;   ///< m, [0, 0.1 * joint_length]: of every length in the tally
  double tally_wrong = 0.0;     ///< [0, 1]: share of lengths with a gross error
  /// m, (0, 0.3 * joint_length]: largest gross error; the smallest is half of it
  double tally_wrong_by = 1.0;
  double tally_missing = 0.0;                ///< [0, 1]: share of joints missing from the tally
  double tally_extra = 0.0;                  ///< [0, 1]: share of entries without a joint
  double bend_share = 0.05;                  ///< [0, 1]: of joints that are bends, level
  double largest_bend = 1.5707963267948966;  ///< (0, pi]: change of heading, at least a tenth of it
  double slope_share = 0.05;                 ///< [0, 1]: of joints over which the slope changes
  double largest_slope = 0.2617993877991494;  ///< [0, 1.5]: pitch, up or down

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class TallyError : std::uint8_t { kNone, kWrongLength, kExtra };

struct TallyEntry {
  double length = 0.0;  ///< m, as recorded
  TallyError error = TallyError::kNone;
  std::size_t joint = 0;  ///< whose length it is; of an extra one: the joint that follows
};

struct Joint {
  double begin = 0.0;   ///< m, chainage of its first weld
  double length = 0.0;  ///< m
  bool in_tally = true;
  std::array<double, 3> position{};  ///< m, of its first weld
  double heading = 0.0;              ///< rad, at its first weld, from x to y
  double pitch = 0.0;                ///< rad, at its first weld, upwards
  double heading_rate = 0.0;         ///< rad/m over the joint; at most one of the rates is not 0
  double pitch_rate = 0.0;           ///< rad/m over the joint
};

class JointedPipe {
 public:
  /// Throws what `JointedPipeParameters::validate` throws.
  JointedPipe(const JointedPipeParameters& parameters, std::uint64_t seed);
  /// A pipe consistent with this tally, lengths in m: each true length deviates with the standard
  /// deviation `tally_sigma`. Only this parameter and those of bends and slopes are used. Throws
  /// std::invalid_argument too when the tally is empty or a length is not above 10 `tally_sigma`.
  JointedPipe(const JointedPipeParameters& parameters, std::span<const double> tally,
              std::uint64_t seed);

  [[nodiscard]] const std::vector<Joint>& joints() const noexcept { return joints_; }
  [[nodiscard]] const std::vector<TallyEntry>& tally() const noexcept { return tally_; }
  [[nodiscard]] double length() const noexcept { return length_; }

  /// Index of the joint at a chainage; the first or last one beyond the ends.
  [[nodiscard]] std::size_t joint_at(double chainage) const noexcept;
  /// On the centre line, exact arcs; straight on beyond the last weld, back before the first.
  [[nodiscard]] std::array<double, 3> position(double chainage) const noexcept;
  [[nodiscard]] double heading(double chainage) const noexcept;
  [[nodiscard]] double pitch(double chainage) const noexcept;

 private:
  void lay(const JointedPipeParameters& parameters, std::span<const double> lengths,
           std::uint64_t seed);
  void write_tally(const JointedPipeParameters& parameters, std::uint64_t seed);

  std::vector<Joint> joints_;
  std::vector<TallyEntry> tally_;
  double length_ = 0.0;
};

}  // namespace pipescout::simulation
