// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry::internal {

/// What the wheels on the circumference say of a stretch of the pipe: the sums over its windows.
struct WheelSums {
  OdometerSet wheels;                             ///< that have an increment in all of it
  std::array<double, kMaxOdometers> increment{};  ///< m
  std::array<double, kMaxOdometers> random{};     ///< m^2, variance that grew with the path
  double travelled = 0.0;                         ///< m, median
  double duration = 0.0;                          ///< s

  void add(const WheelSums& other);
};

/// A bend that began before a stretch and may go on in it.
struct BendBefore {
  bool known = false;
  Eigen::Vector2d ratio = Eigen::Vector2d::Zero();  ///< bend vector over distance
  double deviation = 0.0;                           ///< of a component
};

/// Why the increments of a stretch differ, as probabilities; their sum is 1.
struct Explanation {
  double straight = 1.0;                      ///< by their noise
  double bend = 0.0;                          ///< by a bend of the pipe
  std::array<double, kMaxOdometers> fault{};  ///< by one wheel that slips or is stuck
  std::array<double, kMaxOdometers> both{};   ///< by a bend and a fault of this wheel
  BendBefore before{};                        ///< the bend of `both`, when it began before
  bool consistent = true;                     ///< false: none of these explains them
};

struct BendWeights {
  std::array<double, kMaxOdometers> weight{};  ///< sum 1
  double distance = 0.0;                       ///< m, weighted sum of the increments
  /// m, standard deviation by what is not known: which explanation holds, and the clock positions.
  /// It has the same sign in all windows of a stretch.
  double bias = 0.0;
};

/// Wheels on the circumference of a pipe. In a bend of angle theta towards the direction b, the
/// wheel at the clock position c goes  d - r theta cos(c - b)  where the axis goes d: linear in d
/// and in the bend vector k = r theta (cos b, sin b). Three wheels give the three unknowns and
/// leave nothing to tell a slip from a bend but what pipes and slips are like, so that explanations
/// are weighed by their marginal likelihood:
/// - straight: all wheels go d;
/// - bend: direction uniform; angle up to pi, those of standard elbows more likely; not tighter
/// than
///   `tightest_bend`;
/// - fault of wheel i: the others go d, this one loses any share of it;
/// - both: of four wheels or more, or within a bend whose curvature is known from before.
/// A slip of wheel i looks like a bend exactly towards i: a bend in another direction is certain,
/// one in such a direction is ambiguous and has the speed left to decide: that of the crawler does
/// not change where a bend or a slip begins or ends more than elsewhere, unless the crawler is
/// slower all through it.
class Circumference {
 public:
  explicit Circumference(const OdometerStreamParameters& parameters);

  /// Speeds next to the stretch, m/s, and its own ends; a duration of 0: not known.
  struct Speeds {
    double before = 0.0;
    WheelSums first{};
    double after = 0.0;
    WheelSums last{};
    double spread = 0.1;  ///< typical change of the logarithm of the speed between windows
  };

  /// `complete`: the whole bend is in the sums. Needs 3 wheels; with fewer it says straight.
  [[nodiscard]] Explanation explain(const WheelSums& sums, const Speeds& speeds,
                                    const BendBefore& before, bool complete) const;

  /// `deviations`: m, of the increments.
  [[nodiscard]] BendWeights weigh(const Explanation& explanation, const WheelSums& sums,
                                  const std::array<double, kMaxOdometers>& deviations) const;

  struct Vector {
    Eigen::Vector2d value = Eigen::Vector2d::Zero();  ///< m, k
    double deviation = 0.0;                           ///< m, of a component
  };
  /// Least squares over all wheels.
  [[nodiscard]] Vector bend_vector(const WheelSums& sums) const;
  /// Without the wheel whose fault explains the sums with a bend.
  [[nodiscard]] Vector bend_vector(const WheelSums& sums, const Explanation& explanation) const;

  /// Relative to the scale of the odometer.
  void set_scale_variance(std::size_t odometer, double variance) noexcept {
    scale_variance_[odometer] = variance;
  }
  [[nodiscard]] double radius() const noexcept { return radius_; }
  /// Of the length of the bend vector to the distance: r / R of the tightest bend.
  [[nodiscard]] double largest_ratio() const noexcept { return largest_ratio_; }

 private:
  struct Model {
    double evidence = 0.0;  // logarithm
    double misfit = 0.0;    // chi-square
    std::array<double, kMaxOdometers> weight{};
    Eigen::Vector2d turn = Eigen::Vector2d::Zero();  // rad, of the crawler
    double distance = 0.0;                           // m
    double deviation = 0.0;                          // m, of the bend vector
    double slows_share = 0.0;                        // probability that the crawler is slower in it
  };

