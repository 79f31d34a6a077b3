// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <pipescout/rack_vision/visual_servo.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/leak_findings/rack_lines.hpp"
#include "pipescout/leak_inspector/leak_inspector.hpp"
#include "pipescout/leak_inspector/rack_offsets.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/simulation/rack_thermal.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using pipescout_msgs::msg::LeakEvent;
using pipescout_msgs::msg::LeakFinding;
using pipescout_msgs::msg::RackState;
using sensor_msgs::msg::Image;
using simulation::HotSpot;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kPeriod = 0.2;  // s
constexpr double kSpeed = 0.25;  // m/s
constexpr double kHeight = 2.6;  // m
const std::vector<double> kOffsets{0, 0.012, -0.008, 0.015, 0};
const Eigen::Vector3d kCameraPosition(0.08, -0.05, 0.02);

geometry::CameraParameters thermal_camera() {
  geometry::CameraParameters camera;
  camera.width = 320;
  camera.height = 240;
  camera.focal_length = 280;
  camera.centre_u = 159.5;
  camera.centre_v = 119.5;
  return camera;
}

/// Of the file, and as it truly is.
rack_vision::RackModel rack(const std::vector<double>& offsets) {
  rack_vision::RackModel model = read_rack(RACK_FILE);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    model.pipes[i].start.x() += offsets[i];
  }
  return model;
}

/// A UAV over the rack whose pose is known, with hot spots on its pipes.
class LeakInspectorRackTest : public ::testing::Test {
 protected:
  explicit LeakInspectorRackTest(std::vector<double> offsets = kOffsets)
      : offsets_(std::move(offsets)), true_rack_(rack(offsets_)) {
    harness_.set_time(kStart);
  }

