// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_positioning.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "joint_chain.hpp"
#include "joint_doubt.hpp"
#include "pipescout/statistics/normal.hpp"
#include "pipescout/validation/check.hpp"
#include "weld_hypotheses.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

constexpr double kBandLeft = 0.05;
constexpr double kCertain = 0.9;  // share of the weight that makes a fault news
constexpr double kLowestNoiseFactor = 0.25;
constexpr double kHighestNoiseFactor = 25.0;
constexpr double kLargestInnovation = 9.0;  // squared; a single odd weld teaches no more than this
constexpr double kSightingSigmas = 5.0;
constexpr double kHalfTurn = std::numbers::pi;
/// Largest probability of another joint, by a fault of the odometer in a bend, at which the joint
/// counts as certain.
constexpr double kLargestBendDoubt = 1e-3;

void check_start(const WeldPositioningStart& start, std::size_t joints, bool has_tally) {
  if (start.orientation != Orientation::kForward && start.orientation != Orientation::kBackward &&
      start.orientation != Orientation::kUnknown) {
    refuse("start.orientation: ", static_cast<int>(start.orientation), " is outside {0, 1, 2}");
  }
  if (!start.joint_known) {
    if (!has_tally) {
      refuse("start.joint_known: 0 is outside {1} without a tally");
    }
    return;
  }
  if (start.orientation == Orientation::kUnknown) {
    refuse("start.orientation: unknown is outside {forward, backward} for a known joint");
  }
  if (start.joint >= joints) {
    refuse("start.joint: ", start.joint, " is outside [0, ", joints, ")");
  }
  require("start.distance", start.distance, true, "(-inf, inf)");
  require("start.distance_standard_deviation", start.distance_standard_deviation,
          start.distance_standard_deviation > 0.0, "(0, inf)");
}

void check_bends(std::span<const TallyBend> bends, std::size_t joints, bool has_tally) {
  if (!bends.empty() && !has_tally) {
    refuse("bends: ", bends.size(), " is outside {0} without a tally");
  }
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const TallyBend& bend = bends[i];
    const auto check = [i](const char* field, double value, bool fits, const char* range) {
      if (!std::isfinite(value) || !fits) {
        refuse("bends[", i, "].", field, ": ", value, " is outside ", range);
      }
    };
    if (bend.joint >= joints) {
      refuse("bends[", i, "].joint: ", bend.joint, " is outside [0, ", joints, ")");
    }
    check("distance", bend.distance, true, "(-inf, inf)");
    check("standard_deviation", bend.standard_deviation, bend.standard_deviation > 0.0, "(0, inf)");
    check("angle", bend.angle, bend.angle > 0.0 && bend.angle <= kHalfTurn, "(0, pi]");
    check("angle_standard_deviation", bend.angle_standard_deviation,
          bend.angle_standard_deviation > 0.0, "(0, inf)");
  }
}

double square(double value) {
  return value * value;
}

JointChain make_chain(const WeldPositioningParameters& parameters,
                      std::span<const TallyJoint> tally) {
  return tally.empty() ? JointChain(parameters.standard_joint, parameters.largest_joint_count)
                       : JointChain(tally);
}

WeldPositioningParameters validated(WeldPositioningParameters parameters) {
  parameters.validate();
  return parameters;
}

}  // namespace

class WeldPositioning::Implementation {
 public:
  Implementation(WeldPositioningParameters parameters, std::span<const TallyJoint> tally,
                 const WeldPositioningStart& start, std::span<const TallyBend> bends)
      : parameters_(validated(std::move(parameters))),
        has_tally_(!tally.empty()),
        has_bends_(!bends.empty()),
        chain_(make_chain(parameters_, tally)),
        hypotheses_((check_start(start, static_cast<std::size_t>(chain_.joints()), has_tally_),
                     check_bends(bends, static_cast<std::size_t>(chain_.joints()), has_tally_),
                     parameters_),
                    chain_, start, bends, has_tally_),
        joint_doubt_(parameters_, chain_, bends) {
    learnt_.reserve(static_cast<std::size_t>(chain_.joints()));
    learnt_weld_.push_back(0.0);
    for (std::size_t j = 0; j < static_cast<std::size_t>(chain_.joints()); ++j) {
      const TallyJoint& joint = has_tally_ ? tally[j] : parameters_.standard_joint;
      learnt_.push_back({joint.length, joint.standard_deviation, 0U});
      learnt_weld_.push_back(learnt_weld_.back() + joint.length);
    }
    around_.reserve(kMostAround);
    summarise();
    report();
  }

