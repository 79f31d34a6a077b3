// SPDX-License-Identifier: Apache-2.0
#include "tables/estimator_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {
namespace {

using geometry::SE3;
using geometry::SO3;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kDegree = std::numbers::pi / 180.0;

Time at(double seconds) {
  return Time{} + from_seconds(seconds);
}

SE3 place(double x, double y, double z, double yaw = 0.0) {
  return {SO3::about_z(yaw), {x, y, z}};
}

EstimatorReport::Estimate estimate(double time, const SE3& T_map_base, double deviation = 0.1) {
  return {.stamp = at(time),
          .T_map_base = T_map_base,
          .covariance = geometry::Matrix6d::Identity() * deviation * deviation};
}

EstimatorReport::State state(double time, const std::string& phase) {
  EstimatorReport::State message;
  message.header.stamp = to_message(at(time));
  message.phase = phase;
  return message;
}

void add_source(EstimatorReport::State& message, const std::string& name, const std::string& state,
                std::uint64_t accepted, std::uint64_t gated) {
  message.source.push_back(name);
  message.source_state.push_back(state);
  message.source_accepted.push_back(accepted);
  message.source_gated.push_back(gated);
  message.source_held.push_back(0);
  message.source_refused.push_back(0);
}

class EstimatorReportTest : public ::testing::Test {
 protected:
  double figure(const std::string& name) {
    return report_.section("").figures.at("estimator_" + name);
  }
  bool has_figure(const std::string& name) {
    return report_.section("").figures.contains("estimator_" + name);
  }

  std::vector<EstimatorReport::Error> errors_;
  EstimatorReport report_{
      [this](const EstimatorReport::Estimate& /*estimate*/, const EstimatorReport::Error& error) {
        errors_.push_back(error);
      }};
};

TEST_F(EstimatorReportTest, ErrorsAgainstTheTruthBetweenItsStamps) {
  report_.add_truth(at(1.0), place(0.0, 0.0, 3.0, 0.0));
  report_.add_estimate(estimate(1.05, place(0.8, 1.0, 3.4, 0.1 + 2.0 * kDegree)));
  EXPECT_TRUE(errors_.empty()) << "its truth is not known yet";
  report_.add_truth(at(1.1), place(1.0, 2.0, 3.0, 0.2));
  ASSERT_EQ(errors_.size(), 1U);
  EXPECT_NEAR(errors_[0].error[0], 0.3, 1e-9);
  EXPECT_NEAR(errors_[0].error[2], 0.4, 1e-9);
  EXPECT_NEAR(errors_[0].error[5], 2.0 * kDegree, 1e-9);
  EXPECT_NEAR(errors_[0].position_nees, 25.0, 1e-9);
  EXPECT_NEAR(errors_[0].pose_nees, 25.0 + std::pow(20.0 * kDegree, 2), 1e-9);
  report_.add_estimate(estimate(1.1, place(1.1, 2.0, 3.0, 0.2)));
  EXPECT_NEAR(figure("position_rmse_m"), std::sqrt((0.25 + 0.01) / 2), 1e-9);
  EXPECT_NEAR(figure("position_worst_m"), 0.5, 1e-9);
  EXPECT_NEAR(figure("position_p95_m"), 0.5, 1e-9);
  EXPECT_NEAR(figure("orientation_rmse_deg"), std::sqrt(2.0), 1e-9);
  EXPECT_EQ(figure("in_ellipsoid_percent"), 50.0);
  EXPECT_NEAR(figure("position_nees"), 13.0, 1e-4);
}

TEST_F(EstimatorReportTest, TheWholeCovarianceCounts) {
  auto tilted = estimate(1.0, place(1.0, 1.0, 0.0));
  tilted.covariance = geometry::Matrix6d::Identity();
  tilted.covariance(0, 1) = tilted.covariance(1, 0) = 0.5;
  report_.add_estimate(tilted);
  report_.add_truth(at(1.0), place(0.0, 0.0, 0.0));
  ASSERT_EQ(errors_.size(), 1U);
  EXPECT_NEAR(errors_[0].position_nees, 2.0 / 1.5, 1e-12);
  EXPECT_NEAR(errors_[0].pose_nees, 2.0 / 1.5, 1e-12);
}

TEST_F(EstimatorReportTest, ACovarianceThatIsRightIsSeenToBe) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 4000; ++k) {
    const double time = 0.1 * k;
    report_.add_truth(at(time), place(time, 0.0, 0.0));
    Eigen::Vector3d turn;
    for (double& angle : turn) {
      angle = 0.01 * normal(engine);
    }
    auto noisy = estimate(time, SE3(SO3::exp(turn), {time + 0.2 * normal(engine),
                                                     0.3 * normal(engine), 0.4 * normal(engine)}));
    noisy.covariance.setZero();
    noisy.covariance.diagonal() << 0.04, 0.09, 0.16, 1e-4, 1e-4, 1e-4;
    report_.add_estimate(noisy);
  }
  // Five standard deviations of the mean of 4000.
  EXPECT_NEAR(figure("position_nees"), 3.0, 5.0 * std::sqrt(6.0 / 4000));
  EXPECT_NEAR(figure("pose_nees"), 6.0, 5.0 * std::sqrt(12.0 / 4000));
  EXPECT_NEAR(figure("in_ellipsoid_percent"), 95.0, 500.0 * std::sqrt(0.95 * 0.05 / 4000));
}

