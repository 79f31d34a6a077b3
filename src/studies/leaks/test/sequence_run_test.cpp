// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/sequence_run.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace pipescout::leak_study {
namespace {

/// One short row.
SequencePlan short_plan(std::uint64_t seed) {
  const CampaignSettings settings{
      .sequences = 1, .faint_leaks = 1, .other_leaks = 0, .decoys = 0, .length = 24};
  return plan_campaign(settings, seed).front();
}

TEST(SequenceRun, FindsAFaintLeakOnceAndInItsPlace) {
  const SequencePlan plan = short_plan(1);
  const SequenceScore score = run_sequence(plan, {}, 1);
  // 24 m at 5.5 m/s and 25 Hz.
  EXPECT_NEAR(static_cast<double>(score.frames), 109, 4);
  EXPECT_EQ(score.frame_faults, 0U);
  ASSERT_EQ(score.found.size(), 1U);
  EXPECT_TRUE(score.found[0]);
  EXPECT_EQ(score.false_findings(), 0U);
  ASSERT_EQ(score.findings.size(), 1U);
  const FindingScore& finding = score.findings[0];
  EXPECT_TRUE(finding.first);
  EXPECT_LE(finding.frames_to_raise, 3U);
  EXPECT_LT(finding.position_error, 0.6);
  EXPECT_NEAR(finding.mean_delta, plan.patrol.scene.leaks[0].rise, 15);
  EXPECT_NEAR(finding.length, plan.patrol.scene.leaks[0].length, 0.1);
  EXPECT_LT(finding.level_square, 20);
}

CampaignSettings one_leak_in_a_world_not_as_told(bool automatic_gain) {
  return {.sequences = 1,
          .faint_leaks = 1,
          .near_leaks = 0,
          .other_leaks = 0,
          .decoys = 0,
          .length = 24,
          .drawn_radiometry = true,
          .automatic_gain = automatic_gain};
}

TEST(SequenceRun, ByContrastFindsALeakWhereWhatIsToldIsWrong) {
  InspectionSettings inspection;
  inspection.by_contrast = true;
  constexpr std::size_t kSequences = 8;
  CampaignScore sum;
  for (std::uint64_t seed = 1; seed <= kSequences; ++seed) {
    const SequencePlan plan = plan_campaign(one_leak_in_a_world_not_as_told(false), seed).front();
    const SequenceScore score = run_sequence(plan, inspection, seed);
    ASSERT_EQ(score.found.size(), 1U);
    EXPECT_TRUE(score.found[0]) << seed;
    EXPECT_EQ(score.false_findings(), 0U) << seed;
    ASSERT_EQ(score.findings.size(), 1U);
    // Neither so narrow that it claims what nobody knows, nor so wide that it says nothing.
    const FindingScore& finding = score.findings[0];
    EXPECT_GT(finding.delta_interval.high, 1.5 * finding.delta_interval.low) << seed;
    EXPECT_LT(finding.delta_interval.high, 5 * finding.delta_interval.low) << seed;
    sum.add(plan, score);
  }
  // Of the tube and of the leak in each. An interval of 95 % may miss where the emissivity is at
  // the end of its range: with 16 intervals more than 3 do so once in a hundred times.
  EXPECT_EQ(sum.intervals, 2 * kSequences);
  EXPECT_GE(sum.covering, 2 * kSequences - 3);
}

TEST(SequenceRun, InVideoWithAutomaticGainALeakIsFoundWithoutDegrees) {
  InspectionSettings inspection;
  inspection.by_contrast = true;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SequencePlan plan = plan_campaign(one_leak_in_a_world_not_as_told(true), seed).front();
    const SequenceScore score = run_sequence(plan, inspection, seed);
    ASSERT_EQ(score.found.size(), 1U);
    EXPECT_TRUE(score.found[0]) << seed;
    EXPECT_EQ(score.false_findings(), 0U) << seed;
    ASSERT_FALSE(score.findings.empty());
    EXPECT_TRUE(std::isnan(score.findings[0].mean_delta));
    EXPECT_TRUE(std::isnan(score.tube.mean));
  }
}