  const WeldPositionEstimate& add_increment(const OdometerIncrement& increment) {
    ++counts_.increments;
    estimate_.double_slip_detected = estimate_.tally_error_detected = false;
    estimate_.spacing_error = 0.0;
    if (!std::isfinite(increment.distance) || !std::isfinite(increment.variance) ||
        increment.variance < 0.0 || increment.variance > square(parameters_.largest_increment) ||
        std::abs(increment.distance) > parameters_.largest_increment) {
      ++counts_.bad_increments;
      since_.variance += square(parameters_.bad_increment_standard_deviation);
      report();
      estimate_.status = PositioningStatus::kBadValue;
      return estimate_;
    }
    odometer_ += increment.distance;
    lowest_ = std::min(lowest_, odometer_);
    highest_ = std::max(highest_, odometer_);
    since_.net += increment.distance;
    since_.path += std::abs(increment.distance);
    since_.variance += noise_factor_ * increment.variance;
    report();
    return estimate_;
  }

  const WeldPositionEstimate& add_weld(const WeldSighting& weld) {
    ++counts_.welds;
    estimate_.double_slip_detected = estimate_.tally_error_detected = false;
    estimate_.spacing_error = 0.0;
    const bool confidence_fits =
        std::isnan(weld.confidence) || (weld.confidence >= 0.0 && weld.confidence <= 1.0);
    if (!std::isfinite(weld.odometer_distance) || !std::isfinite(weld.standard_deviation) ||
        weld.standard_deviation <= 0.0 || weld.standard_deviation > parameters_.largest_increment ||
        !confidence_fits) {
      ++counts_.bad_welds;
      estimate_.status = PositioningStatus::kBadValue;
      return estimate_;
    }
    const double lag = odometer_ - weld.odometer_distance;
    // Its noise may put it a little beyond where the crawler has been.
    const double tolerance = kSightingSigmas * weld.standard_deviation;
    if (weld.odometer_distance < lowest_ - tolerance ||
        weld.odometer_distance > highest_ + tolerance) {
      ++counts_.out_of_order_welds;
      estimate_.status = PositioningStatus::kOutOfOrder;
      return estimate_;
    }
    locate(lag, weld);
    report();
    return estimate_;
  }

  const WeldPositionEstimate& add_bend(const BendSighting& bend) {
    ++counts_.bends;
    estimate_.double_slip_detected = estimate_.tally_error_detected = false;
    estimate_.spacing_error = 0.0;
    const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
    if (!std::isfinite(bend.odometer_distance) || !positive(bend.standard_deviation) ||
        !positive(bend.angle) || bend.angle > kHalfTurn ||
        !positive(bend.angle_standard_deviation) ||
        bend.standard_deviation > parameters_.largest_increment) {
      ++counts_.bad_bends;
      estimate_.status = PositioningStatus::kBadValue;
      return estimate_;
    }
    const double net = since_.net - (odometer_ - bend.odometer_distance);
    const double tolerance = kSightingSigmas * bend.standard_deviation;
    if (bend.odometer_distance > highest_ + tolerance || std::abs(net) > since_.path + kBendReach) {
      ++counts_.out_of_order_bends;
      estimate_.status = PositioningStatus::kOutOfOrder;
      return estimate_;
    }
    joint_doubt_.note_bend(bend.odometer_distance);
    // On either side of the last weld the odometer is as noisy per metre.
    const OdometerTravel& side = net < 0.0 ? before_ : since_;
    const double share = side.path > 0.0 ? std::abs(net) / side.path : 0.0;
    if (!has_bends_ ||
        !hypotheses_.sight_bend(
            {.net = net, .path = std::abs(net), .variance = share * side.variance}, bend)) {
      ++counts_.unexplained_bends;
    } else {
      summarise();
      announce_faults();
    }
    report();
    return estimate_;
  }

  [[nodiscard]] const WeldPositionEstimate& estimate() const { return estimate_; }
  [[nodiscard]] const WeldPositioningCounts& counts() const { return counts_; }
  [[nodiscard]] double odometer_distance() const { return odometer_; }
  [[nodiscard]] std::span<const LearntJoint> learnt_joints() const { return learnt_; }

 private:
  /// Hypotheses beside the best that are looked at one by one for the 95 % band.
  static constexpr std::size_t kMostAround = 64;
  /// m, before the last weld, that the middle of a bend may lie: it is found when it has ended.
  static constexpr double kBendReach = 50.0;

  struct Neighbour {
    double distance = 0.0;  // m, from the best
    double weight = 0.0;
  };

