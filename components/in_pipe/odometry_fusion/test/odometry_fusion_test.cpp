// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/odometry_fusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::OdometerReadings;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Time kStart{std::chrono::seconds(1000)};

/// First row of Table 1 of the paper, with its standard deviations.
OdometerReadings first_row() {
  OdometerReadings message;
  message.header.stamp = to_message(kStart);
  message.header.frame_id = "base_link";
  message.name = {"odometer_1", "odometer_2", "odometer_3"};
  message.distance = {5.45, 5.34, 5.36};
  message.standard_deviation = {0.06, 0.055, 0.056};
  message.valid = {true, true, true};
  return message;
}

class OdometryFusionTest : public ::testing::Test {
 protected:
  OdometryFusion& start(const std::vector<NamedParameter>& extra = {}) {
    std::vector<NamedParameter> parameters = extra;
    parameters.push_back({"offsets", std::vector<double>{0.18, 0.155, 0.165}});
    harness_.set_time(kStart);
    auto& fusion = harness_.make<OdometryFusion>({.name = "fusion", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(fusion).success);
    return fusion;
  }

  void send(const OdometerReadings& message) {
    harness_.publish(topics::kOdometerReadings, message);
    harness_.spin();
  }

  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<FusedOdometer> fused_ = harness_.collect(topics::kOdometerFused);
};

TEST_F(OdometryFusionTest, FusesThePapersFirstRow) {
  start({{"weighting", "paper_equation_13"}});
  send(first_row());
  ASSERT_EQ(fused_.size(), 1U);
  const FusedOdometer& fused = fused_.back();
  EXPECT_NEAR(fused.distance, 5.5099, 5e-5);
  EXPECT_GT(fused.variance, 0.0);
  EXPECT_EQ(fused.status, FusedOdometer::STATUS_OK);
  EXPECT_EQ(fused.header, first_row().header);
  EXPECT_EQ(fused.name, first_row().name);
  EXPECT_THAT(fused.in_fusion_set, ElementsAre(false, true, true));
  EXPECT_THAT(fused.rejection_reason,
              ElementsAre(FusedOdometer::REJECTED_UNSUPPORTED, FusedOdometer::REJECTED_NONE,
                          FusedOdometer::REJECTED_NONE));
  // r_ij, row-major: 1 and 2 are too far apart, the 3rd supports all, the 1st supports itself only.
  ASSERT_EQ(fused.support.size(), 9U);
  EXPECT_EQ(fused.support[0], 1);
  EXPECT_EQ(fused.support[1], 0);
  EXPECT_EQ(fused.support[5], 1);
  ASSERT_EQ(fused.confidence_distance.size(), 9U);
  // Row 2, column 1 of D: erf(0.11 / (sqrt(2) 0.055)).
  EXPECT_NEAR(fused.confidence_distance[3], std::erf(0.11 / (std::sqrt(2.0) * 0.055)), 1e-12);
}

TEST_F(OdometryFusionTest, WeightsBySquaredSigmaByDefault) {
  start();
  send(first_row());
  ASSERT_EQ(fused_.size(), 1U);
  const double w2 = 1.0 / (0.055 * 0.055);
  const double w3 = 1.0 / (0.056 * 0.056);
  EXPECT_NEAR(fused_.back().distance, (w2 * 5.495 + w3 * 5.525) / (w2 + w3), 1e-12);
  EXPECT_NEAR(fused_.back().variance, 1.0 / (w2 + w3), 1e-15);
}

TEST_F(OdometryFusionTest, AnswersEveryMessageInOrder) {
  start();
  for (int i = 0; i < 50; ++i) {
    OdometerReadings message = first_row();
    message.header.stamp = to_message(kStart + std::chrono::milliseconds(i));
    harness_.publish(topics::kOdometerReadings, message);
  }
  harness_.spin();
  ASSERT_EQ(fused_.size(), 50U);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(from_message(fused_.at(i).header.stamp), kStart + std::chrono::milliseconds(i));
  }
}

