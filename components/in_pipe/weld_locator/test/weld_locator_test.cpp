// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_locator/weld_locator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::BendDetection;
using pipescout_msgs::msg::EddyCurrentSamples;
using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::PipePosition;
using pipescout_msgs::msg::WeldDetection;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kSpeed = 0.5;         // m/s
constexpr double kSampleRate = 200.0;  // Hz

/// A pipe whose joints nobody could mix up, and what a probe with a little noise sees of it.
class WeldLocatorTest : public ::testing::Test {
 protected:
  WeldLocatorTest() {
    std::mt19937_64 engine(1);
    std::normal_distribution<double> length(12.0, 0.12);
    std::string text = "id,joint_length_m,joint_length_sd_m\n";
    double chainage = 0.0;
    for (int i = 0; i <= 40; ++i) {
      welds_.push_back(chainage);
      const double joint = length(engine);
      chainage += joint;
      text +=
          "W" + std::to_string(i) + (i < 40 ? "," + std::to_string(joint) + ",0.01" : ",,") + "\n";
    }
    std::ofstream(tally_) << text;
  }

  WeldLocator& start(std::vector<NamedParameter> parameters = {}) {
    parameters.push_back({"tally", tally_});
    return start_without_tally(parameters);
  }
  WeldLocator& start_without_tally(const std::vector<NamedParameter>& parameters) {
    harness_.set_time(kStart);
    auto& locator = harness_.make<WeldLocator>({.name = "locator", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(locator).success);
    return locator;
  }

  /// m along the pipe, at a time of the run.
  [[nodiscard]] double chainage(double time) const { return start_ + kSpeed * time; }

  static FusedOdometer fused(double time, double distance) {
    FusedOdometer message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.header.frame_id = "base_link";
    message.distance = distance;
    message.variance = 1e-6 * std::abs(distance) + 1e-8;
    message.independent_variance = 1e-6 * std::abs(distance);
    message.scale = {1.0, 1.0};
    return message;
  }

  /// A tenth of a second from `time` on.
  EddyCurrentSamples samples(double time) {
    EddyCurrentSamples message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.header.frame_id = "probe";
    message.sample_interval = 1.0 / kSampleRate;
    message.channels = 1;
    for (int k = 0; k < 20; ++k) {
      const double at = chainage(time + k / kSampleRate);
      double value = 0.0;
      for (const double weld : welds_) {
        const double u = (at - weld) / 0.0133;
        value += std::exp(-(u - 1.5) * (u - 1.5) / 2.0) - std::exp(-(u + 1.5) * (u + 1.5) / 2.0);
      }
      message.x.push_back(value + noise_(engine_));
      message.y.push_back(noise_(engine_));
    }
    return message;
  }

  /// The pipe has joints of one length, and bends by which the tally tells where it is.
  void lay_equal_joints(const std::vector<double>& bends) {
    std::string text = "id,kind,angle_deg,chainage_m\n";
    for (std::size_t i = 0; i < welds_.size(); ++i) {
      welds_[i] = 12.0 * static_cast<double>(i);
      text += "W" + std::to_string(i) + ",weld,," + std::to_string(welds_[i]) + "\n";
    }
    for (const double bend : bends) {
      text += "B" + std::to_string(bend) + ",bend,45," + std::to_string(bend) + "\n";
    }
    std::ofstream(tally_) << text;
  }
  /// With its middle at a chainage.
  [[nodiscard]] BendDetection bend(double chainage) const {
    BendDetection message;
    message.header.stamp = to_message(kStart + from_seconds(time_));
    message.distance = chainage - start_;
    message.standard_deviation = 0.15;
    message.length = 3.0;
    message.angle = 0.8;
    message.angle_standard_deviation = 0.03;
    message.probability = 1.0;
    return message;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  /// The drive goes on for so many seconds.
  void drive(double seconds) {
    for (const double end = time_ + seconds; time_ < end; time_ += 0.1) {
      harness_.set_time(kStart + from_seconds(time_ + 0.1));
      send(topics::kEddyCurrent, samples(time_));
      send(topics::kOdometerFused, fused(time_, kSpeed * time_));
    }
  }

  testing::TemporaryFolder folder_;
  const std::string tally_ = folder_.path() / "tally.csv";
  std::vector<double> welds_;  // m, chainages
  double start_ = 100.0;       // m, chainage
  double time_ = 0.0;          // s
  std::mt19937_64 engine_{2};
  std::normal_distribution<double> noise_{0.0, 0.05};
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<WeldDetection> welds_seen_ = harness_.collect(topics::kWeld);
  testing::Collector<PipePosition> positions_ = harness_.collect(topics::kPipePosition);
};

TEST_F(WeldLocatorTest, FindsOutWhereItIs) {
  start();
  drive(300.0);
  ASSERT_GT(welds_seen_.size(), 10U);
  ASSERT_FALSE(positions_.empty());
  const PipePosition& position = positions_.back();
  EXPECT_TRUE(position.known);
  EXPECT_TRUE(position.locked);
  EXPECT_GT(position.joint_probability, 0.999);
  const double time = to_seconds(from_message(position.header.stamp) - kStart);
  const double truth = chainage(time);
  EXPECT_NEAR(position.chainage, truth, 0.05);
  ASSERT_LT(position.joint + 1, welds_.size());
  EXPECT_NEAR(position.distance_into_joint, truth - welds_[position.joint], 0.05);
  EXPECT_EQ(position.orientation, 0);
  EXPECT_NEAR(position.scale, 1.0, 0.005);
  EXPECT_EQ(position.header.frame_id, "probe");
  EXPECT_GT(position.covariance[0], 0.0);
  EXPECT_LT(position.covariance[0], 0.01);

  std::size_t recognised = 0;
  for (const auto& message : welds_seen_.messages()) {
    const double passed = to_seconds(from_message(message->header.stamp) - kStart);
    EXPECT_NEAR(kSpeed * passed, message->distance, 1e-3);
    if (message->weld < 0) {
      EXPECT_TRUE(std::isnan(message->chainage));
      continue;
    }
    ++recognised;
    const auto weld = static_cast<std::size_t>(message->weld);
    EXPECT_EQ(message->weld_id, "W" + std::to_string(weld));
    EXPECT_NEAR(message->chainage, welds_[weld], 1e-4);
    EXPECT_NEAR(chainage(passed), welds_[weld], 0.01);
    if (!std::isnan(message->spacing)) {
      const double since = to_seconds(from_message(message->spacing_since) - kStart);
      EXPECT_NEAR(message->spacing, kSpeed * (passed - since), 0.02);
      EXPECT_EQ(message->spacing_joints, 1U);
      EXPECT_GE(message->spacing_standard_deviation, 0.01);
    }
  }
  EXPECT_GE(recognised, 5U);
}

TEST_F(WeldLocatorTest, LearnsATallyWithoutOne) {
  const std::string learnt = folder_.path() / "learnt.csv";
  start_ = 2.0;
  auto& locator =
      start_without_tally({{"start.joint", 0}, {"start.distance", 2.0}, {"learnt_tally", learnt}});
  drive(200.0);
  EXPECT_TRUE(positions_.back().locked);
  EXPECT_LT(welds_seen_.back().weld, 0);
  ASSERT_TRUE(harness_.deactivate(locator).success);
  const Tally tally = read_tally(learnt);
  ASSERT_GE(tally.joints.size(), 5U);
  for (std::size_t j = 1; j < 5; ++j) {
    const double chainage = tally.chainages[j];
    const auto nearest = std::min_element(welds_.begin(), welds_.end(), [&](double a, double b) {
      return std::abs(a - chainage) < std::abs(b - chainage);
    });
    EXPECT_NEAR(*nearest, chainage, 0.1);
  }
}

TEST_F(WeldLocatorTest, BendsTellEqualJointsApart) {
  lay_equal_joints({130.0, 180.0, 400.0});
  auto& locator = start();
  drive(80.0);
  EXPECT_FALSE(positions_.back().locked);
  send(topics::kBend, bend(130.0));
  drive(100.0);
  send(topics::kBend, bend(180.0));
  drive(60.0);
  EXPECT_TRUE(positions_.back().locked);
  const double time = to_seconds(from_message(positions_.back().header.stamp) - kStart);
  EXPECT_NEAR(positions_.back().chainage, chainage(time), 0.1);
  EXPECT_EQ(locator.diagnostics().take().values.at("positioning.unexplained_bends"), "0");
}

TEST_F(WeldLocatorTest, CountsBendsThatItCannotUseAndGoesOn) {
  lay_equal_joints({130.0, 180.0});
  auto& locator = start();
  send(topics::kBend, bend(130.0));
  EXPECT_EQ(locator.diagnostics().counter("bend.unknown_place"), 1U);  // nothing is measured yet
  drive(70.0);
  BendDetection message = bend(130.0);
  message.distance = kNan;
  send(topics::kBend, message);
  EXPECT_EQ(locator.diagnostics().counter("bend.unknown_place"), 2U);
  for (const double angle : {kNan, -0.5, 4.0}) {
    message = bend(130.0);
    message.angle = angle;
    send(topics::kBend, message);
  }
  message = bend(130.0);
  message.standard_deviation = 0.0;
  send(topics::kBend, message);
  EXPECT_EQ(locator.diagnostics().counter("bend.not_positioned"), 4U);
  EXPECT_EQ(locator.state(), LifecycleState::kActive);
}

/// A spoilt message and the counter that must say so.
template <class T>
struct Fault {
  const char* counter;
  std::function<void(T&)> spoil;
};

TEST_F(WeldLocatorTest, CountsSamplesThatItCannotUseAndGoesOn) {
  auto& locator = start();
  drive(5.0);
  const std::vector<Fault<EddyCurrentSamples>> faults{
      {"eddy_current.channels.unexpected", [](auto& message) { message.channels = 0; }},
      {"eddy_current.channels.unexpected", [](auto& message) { message.channels = 2; }},
      {"eddy_current.x.wrong_size", [](auto& message) { message.x.clear(); }},
      {"eddy_current.y.wrong_size", [](auto& message) { message.y.pop_back(); }},
      {"eddy_current.sample_interval.bad_value",
       [](auto& message) { message.sample_interval = 0; }},
      {"eddy_current.sample_interval.bad_value",
       [](auto& message) { message.sample_interval = -0.005; }},
      {"eddy_current.sample_interval.bad_value",
       [](auto& message) { message.sample_interval = kNan; }},
      {"eddy_current.sample_interval.bad_value",
       [](auto& message) { message.sample_interval = 1e9; }},
      {"eddy_current.header.stamp.not_increasing",
       [](auto& message) { message.header.stamp = to_message(kStart + from_seconds(4.0)); }},
  };
  std::uint64_t refused = 0;
  for (const auto& fault : faults) {
    const auto before = locator.diagnostics().counter(fault.counter);
    EddyCurrentSamples message = samples(time_);
    fault.spoil(message);
    send(topics::kEddyCurrent, message);
    EXPECT_EQ(locator.diagnostics().counter(fault.counter), before + 1) << fault.counter;
    EXPECT_EQ(locator.diagnostics().counter("eddy_current.refused"), ++refused);
  }
  EddyCurrentSamples holes = samples(time_);
  holes.x[3] = kNan;
  holes.y[4] = std::numeric_limits<double>::infinity();
  send(topics::kEddyCurrent, holes);
  EXPECT_EQ(locator.diagnostics().counter("eddy_current.refused"), refused);
  time_ += 0.1;
  EXPECT_EQ(locator.state(), LifecycleState::kActive);
  drive(100.0);
  EXPECT_GE(welds_seen_.size(), 3U);
}

TEST_F(WeldLocatorTest, CountsDistancesThatItCannotUseAndGoesOn) {
  auto& locator = start();
  drive(5.0);
  const auto published = positions_.size();
  const std::vector<Fault<FusedOdometer>> faults{
      {"fused.distance.not_a_number", [](auto& message) { message.distance = kNan; }},
      {"fused.variance.bad_value", [](auto& message) { message.variance = kNan; }},
      {"fused.variance.bad_value", [](auto& message) { message.variance = -1.0; }},
      {"fused.scale.bad_value",
       [](auto& message) {
         message.scale = {1.0, 0.0};
       }},
      {"fused.scale.bad_value", [](auto& message) { message.scale = {kNan}; }},
      {"fused.header.stamp.not_increasing",
       [](auto& message) { message.header.stamp = to_message(kStart + from_seconds(4.0)); }},
  };
  for (const auto& fault : faults) {
    const auto before = locator.diagnostics().counter(fault.counter);
    FusedOdometer message = fused(time_, kSpeed * time_);
    fault.spoil(message);
    send(topics::kOdometerFused, message);
    EXPECT_EQ(locator.diagnostics().counter(fault.counter), before + 1) << fault.counter;
  }
  EXPECT_EQ(positions_.size(), published);
  FusedOdometer leap = fused(time_, 1e5);
  send(topics::kOdometerFused, leap);
  EXPECT_EQ(locator.diagnostics().counter("fused.distance.implausible"), 1U);
  time_ += 0.1;
  drive(100.0);
  EXPECT_EQ(locator.state(), LifecycleState::kActive);
  EXPECT_GE(welds_seen_.size(), 3U);
}

TEST_F(WeldLocatorTest, SaysWhenAMessageIsFromAnotherTime) {
  auto& locator = start();
  drive(5.0);
  harness_.set_time(kStart + std::chrono::seconds(60));
  send(topics::kOdometerFused, fused(time_, kSpeed * time_));
  EXPECT_GE(locator.diagnostics().counter("fused.header.stamp.stale"), 1U);
  send(topics::kOdometerFused, fused(100.0, kSpeed * time_));
  EXPECT_EQ(locator.diagnostics().counter("fused.header.stamp.in_future"), 1U);
  // A clock that was set back by a minute and more: that time counts from then on.
  send(topics::kOdometerFused, fused(10.0, kSpeed * time_));
  EXPECT_EQ(locator.diagnostics().counter("fused.header.stamp.leap"), 1U);
  send(topics::kOdometerFused, fused(10.1, kSpeed * time_));
  EXPECT_EQ(locator.diagnostics().counter("fused.header.stamp.not_increasing"), 0U);
}

TEST_F(WeldLocatorTest, NoticesDeadPublishersAndKeepsItsMemory) {
  auto& locator = start();
  drive(5.0);
  for (int i = 0; i < 12; ++i) {
    harness_.advance(std::chrono::seconds(1));
  }
  EXPECT_GE(locator.diagnostics().counter("fused.silent"), 1U);
  EXPECT_GE(locator.diagnostics().counter("eddy_current.silent"), 1U);
  // Samples without an odometer wait, but not for ever.
  for (int i = 0; i < 1100; ++i) {
    send(topics::kEddyCurrent, samples(20.0 + 0.1 * i));
  }
  // 1000 can wait, and one was waiting already.
  EXPECT_EQ(locator.diagnostics().counter("eddy_current.without_odometer"), 101U);
}

std::string refusal(const std::vector<NamedParameter>& parameters) {
  ComponentHarness harness;
  auto& locator = harness.make<WeldLocator>({.parameters = parameters});
  const auto result = harness.configure(locator);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST_F(WeldLocatorTest, NamesWhatIsWrongWithItsParameters) {
  EXPECT_THAT(refusal({{"tally", "/no/such/tally.csv"}}), HasSubstr("/no/such/tally.csv"));
  EXPECT_THAT(refusal({}), HasSubstr("joint_known"));
  EXPECT_THAT(refusal({{"tally", tally_}, {"start.joint", 40}}), HasSubstr("joint"));
  EXPECT_THAT(refusal({{"tally", tally_}, {"start.orientation", "up"}}), HasSubstr("'up'"));
  EXPECT_THAT(refusal({{"tally", tally_}, {"weld.smallest_width", 0.5}}),
              HasSubstr("largest_width"));
  const std::string bad = folder_.path() / "bad.csv";
  std::ofstream(bad) << "id,joint_length_m\nA,12\nB,0\nC,\n";
  EXPECT_THAT(refusal({{"tally", bad}}), HasSubstr("bad.csv:3: column"));
}

TEST_F(WeldLocatorTest, CanBeCleanedUpAndStartedAgain) {
  auto& locator = start();
  for (int i = 0; i < 3; ++i) {
    drive(30.0);
    ASSERT_TRUE(harness_.deactivate(locator).success);
    ASSERT_TRUE(harness_.cleanup(locator).success);
    ASSERT_TRUE(harness_.bring_up(locator).success);
  }
  EXPECT_TRUE(harness_.shutdown(locator).success);
}

}  // namespace
}  // namespace pipescout
