// SPDX-License-Identifier: Apache-2.0
#include "weld_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipescout::odometry {
namespace {

/// Chance per weld that no hypothesis is near the truth any more. Keeps the way back open.
constexpr double kLostFloor = 1e-8;
/// The whole pipe is searched anew from this chance on.
constexpr double kSearchFrom = 0.01;
/// m and standard deviations by which a weld must lie behind to count as passed unseen.
constexpr double kPassedMargin = 0.2;
constexpr double kPassedSigmas = 5.0;
/// m gone back and forth from which a weld may be seen again.
constexpr double kRetraced = 0.2;
/// Joint lengths by which an error of the tally may throw the next weld off.
constexpr double kTallyReach = 1.5;
/// Chance that an odometer fault before a weld goes on after it.
constexpr double kSlipGoesOn = 0.2;
/// Factor on a hypothesis whose last weld showed a fault, when the one to report is chosen: the
/// odometer keeps its word until a second weld speaks against it. (A missed weld and a spurious one
/// in one joint look like a fault.)
constexpr double kUnconfirmed = 0.02;
/// By which a detection without any confidence is more likely spurious than one on average.
constexpr double kWorstOdds = 1000.0;
/// Welds after which a suspected fault is no longer news.
constexpr int kFaultMemory = 8;

double normal_density(double residual_squared, double variance) {
  return std::exp(-0.5 * residual_squared / variance) /
         std::sqrt(2.0 * std::numbers::pi * variance);
}

/// b into a, keeping mean and covariance of the two together. Both are at the same weld.
void merge(WeldHypothesis& a, const WeldHypothesis& b) {
  const double weight = a.weight + b.weight;
  if (weight <= 0.0) {
    return;
  }
  const double share = b.weight / weight;
  const double d0 = b.offset - a.offset;
  const double d1 = b.scale - a.scale;
  const double spread = share * (1.0 - share);
  WeldHypothesis merged = a.weight >= b.weight ? a : b;
  merged.weight = weight;
  merged.offset = a.offset + share * d0;
  merged.scale = a.scale + share * d1;
  merged.p00 = a.p00 + share * (b.p00 - a.p00) + spread * d0 * d0;
  merged.p01 = a.p01 + share * (b.p01 - a.p01) + spread * d0 * d1;
  merged.p11 = a.p11 + share * (b.p11 - a.p11) + spread * d1 * d1;
  const double fault_a = (1.0 - share) * static_cast<double>(a.fault.slip + a.fault.tally);
  const double fault_b = share * static_cast<double>(b.fault.slip + b.fault.tally);
  merged.fault = fault_a >= fault_b ? a.fault : b.fault;
  merged.fault.slip = static_cast<float>((1.0 - share) * static_cast<double>(a.fault.slip) +
                                         share * static_cast<double>(b.fault.slip));
  merged.fault.tally = static_cast<float>((1.0 - share) * static_cast<double>(a.fault.tally) +
                                          share * static_cast<double>(b.fault.tally));
  a = merged;
}

/// How much speaks for reporting it.
double standing(const WeldHypothesis& hypothesis) {
  if (hypothesis.fault.age > 0) {
    return hypothesis.weight;
  }
  const double share = static_cast<double>(hypothesis.fault.slip + hypothesis.fault.tally);
  return hypothesis.weight * std::lerp(1.0, kUnconfirmed, std::min(share, 1.0));
}

bool can_merge(const WeldHypothesis& a, const WeldHypothesis& b) {
  const double difference = a.scale - b.scale;
  return difference * difference <= 4.0 * (a.p11 + b.p11);
}

}  // namespace

void WeldHypothesis::predict(const OdometerTravel& travel, double scale_drift) {
  const double step = direction * travel.net;
  const double drift = scale_drift * travel.path;
  offset += scale * step;
  // The drift within the step is that of a random walk; step and path differ after a reversal.
  p00 += 2.0 * step * p01 + step * step * (p11 + drift / 3.0) + scale * scale * travel.variance;
  p01 += step * (p11 + drift / 2.0);
  p11 += drift;
  net += travel.net;
  path += travel.path;
}