TEST_F(OdometryFusionTest, LeavesOutReadingsThatCannotBeUsed) {
  auto& fusion = start();
  OdometerReadings message = first_row();
  message.distance[0] = kNan;
  send(message);
  ASSERT_EQ(fused_.size(), 1U);
  EXPECT_EQ(fused_.back().rejection_reason[0], FusedOdometer::REJECTED_NOT_A_NUMBER);
  EXPECT_THAT(fused_.back().in_fusion_set, ElementsAre(false, true, true));
  EXPECT_EQ(fusion.diagnostics().counter("readings.distance.not_a_number"), 1U);

  message = first_row();
  message.standard_deviation[0] = -0.06;
  message.header.stamp.sec = 1001;
  send(message);
  EXPECT_EQ(fused_.back().rejection_reason[0], FusedOdometer::REJECTED_BAD_SIGMA);
  EXPECT_EQ(fusion.diagnostics().counter("readings.standard_deviation.not_positive"), 1U);

  message = first_row();
  message.valid[0] = false;
  message.header.stamp.sec = 1002;
  send(message);
  EXPECT_EQ(fused_.back().rejection_reason[0], FusedOdometer::REJECTED_INVALID);
  EXPECT_EQ(fusion.diagnostics().counter("readings.valid.false"), 1U);
  EXPECT_EQ(fusion.diagnostics().counter("readings.refused"), 0U);
}

TEST_F(OdometryFusionTest, SaysWhenThereIsNoConsensus) {
  auto& fusion = start();
  OdometerReadings message = first_row();
  message.distance = {1.0, 2.0, 3.0};
  send(message);
  ASSERT_EQ(fused_.size(), 1U);
  EXPECT_EQ(fused_.back().status, FusedOdometer::STATUS_NO_CONSENSUS);
  EXPECT_TRUE(std::isnan(fused_.back().distance));
  EXPECT_TRUE(std::isnan(fused_.back().variance));
  EXPECT_EQ(fusion.diagnostics().counter("no_consensus"), 1U);
}

/// A message that makes no sense as a whole, and the counter that must say so.
struct Refusal {
  const char* counter;
  std::function<void(OdometerReadings&)> spoil;
};

TEST_F(OdometryFusionTest, RefusesMessagesThatMakeNoSense) {
  auto& fusion = start();
  const std::vector<Refusal> refusals{
      {"readings.name.wrong_count", [](auto& message) { message = OdometerReadings(); }},
      {"readings.name.wrong_count",
       [](auto& message) {
         message.name = {"one"};
         message.distance = {1.0};
         message.standard_deviation = {0.1};
         message.valid = {true};
       }},
      {"readings.name.wrong_count",
       [](auto& message) {
         for (int i = 0; i < 17; ++i) {
           message.name.push_back("more_" + std::to_string(i));
         }
       }},
      {"readings.name.not_unique", [](auto& message) { message.name[1] = message.name[0]; }},
      {"readings.distance.wrong_size", [](auto& message) { message.distance.pop_back(); }},
      {"readings.distance.wrong_size", [](auto& message) { message.distance.push_back(1.0); }},
      {"readings.valid.wrong_size", [](auto& message) { message.valid.clear(); }},
      {"readings.standard_deviation.wrong_size",
       [](auto& message) { message.standard_deviation.clear(); }},
      {"readings.standard_deviation.wrong_size",
       [](auto& message) { message.standard_deviation.pop_back(); }},
      {"readings.name.unlike_offsets",
       [](auto& message) {
         message.name.push_back("odometer_4");
         message.distance.push_back(5.4);
         message.standard_deviation.push_back(0.06);
         message.valid.push_back(true);
       }},
  };
  std::uint64_t refused = 0;
  for (const Refusal& refusal : refusals) {
    const auto before = fusion.diagnostics().counter(refusal.counter);
    OdometerReadings message = first_row();
    refusal.spoil(message);
    send(message);
    EXPECT_EQ(fusion.diagnostics().counter(refusal.counter), before + 1) << refusal.counter;
    EXPECT_EQ(fusion.diagnostics().counter("readings.refused"), ++refused) << refusal.counter;
    EXPECT_TRUE(fused_.empty()) << refusal.counter;
  }
  EXPECT_EQ(fusion.state(), LifecycleState::kActive);
  send(first_row());
  EXPECT_EQ(fused_.size(), 1U);
}

