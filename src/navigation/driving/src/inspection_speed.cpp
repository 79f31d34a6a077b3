// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/inspection_speed.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kSamePlace = 1;  ///< m, between findings

void lower(InspectionDecision& decision, double speed, InspectionReason reason) {
  if (speed < decision.speed) {
    decision.speed = speed;
    decision.reason = reason;
  }
}

}  // namespace

void InspectionParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_above("exposure", exposure, 0, 1);
  check_within("focal_length", focal_length, 10, 1e5);
  check_above("largest_blur", largest_blur, 0, 100);
  check_above("speed_share", speed_share, 0, 1);
  check_above("arm_rate", arm_rate, 0, 10);
  check_above("usual_range", usual_range, 0, 1000);
  check_above("good_confidence", good_confidence, 0, 1);
  validation::require("least_confidence", least_confidence,
                      least_confidence >= 0 && least_confidence < good_confidence,
                      "[0, good_confidence)");
  check_above("slow_speed", slow_speed, 0, 10);
  check_within("stop_after", stop_after, 0, 60);
  check_within("return_after", return_after, stop_after, 600);
  check_within("return_run", return_run, 0, 10);
  check_within("returns", returns, 0, 10);
  check_within("nearer", nearer, 0, 5);
}

const char* to_string(InspectionReason reason) {
  switch (reason) {
    case InspectionReason::kNone:
      return "none";
    case InspectionReason::kMotionBlur:
      return "motion blur";
    case InspectionReason::kArmRate:
      return "rate of the arm";
    case InspectionReason::kLowConfidence:
      return "low confidence of the track";
    case InspectionReason::kTrackLost:
      return "track lost";
    case InspectionReason::kGoesBack:
      return "goes back to where the pipe was last seen";
    case InspectionReason::kPipeGivenUp:
      return "pipe not found again";
    case InspectionReason::kDoubtfulFinding:
      return "doubtful finding";
  }
  return "unknown";
}

InspectionSpeed::InspectionSpeed(const InspectionParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
}

void InspectionSpeed::start() {
  *this = InspectionSpeed(parameters_);
}

void InspectionSpeed::doubtful_finding(double arc_length) {
  const bool known = last_doubtful_ && std::abs(arc_length - *last_doubtful_) < kSamePlace;
  if (std::isfinite(arc_length) && !known) {
    doubtful_ = arc_length;
    last_doubtful_ = arc_length;
  }
}

double InspectionSpeed::blur_limit(double range) const {
  const auto& p = parameters_;
  return p.largest_blur * range / (p.exposure * p.focal_length);
}

InspectionDecision InspectionSpeed::lost(const InspectionView& view, InspectionDecision decision) {
  const auto& p = parameters_;
  if (given_up_ || !last_seen_) {
    lower(decision, p.slow_speed,
          given_up_ ? InspectionReason::kPipeGivenUp : InspectionReason::kTrackLost);
    return decision;
  }
  if (!lost_since_ || view.time < *lost_since_) {  // or the clock was set back
    lost_since_ = view.time;
  }
  const double without = view.time - *lost_since_;
  if (without < p.stop_after) {
    lower(decision, p.slow_speed, InspectionReason::kTrackLost);
    return decision;
  }
  if (without < p.return_after) {
    decision.speed = 0;
    decision.reason = InspectionReason::kTrackLost;
    return decision;
  }
  lost_since_.reset();
  if (returns_ >= p.returns) {
    given_up_ = true;
    lower(decision, p.slow_speed, InspectionReason::kPipeGivenUp);
    return decision;
  }
  ++returns_;
  decision.go_back_to = *last_seen_ - p.return_run;
  decision.speed = p.slow_speed;
  decision.reason = InspectionReason::kGoesBack;
  return decision;
}

InspectionDecision InspectionSpeed::decide(const InspectionView& view) {
  const auto& p = parameters_;
  InspectionDecision decision;
  const double range = std::isfinite(view.range) && view.range > 0 ? view.range : p.usual_range;
  lower(decision, p.speed_share * blur_limit(range), InspectionReason::kMotionBlur);
  lower(decision, p.arm_rate * range, InspectionReason::kArmRate);
  const bool usable = view.tracked && std::isfinite(view.confidence) &&
                      std::isfinite(view.arc_length) && view.confidence >= p.least_confidence;
  if (!usable) {
    return lost(view, decision);
  }
  lost_since_.reset();
  if (!last_seen_ || view.arc_length > *last_seen_) {
    last_seen_ = view.arc_length;
    returns_ = 0;
  }
  given_up_ = false;
  if (view.confidence < p.good_confidence) {
    const double share =
        (view.confidence - p.least_confidence) / (p.good_confidence - p.least_confidence);
    const double full = std::max(decision.speed, p.slow_speed);
    lower(decision, p.slow_speed + share * (full - p.slow_speed), InspectionReason::kLowConfidence);
  }
  if (doubtful_ && view.arc_length > *doubtful_ + p.return_run) {
    passing_ = doubtful_;
    doubtful_.reset();
    decision.go_back_to = *passing_ - p.return_run;
  }
  if (passing_) {
    if (!decision.go_back_to && view.arc_length > *passing_ + p.return_run) {
      passing_.reset();
    } else {
      decision.nearer = true;
      lower(decision, p.slow_speed, InspectionReason::kDoubtfulFinding);
    }
  }
  return decision;
}

}  // namespace pipescout::navigation