TEST_F(EstimatorReportTest, WithoutTruthThereAreNoErrors) {
  report_.add_estimate(estimate(1.0, place(0.0, 0.0, 0.0)));
  EXPECT_FALSE(has_figure("position_rmse_m"));
  EXPECT_EQ(figure("estimates"), 1.0);
  EXPECT_THAT(report_.section("").notes, Contains(HasSubstr("No ground truth")));
}

TEST_F(EstimatorReportTest, HowLongItTookToRun) {
  auto waiting = state(0.0, "starting");
  waiting.waits_for = "a place";
  (void)report_.add_state(waiting);
  EXPECT_THAT(report_.section("").notes, IsEmpty()) << "it has not said a time";
  waiting.header.stamp = to_message(at(100.0));
  (void)report_.add_state(waiting);
  EXPECT_THAT(report_.section("").notes,
              Contains(HasSubstr("did not start; it waits for: a place")));
  (void)report_.add_state(state(101.0, "aligning"));
  EXPECT_EQ(figure("keyframes"), 0.0);
  (void)report_.add_state(state(103.5, "running"));
  (void)report_.add_state(state(104.0, "coasting"));
  (void)report_.add_state(state(105.0, "running"));
  EXPECT_EQ(figure("time_until_running_s"), 3.5);
  EXPECT_EQ(figure("keyframes"), 3.0);
}

TEST_F(EstimatorReportTest, CountsGoOnWhenTheEstimatorIsStartedAgain) {
  const auto say = [&](double time, std::uint64_t restarts, std::uint64_t accepted,
                       std::uint64_t gated) {
    auto message = state(time, "running");
    message.restarts = restarts;
    message.restart_reason = "lost";
    add_source(message, "gps", "trusted", accepted, gated);
    (void)report_.add_state(message);
  };
  say(1.0, 0, 3, 1);
  say(2.0, 2, 7, 4);
  say(3.0, 1, 2, 0);
  const auto section = report_.section("robot_1.");
  EXPECT_EQ(section.figures.at("robot_1.estimator_gps_accepted"), 9.0);
  EXPECT_EQ(section.figures.at("robot_1.estimator_gps_gated"), 4.0);
  EXPECT_EQ(section.figures.at("robot_1.estimator_restarts"), 3.0);
  EXPECT_THAT(section.notes, Contains(HasSubstr("3 times, the last time for: lost")));
}

TEST_F(EstimatorReportTest, SaysWhichSourcesAreBelievedInAnotherWay) {
  const auto say = [&](const std::string& gps, const std::string& weld) {
    auto message = state(1.0, "running");
    add_source(message, "gps", gps, 1, 0);
    add_source(message, "weld", weld, 0, 0);
    return report_.add_state(message);
  };
  EXPECT_THAT(say("absent", "absent"), ElementsAre(0U, 1U));
  EXPECT_THAT(say("absent", "absent"), IsEmpty());
  EXPECT_THAT(say("absent", "trusted"), ElementsAre(1U));
  EXPECT_THAT(say("trusted", "trusted"), ElementsAre(0U));
  const auto section = report_.section("");
  ASSERT_EQ(section.rows.size(), 2U);
  EXPECT_EQ(section.rows[0].front(), MissionCell(std::string("gps")));
  EXPECT_EQ(section.rows[0].back(), MissionCell(25.0));
  EXPECT_EQ(section.rows[1].back(), MissionCell(50.0));
}

TEST_F(EstimatorReportTest, StaysSmall) {
  auto message = state(1.0, "starting");
  add_source(message, "s", "absent", 0, 0);
  for (int k = 0; k < 100; ++k) {
    message.source[0] = "s" + std::to_string(k);
    (void)report_.add_state(message);
  }
  EXPECT_EQ(report_.section("").rows.size(), 32U);
  EXPECT_EQ(report_.section("").rows[0].back(), MissionCell());
}

}  // namespace
}  // namespace pipescout::summary