TEST_F(OdometryFusionTest, TellsFaultsOnDiagnostics) {
  auto& fusion = start();
  OdometerReadings message = first_row();
  message.distance.pop_back();
  send(message);
  // A change of level is told at once.
  const auto status = harness_.diagnostics(fusion).back();
  EXPECT_EQ(status.level, static_cast<std::uint8_t>(DiagnosticLevel::kWarn));
  EXPECT_EQ(ComponentHarness::value(status, "readings.distance.wrong_size"), "1");
}

TEST_F(OdometryFusionTest, LogsAFaultOnce) {
  start();
  OdometerReadings message = first_row();
  message.distance.pop_back();
  for (int i = 0; i < 5; ++i) {
    send(message);
  }
  int told = 0;
  for (const auto& entry : harness_.logs()) {
    told += entry.text.find("readings.distance.wrong_size") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(told, 1);
}

TEST_F(OdometryFusionTest, StandsInForMissingStandardDeviations) {
  auto& fusion = start({{"standard_deviations", std::vector<double>{0.06, 0.055, 0.056}}});
  send(first_row());
  OdometerReadings message = first_row();
  message.header.stamp.sec = 1001;
  message.standard_deviation.clear();
  send(message);
  ASSERT_EQ(fused_.size(), 2U);
  EXPECT_EQ(fused_.at(0).distance, fused_.at(1).distance);
  EXPECT_EQ(fused_.at(0).variance, fused_.at(1).variance);

  ASSERT_TRUE(
      harness_.set_parameter(fusion, "standard_deviations", std::vector<double>{0.06, 0.055})
          .successful);
  send(message);
  EXPECT_EQ(fused_.size(), 2U);
  EXPECT_EQ(fusion.diagnostics().counter("readings.standard_deviation.missing"), 1U);
}

TEST_F(OdometryFusionTest, InsistsOnTheExpectedOdometers) {
  auto& fusion =
      start({{"odometers", std::vector<std::string>{"odometer_1", "odometer_2", "odometer_3"}}});
  send(first_row());
  EXPECT_EQ(fused_.size(), 1U);
  OdometerReadings message = first_row();
  message.name = {"odometer_2", "odometer_1", "odometer_3"};
  send(message);
  EXPECT_EQ(fused_.size(), 1U);
  EXPECT_EQ(fusion.diagnostics().counter("readings.name.unexpected"), 1U);
}

TEST_F(OdometryFusionTest, CountsStrangeStampsAndFusesAllTheSame) {
  auto& fusion = start();
  const auto send_at = [this](Time stamp) {
    OdometerReadings message = first_row();
    message.header.stamp = to_message(stamp);
    send(message);
  };
  send_at(kStart - std::chrono::milliseconds(1100));
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.stale"), 1U);
  send_at(kStart + std::chrono::milliseconds(200));
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.in_future"), 1U);
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.not_increasing"), 0U);
  send_at(kStart);
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.not_increasing"), 1U);
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.stale"), 1U);
  EXPECT_EQ(fused_.size(), 3U);

  ASSERT_TRUE(harness_.set_parameter(fusion, "maximum_age", 0.0).successful);
  send_at(Time{});
  EXPECT_EQ(fusion.diagnostics().counter("readings.header.stamp.stale"), 1U);
}

TEST_F(OdometryFusionTest, ParametersTakeEffectAtOnce) {
  auto& fusion = start();
  send(first_row());
  ASSERT_TRUE(harness_.set_parameter(fusion, "epsilon", 0.97).successful);
  ASSERT_TRUE(harness_.set_parameter(fusion, "offsets", std::vector<double>{}).successful);
  send(first_row());
  ASSERT_EQ(fused_.size(), 2U);
  EXPECT_THAT(fused_.at(0).in_fusion_set, ElementsAre(false, true, true));
  EXPECT_THAT(fused_.at(1).in_fusion_set, ElementsAre(true, true, true));
  EXPECT_LT(fused_.at(1).distance, 5.45);
}

TEST_F(OdometryFusionTest, RefusesParametersWithTheAlgorithmsReason) {
  auto& fusion = start();
  const auto refuse = [&](const char* name, const ParameterValue& value, const char* reason) {
    const auto before = fusion.parameters().get(name);
    const SetResult result = harness_.set_parameter(fusion, name, value);
    EXPECT_FALSE(result.successful) << name;
    EXPECT_THAT(result.reason, HasSubstr(reason));
    EXPECT_EQ(fusion.parameters().get(name), before);
  };
  refuse("epsilon", 1.0, "epsilon");
  refuse("epsilon", 1.5, "1.5");
  refuse("epsilon", kNan, "nan");
  refuse("epsilon", 1, "integer");
  refuse("weighting", "equal", "'maximum_likelihood' or 'paper_equation_13'");
  refuse("support_rule", "none", "'majority' or 'mutual_majority'");
  refuse("offsets", std::vector<double>{0.1, kNan}, "offsets");
  refuse("offsets", std::vector<double>(17, 0.0), "offsets");
  refuse("offsets", std::vector<double>(1, 0.0), "offsets");
  refuse("standard_deviations", std::vector<double>{0.1, -0.1}, "-0.1");
  send(first_row());
  EXPECT_EQ(fused_.size(), 1U);
}

TEST_F(OdometryFusionTest, RefusesOverridesWithTheAlgorithmsReason) {
  try {
    harness_.make<OdometryFusion>({.parameters = {{"epsilon", 0.0}}});
    FAIL() << "epsilon = 0 was taken";
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), HasSubstr("epsilon"));
  }
}