TEST(SequenceRun, WarmPostsAreNoLeaksHoweverTheRangeIsKnown) {
  for (const auto source :
       {leak_findings::RangeSource::kLine, leak_findings::RangeSource::kDiameter}) {
    InspectionSettings settings;
    settings.findings.range_source = source;
    for (const std::uint64_t seed : {7U, 13U}) {
      SequencePlan plan = short_plan(seed);
      plan.patrol.scene.leaks.clear();
      // Beside the joints: with one of these a post is as long as a leak.
      for (const double place : {4.25, 7.9, 12.3, 16.0, 20.5}) {
        plan.patrol.scene.decoys.push_back({.kind = simulation::ThermalDecoyKind::kWarmSupport,
                                            .place = place,
                                            .size = 0.18,
                                            .rise = 50});
      }
      EXPECT_TRUE(run_sequence(plan, settings, seed).findings.empty())
          << to_string(source) << ", seed " << seed;
    }
  }
}

TEST(SequenceRun, ReflectionsThatPassAlongAreNoLeaksHoweverTheRangeIsKnown) {
  for (const auto source :
       {leak_findings::RangeSource::kLine, leak_findings::RangeSource::kDiameter}) {
    InspectionSettings settings;
    settings.findings.range_source = source;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      SequencePlan plan = short_plan(seed);
      plan.grey = false;
      plan.patrol.scene.leaks.clear();
      plan.patrol.scene.decoys.push_back({.kind = simulation::ThermalDecoyKind::kPassingReflection,
                                          .place = 12,
                                          .size = 0.35,
                                          .rise = 110,
                                          .reach = 5,
                                          .follow = 0.35});
      EXPECT_TRUE(run_sequence(plan, settings, seed).findings.empty())
          << to_string(source) << ", seed " << seed;
    }
  }
}

/// How wide the tube looks beside how wide one of its diameter is at its true range, less 1.
class WidthErrors final : public CameraCarrier {
 public:
  explicit WidthErrors(const SequencePlan& plan) : plan_(plan) {}

  void step(simulation::ThermalPatrol& patrol) override { patrol_ = &patrol; }
  geometry::SE3 T_base_camera() const override { return plan_.patrol.T_body_camera; }
  void see(const leak_findings::Frame& frame, const thermal::Detections& detections) override {
    const geometry::SE3 T_map_camera = patrol_->view(frame.number).T_map_camera;
    const geometry::Camera& camera = patrol_->renderer().camera();
    const Eigen::Vector3d from = T_map_camera.inverse() * patrol_->scene().on_tube(0);
    const Eigen::Vector3d along =
        (T_map_camera.inverse() * patrol_->scene().on_tube(1) - from).normalized();
    for (const thermal::PipeSection& pipe : detections.pipes) {
      const Eigen::Vector3d ray = camera.ray(0.5 * (pipe.start + pipe.end))->normalized();
      const Eigen::Vector3d normal = ray.cross(along);
      if (std::abs(from.dot(normal)) > 0.1 * normal.norm() || !(pipe.width > 0)) {
        continue;  // a post, or the border cuts it lengthwise
      }
      const double depth = ray.z() * from.cross(along).dot(normal) / normal.squaredNorm();
      const double expected =
          camera.parameters().focal_length * 2 * plan_.patrol.scene.tube_radius / depth;
      errors.push_back(pipe.width / expected - 1);
    }
  }

  std::vector<double> errors{};

 private:
  const SequencePlan& plan_;
  simulation::ThermalPatrol* patrol_ = nullptr;
};

/// docs/papers/leaks.md tells these figures.
TEST(SequenceRun, TheWidthOfTheTubeTellsItsRange) {
  InspectionSettings settings;
  settings.findings.range_source = leak_findings::RangeSource::kDiameter;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SequencePlan plan = short_plan(seed);
    plan.grey = false;
    WidthErrors widths(plan);
    ASSERT_GT(run_sequence(plan, settings, seed, &widths).frames, 100U);
    std::vector<double>& errors = widths.errors;
    ASSERT_GT(errors.size(), 90U);
    const double mean =
        std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    const auto wide = std::ranges::count_if(errors, [](double e) { return std::abs(e) > 0.01; });
    EXPECT_LT(std::abs(mean), 0.002) << seed;
    EXPECT_LE(wide, std::ssize(errors) / 10) << seed;
  }
}