  void locate(double lag, const WeldSighting& weld) {
    // The part of the travel that lies behind the weld is as noisy per metre as the rest.
    const double behind = since_.path > 0.0 ? std::min(std::abs(lag) / since_.path, 1.0) : 0.0;
    const OdometerTravel until{.net = since_.net - lag,
                               .path = since_.path * (1.0 - behind),
                               .variance = since_.variance * (1.0 - behind)};
    if (!hypotheses_.update(until, weld.standard_deviation * weld.standard_deviation,
                            weld.confidence)) {
      ++counts_.unexplained_welds;
    }
    before_ = until;
    since_ = {.net = lag, .path = since_.path * behind, .variance = since_.variance * behind};
    lowest_ = std::min(odometer_, weld.odometer_distance);
    highest_ = std::max(odometer_, weld.odometer_distance);
    summarise();
    follow_lock();
    announce_faults();
    if (hypotheses_.size() > 0) {
      adapt_noise(hypotheses_[hypotheses_.best()]);
      learn(hypotheses_[hypotheses_.best()]);
    }
  }

  /// The hypotheses within half a joint of the best become one Gaussian about it.
  void summarise() {
    probability_ = 0.0;
    if (hypotheses_.size() == 0) {
      return;
    }
    around_.clear();
    summary_ = hypotheses_[hypotheses_.best()];
    const WeldHypothesis best = summary_;
    const int joint = chain_.joint_at(best.anchor, best.offset);
    const double reach = 0.5 * (chain_.weld(joint + 1) - chain_.weld(joint));
    double p00 = 0.0;
    double p01 = 0.0;
    double p11 = 0.0;
    double slip = 0.0;
    double tally = 0.0;
    double heaviest_fault = 0.0;
    for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
      const WeldHypothesis& other = hypotheses_[i];
      const double d0 =
          (chain_.weld(other.anchor) - chain_.weld(best.anchor)) + other.offset - best.offset;
      if (other.direction != best.direction || !(std::abs(d0) < reach)) {
        continue;
      }
      const double d1 = other.scale - best.scale;
      probability_ += other.weight;
      p00 += other.weight * (other.p00 + d0 * d0);
      p01 += other.weight * (other.p01 + d0 * d1);
      p11 += other.weight * (other.p11 + d1 * d1);
      const double fault_slip = other.weight * static_cast<double>(other.fault.slip);
      const double fault_tally = other.weight * static_cast<double>(other.fault.tally);
      slip += fault_slip;
      tally += fault_tally;
      if (fault_slip + fault_tally > heaviest_fault) {
        heaviest_fault = fault_slip + fault_tally;
        fault_error_ = other.fault.error;
      }
      if (around_.size() < kMostAround) {
        around_.push_back({std::abs(d0), other.weight});
      }
    }
    summary_.p00 = std::max(p00 / probability_, band_variance());
    summary_.p01 = p01 / probability_;
    summary_.p11 = p11 / probability_;
    fault_slip_ = slip;
    fault_tally_ = tally;
  }

  /// m^2: what the variance must be at least for the band to reach 95 % of the hypotheses near.
  double band_variance() {
    std::sort(around_.begin(), around_.end(), [](const Neighbour& a, const Neighbour& b) {
      return a.distance != b.distance ? a.distance > b.distance : a.weight > b.weight;
    });
    double left = 0.0;
    for (const Neighbour& neighbour : around_) {
      left += neighbour.weight;
      if (left > kBandLeft * probability_) {
        const double sigma = neighbour.distance / statistics::kNormal95 + std::sqrt(summary_.p00);
        return sigma * sigma;
      }
    }
    return 0.0;
  }

  void follow_lock() {
    certain_welds_ = probability_ >= parameters_.lock_probability ? certain_welds_ + 1 : 0;
    if (!locked_) {
      locked_ = certain_welds_ >= parameters_.lock_welds;
    } else if (probability_ < parameters_.unlock_probability) {
      locked_ = false;
      ++counts_.locks_lost;
    }
  }

  void announce_faults() {
    if (fault_slip_ + fault_tally_ < kCertain) {
      return;
    }
    estimate_.double_slip_detected = fault_slip_ >= fault_tally_;
    estimate_.tally_error_detected = !estimate_.double_slip_detected;
    estimate_.spacing_error = fault_error_;
    ++(estimate_.double_slip_detected ? counts_.double_slips : counts_.tally_errors);
    hypotheses_.clear_faults();
  }

  /// Innovations that are larger than stated, on average, mean more odometer noise than stated.
  void adapt_noise(const WeldHypothesis& best) {
    if (!locked_ || best.innovation < 0.0) {
      return;
    }
    const double surplus = std::min(best.innovation, kLargestInnovation) - 1.0;
    noise_factor_ = std::clamp(
        noise_factor_ * (1.0 + parameters_.noise_adaptation * best.odometer_share * surplus),
        kLowestNoiseFactor, kHighestNoiseFactor);
  }

  /// The weld before this one was the other end of a joint: its length was measured.
  void learn(const WeldHypothesis& best) {
    if (!locked_ || best.innovation < 0.0 || best.previous_anchor < 0 ||
        std::abs(best.anchor - best.previous_anchor) != 1) {
      return;
    }
    LearntJoint& joint =
        learnt_[static_cast<std::size_t>(std::min(best.anchor, best.previous_anchor))];
    const double before = joint.length;
    const double variance = joint.standard_deviation * joint.standard_deviation;
    const double share =
        joint.observations == 0 ? 1.0 : variance / (variance + best.measured_variance);
    joint.length += share * (best.measured - joint.length);
    joint.standard_deviation = std::sqrt(share * best.measured_variance);
    ++joint.observations;
    if (!has_tally_) {
      const auto first = learnt_weld_.begin() + std::min(best.anchor, best.previous_anchor) + 1;
      const double change = joint.length - before;
      std::for_each(first, learnt_weld_.end(), [change](double& weld) { weld += change; });
    }
  }

  void report() {
    estimate_.status = PositioningStatus::kAccepted;
    estimate_.hypotheses = hypotheses_.size();
    estimate_.noise_factor = noise_factor_;
    estimate_.known = hypotheses_.size() > 0;
    if (!estimate_.known) {
      estimate_.locked = false;
      return;
    }
    WeldHypothesis now = summary_;
    now.predict(since_, parameters_.scale_drift);
    const int joint = chain_.joint_at(now.anchor, now.offset);
    const double into = now.offset - (chain_.weld(joint) - chain_.weld(now.anchor));
    const double variance = now.p00 + chain_.variance_between(now.anchor, joint);
    estimate_.joint = static_cast<std::size_t>(joint);
    estimate_.orientation = now.direction > 0 ? Orientation::kForward : Orientation::kBackward;
    estimate_.probability = std::min(probability_, 1.0);
    estimate_.distance_into_joint = into;
    const double weld = has_tally_ ? chain_.weld(joint) : learnt_weld_[estimate_.joint];
    estimate_.chainage = parameters_.first_weld_chainage + weld + into;
    estimate_.scale = now.scale;
    estimate_.covariance << variance, now.p01, now.p01, now.p11;
    const JointDoubt::Doubt doubt = joint_doubt_.doubt(now, joint, odometer_);
    estimate_.joint_probability = estimate_.probability * (1.0 - doubt.total);
    estimate_.locked = locked_ && std::sqrt(variance) <= parameters_.lock_standard_deviation &&
                       doubt.by_bend <= kLargestBendDoubt;
  }

  WeldPositioningParameters parameters_;
  bool has_tally_;
  bool has_bends_;
  JointChain chain_;
  WeldHypotheses hypotheses_;
  JointDoubt joint_doubt_;
  std::vector<LearntJoint> learnt_;
  std::vector<double> learnt_weld_;  // m, weld 0 at 0
  std::vector<Neighbour> around_;
  OdometerTravel since_;   // since the last weld taken
  OdometerTravel before_;  // from the one before to it
  double lowest_ = 0.0;    // m, of the odometer since that weld
  double highest_ = 0.0;
  double odometer_ = 0.0;   // m
  WeldHypothesis summary_;  // as of the last weld taken
  double probability_ = 0.0;
  double fault_slip_ = 0.0;
  double fault_tally_ = 0.0;
  double fault_error_ = 0.0;
  double noise_factor_ = 1.0;
  std::size_t certain_welds_ = 0;
  bool locked_ = false;
  WeldPositionEstimate estimate_;
  WeldPositioningCounts counts_;
};

