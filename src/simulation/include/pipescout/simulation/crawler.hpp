// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "pipescout/simulation/jointed_pipe.hpp"
#include "pipescout/simulation/motion.hpp"
#include "pipescout/simulation/pipe_fittings.hpp"

/// A crawler in a pipe and the readings of its odometer wheels, with ground truth.
///
/// A wheel turns by  integral of (1 + scale_error + wear_per_metre * path) * (1 - slip(path)) * (1
/// - gravity_slip * sin(slope in the direction of travel))  over the distance, plus noise; its
/// reading is quantised to its resolution. Path is the distance travelled in either direction. With
/// `CrawlerParameters::fittings` the distance is that of the wheel's own line on the wall.
/// Metres and seconds. The same seed gives the same bits.
namespace pipescout::simulation {

struct WheelParameters {
  bool incremental = false;  ///< reports the distance since its previous sample, also a dropped one
  double period = 0.02;      ///< s, > 0, between samples
  double start = 0.0;        ///< s, >= 0, of its first sample
  double resolution = 0.001;          ///< m, > 0
  double counter_start = 0.0;         ///< m, initial reading of an absolute counter
  double scale_error = 0.0;           ///< [-0.3, 0.3]: relative error of the radius
  double wear_per_metre = 0.0;        ///< 1/m, [-1e-3, 1e-3]: drift of the scale along the path
  double noise_per_sqrt_metre = 0.0;  ///< m per square root of metre, >= 0: random walk
  double gravity_slip = 0.0;          ///< [0, 0.5]: reading decreases uphill, increases downhill
  double dropped_share = 0.0;         ///< [0, 1]: share of samples that are dropped
  double nan_share = 0.0;             ///< [0, 1]: share of samples that are NaN
  double clock = 0.0;  ///< rad around the axis, clockwise from the crawler's top, looking forward
  double ahead = 0.0;  ///< m, [-10, 10]: of the crawler's centre, along the axis
};

struct CrawlerParameters {
  std::vector<WheelParameters> wheels{};  ///< 1 to 64
  double slip_spacing = 0.0;  ///< m, >= 0: mean path between bursts of slip, of all wheels; 0: none
  double slip_shortest = 1.0;        ///< m, > 0
  double slip_longest = 10.0;        ///< m, >= slip_shortest
  double slip_least = 0.05;          ///< [0, 1]: share of the distance that is lost
  double slip_most = 0.3;            ///< [slip_least, 1]
  double slip_together_share = 0.0;  ///< [0, 1]: share of bursts in which two wheels slip equally
  double stick_spacing = 0.0;        ///< m, >= 0: mean path between sticks; 0: none
  double stick_shortest = 0.5;       ///< m, > 0
  double stick_longest = 5.0;        ///< m, >= stick_shortest
  /// Positions in it are the distance of the motion; nothing: the pipe is straight to the wheels.
  std::optional<PipeFittings> fittings{};
  double roll = 0.0;            ///< rad, of the crawler at distance 0, clockwise
  double roll_per_metre = 0.0;  ///< rad/m

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class WheelFaultKind : std::uint8_t { kSlip, kStick };

/// From path `begin` on, for `length`, the reading of a wheel is (1 - ratio) times the distance.
struct WheelFault {
  WheelFaultKind kind = WheelFaultKind::kSlip;
  std::size_t wheel = 0;
  double begin = 0.0;   ///< m of path
  double length = 0.0;  ///< m of path
  double ratio = 0.0;   ///< 1 for a stick
};

/// A sample and the truth at its time.
struct WheelSample {
  std::size_t wheel = 0;
  double time = 0.0;                                        ///< s
  double value = std::numeric_limits<double>::quiet_NaN();  ///< m
  double distance = 0.0;                                    ///< m, true chainage
  double path = 0.0;                                        ///< m
  double speed = 0.0;                                       ///< m/s
};

class Crawler {
 public:
  /// Starts at the first weld. Faults are random: one at a time, except for bursts of two wheels
  /// together. Throws what `CrawlerParameters::validate` throws.
  Crawler(JointedPipe pipe, Motion motion, CrawlerParameters parameters, std::uint64_t seed);
  /// With given faults instead; they may overlap, and are then multiplied. Throws also when the
  /// wheel of one does not exist, or its length or ratio is not in [0, inf) or [0, 1].
  Crawler(JointedPipe pipe, Motion motion, CrawlerParameters parameters, std::uint64_t seed,
          std::vector<WheelFault> faults);

  /// The next sample of any wheel in the order of time, wheels in their order at equal times; none
  /// when the motion is over.
  [[nodiscard]] std::optional<WheelSample> next();

  [[nodiscard]] const std::vector<WheelFault>& faults() const noexcept { return faults_; }
  [[nodiscard]] const JointedPipe& pipe() const noexcept { return pipe_; }
  [[nodiscard]] const Motion& motion() const noexcept { return motion_; }
  /// Times at which the crawler first passes each weld that it reaches, s.
  [[nodiscard]] std::vector<double> weld_times() const;

 private:
  struct Wheel {
    std::mt19937_64 noise;
    std::mt19937_64 channel;           // drops and NaN
    std::vector<WheelFault> faults{};  // of this wheel, by begin
    std::size_t first_fault = 0;       // that has not ended
    std::uint64_t sent = 0;            // samples, dropped ones too
    double time = 0.0;                 // s, up to which it has turned
    double turned = 0.0;               // m
    double shown = 0.0;                // m, at its last delivered sample
  };

  /// Path [from, to] in one direction, which begins at `distance` and goes `direction` = 1 or -1.
  struct Stretch {
    double from = 0.0;
    double to = 0.0;
    double distance = 0.0;
    double direction = 1.0;
  };

  void draw_faults(std::uint64_t seed);
  void start(std::uint64_t seed);
  [[nodiscard]] double due(std::size_t wheel) const;
  void turn(std::size_t wheel, double time);
  [[nodiscard]] double turning(const WheelParameters& parameters, const Wheel& wheel,
                               const Stretch& stretch) const;

  JointedPipe pipe_;
  Motion motion_;
  CrawlerParameters parameters_;
  std::vector<WheelFault> faults_;
  std::vector<Wheel> wheels_;
};

}  // namespace pipescout::simulation