WeldHypotheses::WeldHypotheses(const WeldPositioningParameters& parameters, const JointChain& chain,
                               const WeldPositioningStart& start, std::span<const TallyBend> bends,
                               bool with_lost)
    : parameters_(parameters),
      chain_(chain),
      spurious_bends_(parameters.spurious_bend_probability /
                      (chain.mean_length() * std::numbers::pi)),
      orientation_(start.orientation),
      slot_(2 * static_cast<std::size_t>(chain.joints() + 1)),
      capacity_(std::max(parameters.largest_hypothesis_count, slot_.size())),
      lost_(with_lost ? kLostFloor : 0.0),
      lost_density_(with_lost ? 1.0 / chain.mean_length() : 0.0),
      scale_(parameters.initial_scale),
      scale_variance_(parameters.initial_scale_standard_deviation *
                      parameters.initial_scale_standard_deviation) {
  for (const TallyBend& bend : bends) {
    bends_.push_back(
        {.place = chain.weld(static_cast<int>(bend.joint)) + bend.distance,
         .joint = static_cast<int>(bend.joint),
         .variance = bend.standard_deviation * bend.standard_deviation,
         .angle = bend.angle,
         .angle_variance = bend.angle_standard_deviation * bend.angle_standard_deviation});
  }
  std::ranges::sort(bends_, {}, &Bend::place);
  current_.reserve(2 * capacity_ + slot_.size());
  next_.reserve(2 * capacity_ + slot_.size());
  if (!start.joint_known) {
    lost_ = 1.0;
    return;
  }
  const int joint = static_cast<int>(start.joint);
  const double sigma = start.distance_standard_deviation;
  current_.push_back({.weight = 1.0 - lost_,
                      .offset = start.distance,
                      .scale = scale_,
                      .p00 = sigma * sigma,
                      .p11 = scale_variance_,
                      .direction = start.orientation == Orientation::kBackward ? -1 : 1,
                      .anchor = joint,
                      .lowest = joint + 1,
                      .highest = joint,
                      .fault = {}});
}

double WeldHypotheses::chance_of_missing(const WeldHypothesis& hypothesis, int weld) const {
  const int missed = std::max({weld - hypothesis.highest - 1, hypothesis.lowest - weld - 1, 0});
  return missed == 0 ? 1.0 : std::pow(parameters_.missed_probability, missed);
}

bool WeldHypotheses::update(const OdometerTravel& travel, double variance, double confidence) {
  // Odds that the detection is spurious, as against those that hold on average. A confident
  // detector may still take something else for a weld, so they are never better.
  const double spurious = parameters_.spurious_probability;
  const double odds =
      std::isnan(confidence)
          ? 1.0
          : std::clamp((1.0 - confidence) / confidence * (1.0 - spurious) / spurious, 1.0,
                       kWorstOdds);
  next_.clear();
  std::fill(slot_.begin(), slot_.end(), 0U);
  const double spurious_density = odds * spurious / chain_.mean_length();
  for (WeldHypothesis& hypothesis : current_) {
    hypothesis.predict(travel, parameters_.scale_drift);
    hypothesis.previous_anchor = -1;
    hypothesis.innovation = -1.0;
    branch(hypothesis, variance, spurious_density);
  }
  const double lost_before = lost_;
  lost_ *= lost_density_;
  if (lost_before > kSearchFrom) {
    const double share_spurious = std::min(odds * spurious, 0.99);
    spawn(lost_ * (1.0 - share_spurious), variance);
    lost_ *= share_spurious;
  }
  if (!normalise()) {
    lost_ = lost_before;
    return false;
  }
  return true;
}

bool WeldHypotheses::sight_bend(const OdometerTravel& travel, const BendSighting& bend) {
  next_.clear();
  bool explained = false;
  for (const WeldHypothesis& hypothesis : current_) {
    next_.push_back(hypothesis);
    explained = weigh_bend(next_.back(), travel, bend) || explained;
  }
  if (!explained) {
    return false;
  }
  const double lost_before = lost_;
  // Anywhere in the pipe, and of any angle.
  const double per_metre = static_cast<double>(bends_.size()) / chain_.weld(chain_.joints());
  lost_ *=
      spurious_bends_ + (1.0 - parameters_.missed_bend_probability) * per_metre / std::numbers::pi;
  if (!normalise()) {
    lost_ = lost_before;
    return false;
  }
  return true;
}