  [[nodiscard]] std::array<double, kMaxOdometers> precisions(const WheelSums& sums) const;
  [[nodiscard]] Model straight(const WheelSums& sums,
                               const std::array<double, kMaxOdometers>& precision) const;
  [[nodiscard]] Model bend(const WheelSums& sums,
                           const std::array<double, kMaxOdometers>& precision,
                           const BendBefore& before, bool complete) const;
  [[nodiscard]] Model fault(const WheelSums& sums,
                            const std::array<double, kMaxOdometers>& precision, std::size_t wheel,
                            bool complete) const;
  [[nodiscard]] Model bend_and_fault(const WheelSums& sums,
                                     const std::array<double, kMaxOdometers>& precision,
                                     std::size_t wheel, const BendBefore& before,
                                     bool complete) const;
  [[nodiscard]] static double spread_of(const BendBefore& before, const WheelSums& sums);
  [[nodiscard]] static double log_loss(double distance, double lost, double deviation);
  [[nodiscard]] Eigen::Matrix3d information(
      const OdometerSet& wheels, const std::array<double, kMaxOdometers>& precision) const;
  [[nodiscard]] double log_prior(double bend, double deviation, double travelled,
                                 bool complete) const;
  [[nodiscard]] std::optional<double> speed_change(const Model& model, const WheelSums& sums,
                                                   double beside) const;
  [[nodiscard]] double speed_evidence(const Model& model, const Speeds& speeds) const;

  std::size_t count_;
  std::array<Eigen::Vector3d, kMaxOdometers> rows_;     // of the linear model, (1, -cos c, -sin c)
  std::array<double, kMaxOdometers> counting_{};        // m^2
  std::array<double, kMaxOdometers> scale_variance_{};  // relative
  double radius_;
  double largest_ratio_;  // of the bend vector to the distance
  double clock_sigma_;
};

/// Follows the windows of a stream and gathers those that have one explanation, so that a bend or a
/// slip is judged as a whole.
class BendFinder {
 public:
  explicit BendFinder(const OdometerStreamParameters& parameters);

  [[nodiscard]] const Circumference& circumference() const noexcept { return circumference_; }
  [[nodiscard]] Circumference& circumference() noexcept { return circumference_; }

  /// Of a window that goes on: as part of the event that goes on, or by itself.
  [[nodiscard]] Explanation explain(const WheelSums& window) const;

  /// An explanation of `windows` windows, with `later` others behind them.
  struct Judgement {
    Explanation explanation{};
    std::size_t windows = 0;
    std::size_t later = 0;
  };
  struct Judgements {
    /// Of the events that ended before the window noted, in the order in which they hold: a later
    /// one may be of the same windows. The last one is of the event that the window belongs to.
    std::array<Judgement, 8> judged{};
    std::size_t judgements = 0;
    std::array<FoundBend, 4> found{};
    std::size_t bends = 0;

    void judge(const Judgement& judgement);
    void find(const std::optional<FoundBend>& bend);
  };
  /// A window that is complete, from the fused distance `begin` on.
  Judgements note(const WheelSums& window, double begin);

 private:
  /// A window and where it begins.
  struct PlacedWindow {
    WheelSums sums{};
    double begin = 0.0;  // m
  };
  // Of an event that may be divided: the longest elbows, in windows of half a diameter.
  static constexpr std::size_t kMostEventWindows = 24;

  struct Event {
    WheelSums sums{};
    std::size_t windows = 0;
    BendBefore before{};
    Circumference::Speeds speeds{};
    WheelSums inner{};  // without the first and the latest window, which may reach out of it
    WheelSums latest{};
    std::array<PlacedWindow, kMostEventWindows> all{};  // the first ones
    double spacing = 0.0;                               // m, of the latest window
    // Sums over the windows of the length of the bend vector, times the place, times its square.
    double mass = 0.0;    // m
    double moment = 0.0;  // m^2
    double second = 0.0;  // m^3
  };
  /// A bend, of one event or of several without a straight window between them.
  struct Passage {
    Eigen::Vector2d vector = Eigen::Vector2d::Zero();  // m
    double variance = 0.0;                             // m^2
    double mass = 0.0;                                 // m
    double moment = 0.0;                               // m^2
    double second = 0.0;                               // m^3
    double spacing = 0.0;                              // m
    double probability = 1.0;
  };

  [[nodiscard]] bool goes_on(const Event& event, const WheelSums& window) const;
  [[nodiscard]] BendBefore bend_of(const Event& event) const;
  [[nodiscard]] Explanation explain(const Event& event, bool complete) const;
  [[nodiscard]] std::size_t find_change(const Event& event) const;
  void join(const WheelSums& window, double begin);
  void finish(double speed_after, std::size_t later, Judgements& result);
  void divide(std::size_t first, double speed_after, std::size_t later, Judgements& result);
  [[nodiscard]] bool revise(const Event& event, const Explanation& explanation, std::size_t later,
                            Judgements& result);
  void start_event();
  void pass(const Event& event, const Explanation& explanation, Judgements& result);
  [[nodiscard]] std::optional<FoundBend> end_passage();

  Circumference circumference_;
  double smallest_bend_;
  std::optional<Event> event_;
  std::optional<Event> previous_;  // without a straight window to the event that goes on
  std::optional<Passage> passage_before_previous_;
  BendBefore before_;  // of the event before, when nothing straight is between
  std::optional<Passage> passage_;
  double last_speed_ = 0.0;  // m/s, of the last straight window; 0: none
  double speed_spread_;
};

}  // namespace pipescout::odometry::internal
