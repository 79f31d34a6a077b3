// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "drive_helpers.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings {
namespace {

using test::Drive;
using test::drive;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class LeakFindingsFaults : public testing::Test {
 protected:
  LeakFindingsFaults() { world_.spots = {{10, 0.3, 90}}; }

  void TearDown() override {
    // What follows is fine.
    drive(findings_, world_, 0, 20, 1000);
    ASSERT_EQ(findings_.findings().size(), 1U);
    EXPECT_TRUE(findings_.findings()[0].position);
  }
  [[nodiscard]] std::size_t counted(InputFault fault) const {
    return findings_.counters().faults[static_cast<std::size_t>(fault)];
  }

  Drive world_;
  LeakFindings findings_{Drive::parameters(), Drive::camera()};
};

TEST_F(LeakFindingsFaults, TimeGoingBackAndNan) {
  EXPECT_EQ(findings_.update(world_.frame(5, 10), world_.look(10)).fault, InputFault::kNone);
  for (const double time : {5.0, 4.9, kNan}) {
    const FrameResult& result = findings_.update(world_.frame(time, 10), world_.look(10));
    EXPECT_EQ(result.fault, InputFault::kBadTime);
    EXPECT_EQ(result.finding_of, std::vector<std::uint64_t>{0});
  }
  EXPECT_EQ(counted(InputFault::kBadTime), 3U);
  EXPECT_EQ(findings_.counters().frames, 4U);
}

TEST_F(LeakFindingsFaults, AFrameWithoutDetections) {
  thermal::Detections d = world_.look(10);
  d.fault = thermal::FrameFault::kSaturated;
  EXPECT_EQ(findings_.update(world_.frame(0, 10), d).fault, InputFault::kNoDetections);
  EXPECT_EQ(counted(InputFault::kNoDetections), 1U);
  EXPECT_TRUE(findings_.candidates().empty());
}

TEST_F(LeakFindingsFaults, APictureOfAnotherSize) {
  thermal::Detections d = world_.look(10);
  d.width = 640;
  EXPECT_EQ(findings_.update(world_.frame(0, 10), d).fault, InputFault::kBadSize);
}

TEST_F(LeakFindingsFaults, PosesThatAreNotFinite) {
  Frame frame = world_.frame(0, 10);
  frame.pose->covariance(3, 3) = kNan;
  EXPECT_EQ(findings_.update(frame, world_.look(10)).fault, InputFault::kBadPose);
  EXPECT_EQ(counted(InputFault::kBadPose), 1U);
}

TEST_F(LeakFindingsFaults, CovariancesThatAreNone) {
  Frame frame = world_.frame(0, 10);
  frame.pose->covariance(0, 1) = 0.001;  // not symmetric
  EXPECT_EQ(findings_.update(frame, world_.look(10)).fault, InputFault::kBadCovariance);
  frame = world_.frame(5, 10);  // too late to follow it in the picture
  frame.pose->covariance(2, 2) = -1;
  EXPECT_EQ(findings_.update(frame, world_.look(10)).fault, InputFault::kBadCovariance);
  frame = world_.frame(10, 10);
  frame.pose->covariance(0, 1) = frame.pose->covariance(1, 0) = 0.5;  // correlated beyond 1
  EXPECT_EQ(findings_.update(frame, world_.look(10)).fault, InputFault::kBadCovariance);
  EXPECT_EQ(counted(InputFault::kBadCovariance), 3U);
}

TEST_F(LeakFindingsFaults, StoredFindingsThatMakeNoSense) {
  Finding good;
  good.id = 7;
  good.state = FindingState::kRaised;
  good.probability = 0.99;
  Finding candidate = good;
  candidate.state = FindingState::kCandidate;
  Finding nameless = good;
  nameless.id = 0;
  Finding nan = good;
  nan.id = 8;
  nan.position = MapPosition{};
  nan.position->point.x() = kNan;
  LeakFindings findings(Drive::parameters(), Drive::camera());
  EXPECT_EQ(findings.restore(std::vector{candidate, nameless, nan, good, good}), 1U);
  ASSERT_EQ(findings.findings().size(), 1U);
  EXPECT_NE(findings.find(7), nullptr);
  EXPECT_EQ(findings.find(8), nullptr);
  // Ids go on behind those that are known.
  drive(findings, world_, 0, 20, 0);
  EXPECT_NE(findings.find(8), nullptr);
}

TEST(LeakFindingsLimits, CandidatesAndFindingsAreBounded) {
  LeakFindingsParameters p = Drive::parameters();
  p.max_candidates = 2;
  p.max_findings = 1;
  Drive world;
  world.spots = {{9, 0.3, 90}, {10, 0.3, 90}, {11, 0.3, 90}};
  LeakFindings findings(p, Drive::camera());
  drive(findings, world, 0, 20, 0);
  EXPECT_EQ(findings.findings().size(), 1U);
  EXPECT_LE(findings.candidates().size(), 2U);
  EXPECT_GT(findings.counters().findings_refused + findings.counters().candidates_dropped, 0U);
}

TEST(LeakFindingsLimits, PassesAreBounded) {
  LeakFindingsParameters p = Drive::parameters();
  p.max_passes = 3;
  Drive world;
  world.spots = {{10, 0.3, 90}};
  LeakFindings findings(p, Drive::camera());
  for (int pass = 0; pass < 6; ++pass) {
    drive(findings, world, 5, 15, 100.0 * pass);
  }
  ASSERT_EQ(findings.findings().size(), 1U);
  EXPECT_EQ(findings.findings()[0].passes.size(), 3U);
  EXPECT_EQ(findings.findings()[0].pass_count, 6U);
}

TEST(LeakFindingsParameters, RefusalsNameTheField) {
  using Change = std::function<void(LeakFindingsParameters&)>;
  const std::vector<std::pair<const char*, Change>> changes{
      {"mounting_attitude_deviation: -1", [](auto& p) { p.mounting_attitude_deviation = -1; }},
      {"mounting_position_deviation: -1", [](auto& p) { p.mounting_position_deviation = -1; }},
      {"distance: 0", [](auto& p) { p.distance = 0; }},
      {"distance_deviation: nan", [](auto& p) { p.distance_deviation = kNan; }},
      {"pipe_diameter: 0", [](auto& p) { p.pipe_diameter = 0; }},
      {"width_deviation: 1", [](auto& p) { p.width_deviation = 1; }},
      {"lines: is empty", [](auto& p) { p.range_source = RangeSource::kLine; }},
      {"lines, length: 0",
       [](auto& p) {
         p.lines = {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
       }},
      {"line_deviation: 0", [](auto& p) { p.line_deviation = 0; }},
      {"max_range_deviation: 0", [](auto& p) { p.max_range_deviation = 0; }},
      {"pixel_deviation: 0", [](auto& p) { p.pixel_deviation = 0; }},
      {"attitude_jitter: -1", [](auto& p) { p.attitude_jitter = -1; }},
      {"position_jitter: -1", [](auto& p) { p.position_jitter = -1; }},
      {"pose_correlation_time: 0", [](auto& p) { p.pose_correlation_time = 0; }},
      {"extent_deviation: -1", [](auto& p) { p.extent_deviation = -1; }},
      {"hidden_length_deviation: 0", [](auto& p) { p.hidden_length_deviation = 0; }},
      {"delta_deviation: -1", [](auto& p) { p.delta_deviation = -1; }},
      {"prior_probability: 0", [](auto& p) { p.prior_probability = 0; }},
      {"detection_probability: 1", [](auto& p) { p.detection_probability = 1; }},
      {"clutter_probability: 0.95", [](auto& p) { p.clutter_probability = 0.95; }},
      {"raise_probability: 0.01", [](auto& p) { p.raise_probability = 0.01; }},
      {"clear_probability: 0.95", [](auto& p) { p.clear_probability = 0.95; }},
      {"gate: 0", [](auto& p) { p.gate = 0; }},
      {"extent_slack: -1", [](auto& p) { p.extent_slack = -1; }},
      {"pass_gap: 0", [](auto& p) { p.pass_gap = 0; }},
      {"update_interval: -1", [](auto& p) { p.update_interval = -1; }},
      {"max_candidates: 0", [](auto& p) { p.max_candidates = 0; }},
      {"max_findings: 0", [](auto& p) { p.max_findings = 0; }},
      {"max_passes: 1", [](auto& p) { p.max_passes = 1; }},
      {"moderate_delta: 0", [](auto& p) { p.severity.moderate_delta = 0; }},
  };
  for (const auto& [message, change] : changes) {
    LeakFindingsParameters p;
    change(p);
    EXPECT_THAT([&] { p.validate(); },
                testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith(message)));
  }
  EXPECT_EQ(to_string(InputFault::kBadPose), "bad_pose");
  EXPECT_EQ(to_string(EventKind::kCleared), "cleared");
  EXPECT_EQ(to_string(FindingState::kCandidate), "candidate");
  EXPECT_EQ(to_string(static_cast<FindingState>(9)), "unknown");
}

}  // namespace
}  // namespace pipescout::leak_findings