/// Each alternative is a Gaussian about the same weld; they become one. False: near no bend.
bool WeldHypotheses::weigh_bend(WeldHypothesis& hypothesis, const OdometerTravel& travel,
                                const BendSighting& bend) const {
  const double step = hypothesis.direction * travel.net;
  const double anchor = chain_.weld(hypothesis.anchor);
  const double place = anchor + hypothesis.offset + hypothesis.scale * step;
  const double reading = bend.standard_deviation * bend.standard_deviation +
                         hypothesis.scale * hypothesis.scale * travel.variance;
  // Covariance of (offset, scale) with the place, and the variance of the place.
  const double c0 = hypothesis.p00 + step * hypothesis.p01;
  const double c1 = hypothesis.p01 + step * hypothesis.p11;
  const double predicted = c0 + step * c1;
  const double slip_reach = travel.net > 0.0 ? parameters_.largest_double_slip * travel.path : 0.0;
  const double detected = 1.0 - parameters_.missed_bend_probability;

  const Bend* nearest = nullptr;
  double as_expected = 0.0;
  double slip = 0.0;
  double residual = 0.0;
  double known = 0.0;  // m^2, of the bend of the tally
  for (const Bend& each : bends_) {
    const double off = place - each.place;
    const double variance = each.variance + chain_.variance_between(hypothesis.anchor, each.joint);
    const double total = predicted + variance + reading;
    const double turn = bend.angle - each.angle;
    const double likelihood =
        detected *
        normal_density(turn * turn, each.angle_variance + bend.angle_standard_deviation *
                                                              bend.angle_standard_deviation);
    const bool in_gate = off * off <= parameters_.gate * parameters_.gate * total;
    const double expected_here = in_gate ? likelihood * normal_density(off * off, total) : 0.0;
    const double slip_here =
        std::abs(off) <= slip_reach
            ? likelihood * parameters_.double_slip_probability / (2 * slip_reach)
            : 0.0;
    if (expected_here + slip_here > as_expected + slip) {
      nearest = &each;
      as_expected = expected_here;
      slip = slip_here;
      residual = off;
      known = variance;
    }
  }
  const double weight = hypothesis.weight;
  WeldHypothesis updated = hypothesis;
  WeldHypothesis slipped = hypothesis;
  hypothesis.weight = weight * spurious_bends_;
  if (nearest == nullptr) {
    return false;
  }
  const double total = predicted + known + reading;
  updated.weight = weight * as_expected;
  updated.offset -= c0 / total * residual;
  updated.scale -= c1 / total * residual;
  updated.p00 -= c0 * c0 / total;
  updated.p01 -= c0 * c1 / total;
  updated.p11 -= c1 * c1 / total;
  merge(hypothesis, updated);
  // The bend says where the crawler is, and nothing about the scale.
  slipped.weight = weight * slip;
  slipped.offset -= residual;
  slipped.p00 = known + reading;
  slipped.p01 = 0.0;
  slipped.fault = {.slip = 1.0F, .tally = 0.0F, .error = slipped.direction * residual, .age = 0};
  merge(hypothesis, slipped);
  return true;
}

