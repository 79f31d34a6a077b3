// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {
namespace {

struct Event {
  bool is_weld = false;
  OdometerIncrement increment;
  WeldSighting weld;
};

/// At full size always, as rapidcheck's small first cases would be pipes without joints.
template <typename Integer>
Integer draw(Integer from, Integer to) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<Integer>(from, to));
}

std::vector<TallyJoint> draw_tally() {
  std::vector<TallyJoint> tally(draw<std::size_t>(1, 40));
  for (auto& joint : tally) {
    joint = {draw(100, 1400) * 0.01, draw(0, 5) * 0.01};
  }
  return tally;
}

double draw_any() {
  return *rc::gen::element(0.0, -1.0, 1e-300, 1e300, -1e300, 3.0,
                           std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity());
}

/// Sense and nonsense: reversing, welds anywhere, bad values.
std::vector<Event> draw_events() {
  std::vector<Event> events(draw<std::size_t>(1, 200));
  double odometer = 0.0;
  for (auto& event : events) {
    const int kind = draw(0, 20);
    event.is_weld = kind >= 14;
    event.increment = {draw(-200, 400) * 0.01, draw(0, 100) * 1e-5};
    event.weld = {odometer - draw(-20, 50) * 0.01, draw(1, 50) * 0.001, draw(0, 101) * 0.01};
    if (kind == 0) {
      event.increment.distance = draw_any();
    } else if (kind == 1) {
      event.increment.variance = draw_any();
    } else if (kind == 14) {
      event.weld.odometer_distance = draw_any();
    } else if (kind == 15) {
      event.weld.standard_deviation = draw_any();
    } else if (kind >= 2 && kind < 14) {
      odometer += event.increment.distance;
    }
  }
  return events;
}

WeldPositioningStart draw_start(std::size_t joints) {
  if (draw(0, 2) == 0) {
    return {.joint_known = true,
            .joint = draw<std::size_t>(0, joints),
            .distance = draw(-100, 1500) * 0.01,
            .orientation = *rc::gen::element(Orientation::kForward, Orientation::kBackward)};
  }
  return {.orientation = *rc::gen::element(Orientation::kForward, Orientation::kBackward,
                                           Orientation::kUnknown)};
}

const WeldPositionEstimate& feed(WeldPositioning& positioning, const Event& event) {
  return event.is_weld ? positioning.add_weld(event.weld)
                       : positioning.add_increment(event.increment);
}

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

RC_GTEST_PROP(WeldPositioningProperties, WhateverComesTheEstimateIsSound, ()) {
  const auto tally = draw_tally();
  WeldPositioningParameters parameters;
  parameters.largest_hypothesis_count = draw<std::size_t>(8, 200);
  WeldPositioning positioning(parameters, tally, draw_start(tally.size()));
  for (const auto& event : draw_events()) {
    const auto& estimate = feed(positioning, event);
    RC_ASSERT(estimate.probability >= 0.0 && estimate.probability <= 1.0);
    RC_ASSERT(estimate.hypotheses <=
              std::max(parameters.largest_hypothesis_count, 2 * (tally.size() + 1)));
    RC_ASSERT(!estimate.locked || estimate.known);
    if (!estimate.known) {
      continue;
    }
    RC_ASSERT(estimate.joint < tally.size());
    RC_ASSERT(std::isfinite(estimate.distance_into_joint) && std::isfinite(estimate.chainage));
    const auto& covariance = estimate.covariance;
    RC_ASSERT(covariance(0, 0) >= 0.0 && std::isfinite(covariance(0, 0)));
    RC_ASSERT(covariance(1, 1) >= 0.0 && std::isfinite(covariance(1, 1)));
    RC_ASSERT(covariance(0, 1) == covariance(1, 0));
    RC_ASSERT(covariance(0, 0) * covariance(1, 1) - covariance(0, 1) * covariance(0, 1) >=
              -1e-9 * covariance(0, 0) * covariance(1, 1));
    RC_ASSERT(!estimate.locked || covariance(0, 0) <= 1.0 + 1e-12);
  }
}

RC_GTEST_PROP(WeldPositioningProperties, SameEventsGiveSameBits, ()) {
  const auto tally = draw_tally();
  const auto start = draw_start(tally.size());
  const WeldPositioningParameters parameters{.largest_hypothesis_count = 64};
  WeldPositioning one(parameters, tally, start);
  WeldPositioning other(parameters, tally, start);
  for (const auto& event : draw_events()) {
    const auto& a = feed(one, event);
    const auto& b = feed(other, event);
    RC_ASSERT(a.joint == b.joint && a.known == b.known && a.locked == b.locked);
    RC_ASSERT(same_bits(a.distance_into_joint, b.distance_into_joint));
    RC_ASSERT(same_bits(a.probability, b.probability));
    RC_ASSERT(same_bits(a.covariance(0, 0), b.covariance(0, 0)));
  }
}

}  // namespace
}  // namespace pipescout::odometry