  void start(const std::vector<HotSpot>& spots, std::vector<NamedParameter> more = {}) {
    simulation::RackThermalScene scene;
    scene.model = true_rack_;
    scene.hot_spots = spots;
    scene.warm_ground = {{.middle = {-0.6, 4.5}, .radius = 0.3, .temperature = 45}};
    renderer_.emplace(scene, geometry::Camera(thermal_camera()));
    std::vector<NamedParameter> parameters{
        {"preset", "hot_pipes"},
        {"threshold_rule", "fixed"},
        {"threshold", 22.0},
        {"leak_delta", std::vector<double>{6.0}},
        {"min_part_length", 0.12},
        {"camera.linear",
         std::vector<double>{simulation::kRackThermalGain, simulation::kRackThermalOffset}},
        {"camera.position",
         std::vector<double>{kCameraPosition.x(), kCameraPosition.y(), kCameraPosition.z()}},
        {"range.source", "lines"},
        {"rack", std::string(RACK_FILE)}};
    for (NamedParameter& parameter : more) {
      std::erase_if(parameters, [&](const auto& known) { return known.name == parameter.name; });
      parameters.push_back(parameter);
    }
    auto& inspector = harness_.make<LeakInspector>({.name = "inspector", .parameters = parameters});
    const auto result = harness_.bring_up(inspector);
    ASSERT_TRUE(result.success) << result.message;
    send(topics::kThermalCameraInfo, to_message(thermal_camera()));
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  /// As `launch_scripts/rack.yaml` has it: along the flow, looking forward, and swaying.
  [[nodiscard]] SE3 body(double y) const {
    const double sway = 0.03 * std::sin(7 * y);
    return {SO3::from_roll_pitch_yaw({sway, -0.5 * sway, std::numbers::pi / 2}),
            {0.9 + sway, y, kHeight}};
  }

  void send_odometry(const SE3& T_map_base) {
    nav_msgs::msg::Odometry message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "map";
    message.child_frame_id = "base_link";
    message.pose.pose = to_message(T_map_base);
    geometry::Matrix6d covariance = geometry::Matrix6d::Identity();
    covariance.topLeftCorner<3, 3>() *= 1e-4;
    covariance.bottomRightCorner<3, 3>() *= 1e-5;
    message.pose.covariance = to_message(covariance);
    send(topics::kOdometryFiltered, message);
  }

  void send_offsets() {
    RackState message;
    message.header.stamp = to_message(now_);
    message.status = RackState::STATUS_TRACKING;
    for (const rack_vision::Pipe& pipe : true_rack_.pipes) {
      message.pipe.push_back(pipe.name);
    }
    message.offset = offsets_;
    send(topics::kRackState, message);
  }

  void send_picture(const SE3& T_map_base) {
    const geometry::CameraParameters camera = thermal_camera();
    counts_.resize(static_cast<std::size_t>(camera.width * camera.height));
    renderer_->render(T_map_base * rack_vision::downward_camera(kCameraPosition), frame_++,
                      counts_);
    Image message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "thermal_optical";
    message.width = static_cast<std::uint32_t>(camera.width);
    message.height = static_cast<std::uint32_t>(camera.height);
    message.step = 2 * message.width;
    message.encoding = "mono16";
    message.data.resize(2 * counts_.size());
    std::memcpy(message.data.data(), counts_.data(), message.data.size());
    send(topics::kThermalImage, message);
  }

  void fly(double from, double to) {
    for (double y = from; y < to; y += kSpeed * kPeriod) {
      now_ += from_seconds(kPeriod);
      harness_.set_time(now_);
      send_odometry(body(y));
      send_offsets();
      send_picture(body(y));
    }
  }

  /// Raised, as the last event of each says.
  [[nodiscard]] std::vector<LeakFinding> findings() const {
    std::map<std::uint64_t, LeakFinding> last;
    for (const auto& event : events_.messages()) {
      last[event->finding.id] = event->finding;
    }
    std::vector<LeakFinding> result;
    for (const auto& [id, finding] : last) {
      if (finding.state == "raised") {
        result.push_back(finding);
      }
    }
    return result;
  }

  /// m, of the nearest finding.
  [[nodiscard]] double error_of(const HotSpot& spot) const {
    const Eigen::Vector3d place = place_of(spot, true_rack_);
    double least = std::numeric_limits<double>::infinity();
    for (const LeakFinding& finding : findings()) {
      const Eigen::Vector3d found(finding.position.x, finding.position.y, finding.position.z);
      least = std::min(least, (found - place).norm());
    }
    return least;
  }

  std::vector<double> offsets_;
  rack_vision::RackModel true_rack_;
  std::optional<simulation::RackThermalRenderer> renderer_;
  std::vector<std::uint16_t> counts_;
  std::uint64_t frame_ = 0;
  Time now_ = kStart;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<LeakEvent> events_ = harness_.collect(topics::kLeakEvents);
};

TEST_F(LeakInspectorRackTest, PlacesHotSpotsOnThePipes) {
  const std::vector<HotSpot> spots{
      {.pipe = 0, .along = 4.2, .azimuth = 0.4, .length = 0.35, .half_angle = 0.8, .rise = 25},
      {.pipe = 2, .along = 5.3, .azimuth = -0.3, .length = 0.5, .half_angle = 0.6, .rise = 18},
      {.pipe = 3, .along = 3.6, .azimuth = 0, .length = 0.8, .half_angle = 3.14, .rise = 12}};
  start(spots);
  fly(3.6, 6.0);
  EXPECT_EQ(findings().size(), spots.size());
  for (const HotSpot& spot : spots) {
    EXPECT_LT(error_of(spot), 0.06) << "pipe " << spot.pipe;
  }
  for (const LeakFinding& finding : findings()) {
    EXPECT_LT(std::sqrt(finding.position_covariance[0]), 0.1);
  }
}

TEST_F(LeakInspectorRackTest, SoundPipesOfDifferentTemperaturesRaiseNothing) {
  start({});
  fly(3.6, 7.4);  // below the pipe that crosses too, and past warm ground
  EXPECT_TRUE(findings().empty());
}

TEST_F(LeakInspectorRackTest, APipeThatCrossesAndHidesAHotSpotDoesNotClearIt) {
  const HotSpot spot{.pipe = 2, .along = 5.9, .length = 0.3, .half_angle = 0.8, .rise = 25};
  start({spot});
  fly(5.0, 7.2);
  ASSERT_EQ(findings().size(), 1U);
  EXPECT_LT(error_of(spot), 0.06);
}

TEST_F(LeakInspectorRackTest, FindsHotSpotsOfThePipeThatCrossesTheOthers) {
  // Over the gap between the first two pipes, and over the third.
  const std::vector<HotSpot> spots{
      {.pipe = 4, .along = 4.5, .azimuth = 0.3, .length = 0.3, .half_angle = 0.7, .rise = 15},
      {.pipe = 4, .along = 5.4, .length = 0.5, .half_angle = 3.14, .rise = 10}};
  start(spots);
  fly(5.2, 7.8);
  const std::vector<LeakFinding> found = findings();
  ASSERT_EQ(found.size(), spots.size());
  EXPECT_LT(error_of(spots[0]), 0.06);
  // Warm all round: it is on the side that was seen last.
  const rack_vision::Pipe& pipe = true_rack_.pipes[4];
  const Eigen::Vector3d middle = pipe.start + spots[1].along * pipe.direction;
  const LeakFinding& all_round = found[0].position.x > found[1].position.x ? found[0] : found[1];
  const Eigen::Vector3d off =
      Eigen::Vector3d(all_round.position.x, all_round.position.y, all_round.position.z) - middle;
  EXPECT_LT(std::abs(off.x()), 0.06);
  EXPECT_NEAR(off.tail<2>().norm(), pipe.largest_radius(), 0.03);
  EXPECT_GT(off.z(), 0);
}

TEST_F(LeakInspectorRackTest, OffsetsOfThePipesMoveTheFindings) {
  offsets_ = {0, 0, 0.06, 0.08, 0};
  true_rack_ = rack(offsets_);
  const HotSpot spot{
      .pipe = 3, .along = 4.4, .azimuth = -0.3, .length = 0.3, .half_angle = 0.6, .rise = 25};
  start({spot}, {{"range.line_deviation", 0.02}});
  fly(3.8, 5.0);
  ASSERT_EQ(findings().size(), 1U);
  EXPECT_LT(error_of(spot), 0.05);
}

TEST(RackLines, AreTheSectionsMovedByTheirOffsets) {
  const rack_vision::RackModel model = rack({});
  RackState state;
  state.pipe = {"P4", "P2", "P3"};
  state.offset = {0.02, 0.01, std::nan("")};
  const std::vector<double> offsets = rack_offsets(model, state);
  EXPECT_EQ(offsets, (std::vector<double>{0, 0.01, 0, 0.02, 0}));
  const auto filed = leak_findings::rack_lines(model, {});
  const auto moved = leak_findings::rack_lines(model, offsets);
  ASSERT_EQ(filed.size(), 7U);  // P1 has three
  ASSERT_EQ(moved.size(), filed.size());
  EXPECT_EQ(filed[0].radius, 0.15);
  EXPECT_EQ(filed[1].radius, 0.175);
  EXPECT_EQ(filed[2].radius, 0.20);
  EXPECT_NEAR(moved[3].from.x() - filed[3].from.x(), 0.01, 1e-12);
  EXPECT_NEAR(moved[5].to.x() - filed[5].to.x(), 0.02, 1e-12);
}

TEST(LeakInspectorRack, NamesWhatIsWrong) {
  const auto refusal = [](std::vector<NamedParameter> parameters) {
    ComponentHarness harness;
    auto& inspector = harness.make<LeakInspector>({.parameters = std::move(parameters)});
    const auto result = harness.configure(inspector);
    EXPECT_FALSE(result.success);
    return result.message;
  };
  EXPECT_THAT(refusal({{"rack", "/no/such.yaml"}}), HasSubstr("/no/such.yaml"));
  EXPECT_THAT(refusal({{"rack", std::string(RACK_FILE)}}), HasSubstr("'range.source' is not"));
  EXPECT_THAT(refusal({{"rack", std::string(RACK_FILE)},
                       {"range.source", "lines"},
                       {"pictures_folder", "/tmp/pictures"}}),
              HasSubstr("'pictures_folder'"));
}

}  // namespace
}  // namespace pipescout