void WeldHypotheses::branch(const WeldHypothesis& predicted, double variance,
                            double spurious_density) {
  const int joint = chain_.joint_at(predicted.anchor, predicted.offset);
  const double detected = 1.0 - parameters_.missed_probability;
  const bool retraced = predicted.path - std::abs(predicted.net) > kRetraced;
  // A fault may go on beyond the weld that showed it.
  const double slip_probability = predicted.fault.age == 0
                                      ? std::lerp(parameters_.double_slip_probability, kSlipGoesOn,
                                                  static_cast<double>(predicted.fault.slip))
                                      : parameters_.double_slip_probability;
  const double slip_reach = parameters_.largest_double_slip * predicted.path;
  const double tally_reach = kTallyReach * chain_.mean_length();
  const double gate_squared = parameters_.gate * parameters_.gate;
  for (int weld = std::max(joint - 1, 0); weld <= std::min(joint + 2, chain_.joints()); ++weld) {
    const double residual = predicted.offset - (chain_.weld(weld) - chain_.weld(predicted.anchor));
    const double total = predicted.p00 + chain_.variance_between(weld, predicted.anchor) + variance;
    const bool same =
        weld == predicted.anchor && predicted.highest >= predicted.lowest && !retraced;
    const double prior = predicted.weight * detected * chance_of_missing(predicted, weld);
    double as_expected = 0.0;
    double slip = 0.0;
    double tally = 0.0;
    if (!same && residual * residual <= gate_squared * total) {
      as_expected = prior * normal_density(residual * residual, total);
    }
    if (!same && slip_reach > 0.0 && std::abs(residual) <= slip_reach) {
      slip = prior * slip_probability / (2.0 * slip_reach);
    }
    if (!same && std::abs(residual) <= tally_reach) {
      tally = prior * parameters_.tally_error_probability / (2.0 * tally_reach);
    }
    // A joint missing or extra in the tally throws the weld off by its length, and what lies
    // between is no weld that was missed.
    const double joint_residual = std::abs(residual) - chain_.mean_length();
    const double joint_variance = chain_.length_variance() + total;
    if (std::abs(predicted.net) > 0.5 * chain_.mean_length() &&
        joint_residual * joint_residual <= gate_squared * joint_variance) {
      tally += 0.5 * predicted.weight * detected * parameters_.tally_error_probability *
               normal_density(joint_residual * joint_residual, joint_variance);
    }
    if (as_expected + slip + tally > 0.0) {
      accept(predicted, weld, as_expected, slip, tally, variance);
    }
  }

  WeldHypothesis spurious = predicted;
  const auto behind = [&](int weld, double sign) {
    const double residual = predicted.offset - (chain_.weld(weld) - chain_.weld(predicted.anchor));
    const double total = predicted.p00 + chain_.variance_between(weld, predicted.anchor);
    return sign * residual > kPassedMargin + kPassedSigmas * std::sqrt(total);
  };
  spurious.weight *= spurious_density;
  if (behind(chain_.joints(), 1.0) || behind(0, -1.0)) {
    return;  // outside the pipe
  }
  while (spurious.highest < chain_.joints() && behind(spurious.highest + 1, 1.0)) {
    ++spurious.highest;
    spurious.weight *= parameters_.missed_probability;
  }
  while (spurious.lowest > 0 && behind(spurious.lowest - 1, -1.0)) {
    --spurious.lowest;
    spurious.weight *= parameters_.missed_probability;
  }
  if (next_.size() < next_.capacity() - slot_.size()) {
    next_.push_back(spurious);
  }
}

void WeldHypotheses::accept(const WeldHypothesis& predicted, int weld, double weight_as_expected,
                            double weight_slip, double weight_tally, double variance) {
  WeldHypothesis child = predicted;
  const double between = chain_.weld(weld) - chain_.weld(predicted.anchor);
  const double tally_variance = chain_.variance_between(weld, predicted.anchor);
  const double residual = predicted.offset - between;
  child.previous_anchor = predicted.anchor;
  child.measured = std::abs(predicted.offset);
  child.measured_variance = predicted.p00 + variance;
  child.anchor = weld;
  child.lowest = std::min(predicted.lowest, weld);
  child.highest = std::max(predicted.highest, weld);
  child.net = 0.0;
  child.path = 0.0;
  if (weight_as_expected > 0.0) {
    const double prior = predicted.p00 + tally_variance;
    const double total = prior + variance;
    const double gain = prior / total;
    child.weight = weight_as_expected;
    child.offset = residual * (1.0 - gain);
    child.scale = predicted.scale - predicted.p01 / total * residual;
    child.p00 = prior * (1.0 - gain);
    child.p01 = predicted.p01 * (1.0 - gain);
    child.p11 = predicted.p11 - predicted.p01 * predicted.p01 / total;
    child.innovation = residual * residual / total;
    child.odometer_share = predicted.p00 / total;
    ++child.fault.age;
    if (child.fault.age > kFaultMemory) {
      child.fault = {};
    }
    merge_into_slot(child);
  }
  const double weight_fault = weight_slip + weight_tally;
  if (weight_fault > 0.0) {
    // The weld says where the crawler is, and nothing about the scale.
    child.weight = weight_fault;
    child.offset = 0.0;
    child.scale = predicted.scale;
    child.p00 = variance;
    child.p01 = 0.0;
    child.p11 = predicted.p11;
    child.innovation = -1.0;
    child.fault = {.slip = static_cast<float>(weight_slip / weight_fault),
                   .tally = static_cast<float>(weight_tally / weight_fault),
                   .error = predicted.direction * residual,
                   .age = 0};
    merge_into_slot(child);
  }
}