WeldPositioning::WeldPositioning(WeldPositioningParameters parameters,
                                 std::span<const TallyJoint> tally,
                                 const WeldPositioningStart& start,
                                 std::span<const TallyBend> bends)
    : implementation_(
          std::make_unique<Implementation>(std::move(parameters), tally, start, bends)) {}
WeldPositioning::~WeldPositioning() = default;
WeldPositioning::WeldPositioning(WeldPositioning&&) noexcept = default;
WeldPositioning& WeldPositioning::operator=(WeldPositioning&&) noexcept = default;

const WeldPositionEstimate& WeldPositioning::add_increment(
    const OdometerIncrement& increment) noexcept {
  return implementation_->add_increment(increment);
}

const WeldPositionEstimate& WeldPositioning::add_weld(const WeldSighting& weld) noexcept {
  return implementation_->add_weld(weld);
}

const WeldPositionEstimate& WeldPositioning::add_bend(const BendSighting& bend) noexcept {
  return implementation_->add_bend(bend);
}

const WeldPositionEstimate& WeldPositioning::estimate() const noexcept {
  return implementation_->estimate();
}

const WeldPositioningCounts& WeldPositioning::counts() const noexcept {
  return implementation_->counts();
}

double WeldPositioning::odometer_distance() const noexcept {
  return implementation_->odometer_distance();
}

std::span<const LearntJoint> WeldPositioning::learnt_joints() const noexcept {
  return implementation_->learnt_joints();
}

}  // namespace pipescout::odometry