/// The node that listens for the test.
const std::vector<std::string> kPeer{"_component_harness"};

TEST(OdometryFusionStart, SubscribesOnceTheNamedNodeListens) {
  ComponentHarness harness;
  auto& fusion = harness.make<OdometryFusion>({.parameters = {{"wait_for_subscribers", kPeer}}});
  ASSERT_TRUE(harness.bring_up(fusion).success);
  EXPECT_TRUE(fusion.subscriptions().empty());
  {
    const auto fused = harness.collect(topics::kOdometerFused);
    harness.spin();
    EXPECT_EQ(fusion.subscriptions().size(), 1U);
    harness.publish(topics::kOdometerReadings, first_row());
    harness.spin();
    EXPECT_EQ(fused.size(), 1U);
  }
  // Who once listened may go: the fusion goes on.
  harness.spin();
  EXPECT_EQ(fusion.subscriptions().size(), 1U);
}

TEST(OdometryFusionStart, WaitsForThoseThatWereNamedWhenItWasConfigured) {
  ComponentHarness harness;
  auto& fusion = harness.make<OdometryFusion>({.parameters = {{"wait_for_subscribers", kPeer}}});
  ASSERT_TRUE(harness.bring_up(fusion).success);
  ASSERT_TRUE(
      harness.set_parameter(fusion, "wait_for_subscribers", std::vector<std::string>{"other"})
          .successful);
  const auto fused = harness.collect(topics::kOdometerFused);
  harness.spin();
  EXPECT_EQ(fusion.subscriptions().size(), 1U);
}

TEST(OdometryFusionStart, CanBeCleanedUpAndStartedAgain) {
  ComponentHarness harness;
  auto& fusion = harness.make<OdometryFusion>();
  const auto fused = harness.collect(topics::kOdometerFused);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(harness.bring_up(fusion).success);
    harness.publish(topics::kOdometerReadings, first_row());
    harness.spin();
    ASSERT_TRUE(harness.deactivate(fusion).success);
    ASSERT_TRUE(harness.cleanup(fusion).success);
  }
  EXPECT_EQ(fused.size(), 3U);
  EXPECT_TRUE(harness.shutdown(fusion).success);
}

}  // namespace
}  // namespace pipescout