void WeldHypotheses::merge_into_slot(const WeldHypothesis& child) {
  auto& slot = slot_[2 * static_cast<std::size_t>(child.anchor) + (child.direction > 0 ? 1U : 0U)];
  if (slot != 0U) {
    WeldHypothesis& first = next_[slot - 1];
    if (next_.size() >= next_.capacity() - slot_.size() || can_merge(first, child)) {
      merge(first, child);
      return;
    }
  }
  next_.push_back(child);
  if (slot == 0U) {
    slot = static_cast<std::uint32_t>(next_.size());
  }
}

void WeldHypotheses::spawn(double weight, double variance) {
  const bool both = orientation_ == Orientation::kUnknown;
  const int welds = chain_.joints() + 1;
  WeldHypothesis child{.weight = weight / (both ? 2.0 * welds : 1.0 * welds),
                       .scale = scale_,
                       .p00 = variance,
                       .p11 = scale_variance_,
                       .fault = {}};
  for (const int direction : {1, -1}) {
    if (!both && (direction > 0) != (orientation_ == Orientation::kForward)) {
      continue;
    }
    child.direction = direction;
    for (int weld = 0; weld < welds; ++weld) {
      child.anchor = child.lowest = child.highest = weld;
      merge_into_slot(child);
    }
  }
}

bool WeldHypotheses::normalise() {
  double heaviest = 0.0;
  for (const WeldHypothesis& hypothesis : next_) {
    heaviest = std::max(heaviest, hypothesis.weight);
  }
  if (!(heaviest + lost_ > 0.0)) {
    return false;
  }
  std::swap(current_, next_);
  const double least = parameters_.prune_ratio * heaviest;
  std::erase_if(current_,
                [&](const WeldHypothesis& h) { return h.weight < least || h.weight <= 0.0; });
  if (current_.size() > capacity_) {
    const auto heavier = [](const WeldHypothesis& a, const WeldHypothesis& b) {
      if (a.weight != b.weight) {
        return a.weight > b.weight;
      }
      if (a.anchor != b.anchor) {
        return a.anchor < b.anchor;
      }
      return a.direction != b.direction ? a.direction > b.direction : a.offset < b.offset;
    };
    std::sort(current_.begin(), current_.end(), heavier);
    current_.erase(current_.begin() + static_cast<std::ptrdiff_t>(capacity_), current_.end());
  }
  double sum = lost_;
  for (const WeldHypothesis& hypothesis : current_) {
    sum += hypothesis.weight;
  }
  best_ = 0;
  for (std::size_t i = 0; i < current_.size(); ++i) {
    current_[i].weight /= sum;
    if (standing(current_[i]) > standing(current_[best_])) {
      best_ = i;
    }
  }
  lost_ /= sum;
  if (lost_density_ > 0.0) {
    lost_ = std::max(lost_, kLostFloor);
  }
  return true;
}

void WeldHypotheses::clear_faults() {
  for (WeldHypothesis& hypothesis : current_) {
    hypothesis.fault = {};
  }
}

}  // namespace pipescout::odometry
