// SPDX-License-Identifier: Apache-2.0
// Bad values, parameters, tallies and starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "fingerprint.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {
namespace {

using test::at_joint;
using test::fingerprint;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(WeldPositioningInput, BadValuesAreCountedAndMoveNothing) {
  const auto tally = fingerprint(20);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  positioning.add_increment({3.0, 1e-4});
  const double before = positioning.estimate().covariance(0, 0);
  const OdometerIncrement increments[] = {{kNaN, 1e-4}, {kInfinity, 1e-4}, {1.0, kNaN},
                                          {1.0, -1e-4}, {1.0, kInfinity},  {51.0, 1e-4},
                                          {1.0, 2501.0}};
  for (const auto& bad : increments) {
    EXPECT_EQ(positioning.add_increment(bad).status, PositioningStatus::kBadValue);
  }
  EXPECT_DOUBLE_EQ(positioning.estimate().distance_into_joint, 4.0);
  EXPECT_NEAR(positioning.estimate().covariance(0, 0), before + 7 * 0.05 * 0.05, 1e-9);
  const WeldSighting welds[] = {
      {kNaN, 0.01},     {kInfinity, 0.01},     {3.0, kNaN}, {3.0, 0.0},
      {3.0, -0.01},     {3.0, kInfinity},      {3.0, 51.0}, {3.0, 0.01, -0.1},
      {3.0, 0.01, 1.1}, {3.0, 0.01, kInfinity}};
  for (const auto& bad : welds) {
    EXPECT_EQ(positioning.add_weld(bad).status, PositioningStatus::kBadValue);
  }
  EXPECT_EQ(positioning.add_weld({3.5, 0.01}).status, PositioningStatus::kOutOfOrder);   // ahead
  EXPECT_EQ(positioning.add_weld({-0.5, 0.01}).status, PositioningStatus::kOutOfOrder);  // before
  EXPECT_EQ(positioning.add_weld({3.0, 0.01}).status, PositioningStatus::kAccepted);
  EXPECT_EQ(positioning.counts().increments, 8U);
  EXPECT_EQ(positioning.counts().bad_increments, 7U);
  EXPECT_EQ(positioning.counts().welds, 13U);
  EXPECT_EQ(positioning.counts().bad_welds, 10U);
  EXPECT_EQ(positioning.counts().out_of_order_welds, 2U);
}

TEST(WeldPositioningInput, LittleConfidenceMakesASpuriousWeldMoreLikely) {
  const auto tally = fingerprint(20);
  const auto probability = [&tally](double confidence) {
    WeldPositioning positioning({}, tally, {.orientation = Orientation::kForward});
    positioning.add_increment({5.0, 1e-4});
    positioning.add_weld({5.0, 0.01, confidence});
    return positioning.estimate().probability;
  };
  EXPECT_EQ(probability(kNaN), probability(1.0));
  EXPECT_LT(probability(0.01), 0.5 * probability(1.0));
}

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(WeldPositioningInput, RefusesParametersByName) {
  const std::pair<const char*, std::function<void(WeldPositioningParameters&)>> cases[] = {
      {"missed_probability", [](auto& p) { p.missed_probability = 0.0; }},
      {"spurious_probability", [](auto& p) { p.spurious_probability = 0.6; }},
      {"initial_scale", [](auto& p) { p.initial_scale = 0.5; }},
      {"initial_scale_standard_deviation",
       [](auto& p) { p.initial_scale_standard_deviation = kNaN; }},
      {"scale_drift", [](auto& p) { p.scale_drift = -1e-9; }},
      {"double_slip_probability", [](auto& p) { p.double_slip_probability = 0.0; }},
      {"largest_double_slip", [](auto& p) { p.largest_double_slip = 1.5; }},
      {"largest_increment", [](auto& p) { p.largest_increment = 0.0; }},
      {"bad_increment_standard_deviation",
       [](auto& p) { p.bad_increment_standard_deviation = -1.0; }},
      {"noise_adaptation", [](auto& p) { p.noise_adaptation = 0.3; }},
      {"tally_error_probability", [](auto& p) { p.tally_error_probability = 1.0; }},
      {"first_weld_chainage", [](auto& p) { p.first_weld_chainage = kInfinity; }},
      {"standard_joint.length", [](auto& p) { p.standard_joint.length = -12.0; }},
      {"standard_joint.standard_deviation",
       [](auto& p) { p.standard_joint.standard_deviation = -0.1; }},
      {"largest_joint_count", [](auto& p) { p.largest_joint_count = 0; }},
      {"largest_hypothesis_count", [](auto& p) { p.largest_hypothesis_count = 7; }},
      {"prune_ratio", [](auto& p) { p.prune_ratio = 0.0; }},
      {"gate", [](auto& p) { p.gate = 2.0; }},
      {"lock_probability", [](auto& p) { p.lock_probability = 1.0; }},
      {"unlock_probability", [](auto& p) { p.unlock_probability = 0.99995; }},
      {"lock_welds", [](auto& p) { p.lock_welds = 0; }},
      {"lock_standard_deviation", [](auto& p) { p.lock_standard_deviation = 0.0; }},
  };
  EXPECT_EQ(refusal([] { WeldPositioningParameters{}.validate(); }), "");
  for (const auto& [field, spoil] : cases) {
    WeldPositioningParameters parameters;
    spoil(parameters);
    EXPECT_THAT(refusal([&] { parameters.validate(); }), testing::StartsWith(field));
    EXPECT_THAT(refusal([&] { parameters.validate(); }), HasSubstr("is outside"));
  }
}

TEST(WeldPositioningInput, RefusesTallyAndStartByName) {
  const auto made = [](std::vector<TallyJoint> tally, WeldPositioningStart start) {
    return refusal([&] { WeldPositioning({}, tally, start); });
  };
  for (const double length : {0.0, -12.0, kNaN, kInfinity}) {
    auto tally = fingerprint(5);
    tally[3].length = length;
    EXPECT_THAT(made(tally, {}), testing::StartsWith("tally[3].length: "));
  }
  auto tally = fingerprint(5);
  tally[2].standard_deviation = -0.1;
  EXPECT_THAT(made(tally, {}), testing::StartsWith("tally[2].standard_deviation: -0.1"));
  tally = fingerprint(5);
  EXPECT_THAT(made(tally, at_joint(5, 1.0)), HasSubstr("start.joint: 5 is outside [0, 5)"));
  EXPECT_THAT(made(tally, at_joint(1, kNaN)), testing::StartsWith("start.distance: nan"));
  EXPECT_THAT(made(tally, at_joint(1, 1.0, Orientation::kUnknown)),
              testing::StartsWith("start.orientation"));
  EXPECT_THAT(made(tally, {.orientation = static_cast<Orientation>(7)}),
              HasSubstr("start.orientation: 7 is outside {0, 1, 2}"));
  auto start = at_joint(1, 1.0);
  start.distance_standard_deviation = 0.0;
  EXPECT_THAT(made(tally, start), testing::StartsWith("start.distance_standard_deviation: 0"));
  EXPECT_THAT(made({}, {}), testing::StartsWith("start.joint_known"));
}

TEST(WeldPositioningInput, NamesItsStates) {
  EXPECT_STREQ(to_string(PositioningStatus::kAccepted), "accepted");
  EXPECT_STREQ(to_string(PositioningStatus::kBadValue), "bad value");
  EXPECT_STREQ(to_string(PositioningStatus::kOutOfOrder), "out of order");
  EXPECT_STREQ(to_string(static_cast<PositioningStatus>(9)), "unknown");
  EXPECT_STREQ(to_string(Orientation::kForward), "forward");
  EXPECT_STREQ(to_string(Orientation::kBackward), "backward");
  EXPECT_STREQ(to_string(Orientation::kUnknown), "unknown");
}

}  // namespace
}  // namespace pipescout::odometry
