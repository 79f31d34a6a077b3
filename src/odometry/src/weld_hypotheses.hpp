// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "joint_chain.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {

/// What the odometer went since some moment.
struct OdometerTravel {
  double net = 0.0;       ///< m
  double path = 0.0;      ///< m, reversing counted as going
  double variance = 0.0;  ///< m^2, of net
};

/// A gross fault in a hypothesis's past that nobody has been told of yet.
struct SpacingFault {
  float slip = 0.0F;   ///< share of the weight that had an odometer fault
  float tally = 0.0F;  ///< share of the weight that met an error of the tally
  double error = 0.0;  ///< m, odometer less tally
  int age = 0;         ///< welds since
};

/// One explanation of all welds so far: a Gaussian over (offset from the anchor weld, scale).
struct WeldHypothesis {
  double weight = 0.0;
  double offset = 0.0;  ///< m along the pipe from weld `anchor`, chainage upwards
  double scale = 1.0;
  double p00 = 0.0;  ///< m^2
  double p01 = 0.0;  ///< m
  double p11 = 0.0;
  double net = 0.0;   ///< odometer m since the anchor passed
  double path = 0.0;  ///< likewise
  int direction = 1;  ///< chainage per odometer distance: 1 or -1
  int anchor = 0;     ///< weld matched last
  int lowest = 0;  ///< welds lowest..highest were seen or counted as missed; none: highest < lowest
  int highest = -1;
  int previous_anchor = -1;  ///< the one before, when this weld was matched; else -1
  double measured = 0.0;     ///< m between the two, before the weld was used
  double measured_variance = 0.0;
  double innovation = -1.0;     ///< squared and normalised, when the weld was as expected; else -1
  double odometer_share = 0.0;  ///< of the innovation's variance that the odometer noise makes up
  SpacingFault fault;

  void predict(const OdometerTravel& travel, double scale_drift);
};

/// All hypotheses, and the weight of the crawler being anywhere ("lost").
class WeldHypotheses {
 public:
  /// `with_lost`: the pipe has a tally, so that a place in it can be recognised.
  WeldHypotheses(const WeldPositioningParameters& parameters, const JointChain& chain,
                 const WeldPositioningStart& start, std::span<const TallyBend> bends,
                 bool with_lost);

  /// A weld passed `travel` after the last one. False: nothing could explain it.
  bool update(const OdometerTravel& travel, double variance, double confidence);

  /// A bend whose middle passed `travel` after the last weld; net < 0: before it. False: it is near
  /// no bend of the tally.
  bool sight_bend(const OdometerTravel& travel, const BendSighting& bend);

  [[nodiscard]] std::size_t size() const { return current_.size(); }
  [[nodiscard]] const WeldHypothesis& operator[](std::size_t i) const { return current_[i]; }
  /// Index of the one to report: the heaviest, but for faults that one weld alone shows. The first
  /// of equals. Not for size() 0.
  [[nodiscard]] std::size_t best() const { return best_; }
  /// Faults are told: forget them.
  void clear_faults();

 private:
  void branch(const WeldHypothesis& predicted, double variance, double spurious_density);
  void accept(const WeldHypothesis& predicted, int weld, double weight_as_expected,
              double weight_slip, double weight_tally, double variance);
  bool weigh_bend(WeldHypothesis& hypothesis, const OdometerTravel& travel,
                  const BendSighting& bend) const;
  void merge_into_slot(const WeldHypothesis& child);
  void spawn(double weight, double variance);
  bool normalise();
  [[nodiscard]] double chance_of_missing(const WeldHypothesis& hypothesis, int weld) const;

  struct Bend {
    double place = 0.0;  ///< m, from weld 0
    int joint = 0;
    double variance = 0.0;  ///< m^2, of the place from the weld at the low end of the joint
    double angle = 0.0;     ///< rad
    double angle_variance = 0.0;
  };

  const WeldPositioningParameters& parameters_;
  const JointChain& chain_;
  std::vector<Bend> bends_;  // along the pipe
  double spurious_bends_;    // density of bends that are none, 1/(m rad)
  Orientation orientation_;
  std::vector<WeldHypothesis> current_;
  std::vector<WeldHypothesis> next_;
  std::vector<std::uint32_t>
      slot_;  // per direction and weld: index in next_ + 1 of the first match
  std::size_t capacity_;
  std::size_t best_ = 0;
  double lost_ = 0.0;
  double lost_density_ = 0.0;
  double scale_;  // what a crawler found anew is given
  double scale_variance_;
};

}  // namespace pipescout::odometry