TEST(SequenceRun, IsTheSameForTheSameSeed) {
  const SequencePlan plan = short_plan(2);
  const SequenceScore first = run_sequence(plan, {}, 5);
  const SequenceScore again = run_sequence(plan, {}, 5);
  const SequenceScore other = run_sequence(plan, {}, 6);
  ASSERT_FALSE(first.findings.empty());
  ASSERT_EQ(first.findings.size(), again.findings.size());
  EXPECT_EQ(first.findings[0].position_error, again.findings[0].position_error);
  ASSERT_FALSE(other.findings.empty());
  EXPECT_NE(first.findings[0].position_error, other.findings[0].position_error);
}

/// Looks into the sky from the middle of the row on.
class Nodding final : public CameraCarrier {
 public:
  explicit Nodding(const SequencePlan& plan)
      : T_base_camera_(plan.patrol.T_body_camera), middle_(plan.patrol.scene.length / 2) {}

  void step(simulation::ThermalPatrol& patrol) override {
    ++steps;
    if (patrol.place() > middle_) {
      T_base_camera_ = simulation::T_body_side_camera(T_base_camera_.translation(), 0.8);
    }
    patrol.move_camera(T_base_camera_, geometry::Vector6d::Zero());
  }
  [[nodiscard]] geometry::SE3 T_base_camera() const override { return T_base_camera_; }
  void see(const leak_findings::Frame& frame, const thermal::Detections& detections) override {
    EXPECT_TRUE(frame.pose && frame.T_base_camera);
    pictures_of_pipes += detections.pipes.empty() ? 0 : 1;
  }

  std::size_t steps = 0;
  std::size_t pictures_of_pipes = 0;

 private:
  geometry::SE3 T_base_camera_;
  double middle_;  // m
};

TEST(SequenceRun, WhatCarriesTheCameraDecidesWhatIsSeen) {
  const SequencePlan plan = short_plan(1);
  const SequenceScore fixed = run_sequence(plan, {}, 1);
  EXPECT_GT(fixed.metres_seen, 0.95 * fixed.metres);
  Nodding carrier(plan);
  const SequenceScore nodding = run_sequence(plan, {}, 1, &carrier);
  EXPECT_EQ(nodding.frames, fixed.frames);
  EXPECT_GT(carrier.steps, 10 * nodding.frames);
  // Half of the row, and what is seen ahead of it.
  EXPECT_GT(nodding.metres_seen, 0.4 * fixed.metres);
  EXPECT_LT(nodding.metres_seen, 0.8 * fixed.metres);
  EXPECT_GT(carrier.pictures_of_pipes, nodding.frames / 3);
  EXPECT_LT(carrier.pictures_of_pipes, 2 * nodding.frames / 3);
}

TEST(SequenceRun, NamesWhatIsWrong) {
  InspectionSettings settings;
  settings.frame_rate = 0;
  EXPECT_THROW(static_cast<void>(run_sequence(short_plan(1), settings, 1)), std::invalid_argument);
  settings = {};
  settings.pose.tilt_time = 0;
  EXPECT_THROW(static_cast<void>(run_sequence(short_plan(1), settings, 1)), std::invalid_argument);
}

TEST(CampaignScore, CountsFirstFindingsOfLeaksAndTheOthers) {
  SequencePlan plan;
  plan.faint_leaks = 1;
  SequenceScore score{.frames = 100, .metres = 150, .found = {true, false, true}};
  score.findings = {{.leak = 0, .position_error = 0.1, .level_square = 1, .square = 2},
                    {.leak = 0, .first = false, .position_error = 2},
                    {.leak = 2, .position_error = 0.5, .level_square = 6.1, .square = 7.5},
                    {.place = 70}};
  EXPECT_EQ(score.false_findings(), 2U);
  CampaignScore sum;
  sum.add(plan, score);
  CampaignScore twice = sum;
  twice += sum;
  EXPECT_EQ(twice.sequences, 2U);
  EXPECT_EQ(twice.leaks, 6U);
  EXPECT_EQ(twice.found, 4U);
  EXPECT_EQ(twice.faint_leaks, 2U);
  EXPECT_EQ(twice.faint_found, 2U);
  EXPECT_EQ(twice.false_findings, 4U);
  EXPECT_EQ(twice.position_errors.size(), 4U);
  EXPECT_NEAR(twice.found_percent(), 66.67, 0.01);
  EXPECT_DOUBLE_EQ(twice.level_coverage_percent(), 50);
  EXPECT_DOUBLE_EQ(twice.coverage_percent(), 100);
}

}  // namespace
}  // namespace pipescout::leak_study
