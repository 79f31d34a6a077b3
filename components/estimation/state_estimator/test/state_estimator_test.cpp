// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/state_estimator.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/map_origin.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::NavSatFix;
using ::testing::AllOf;
using testing::ComponentHarness;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kGravity = 9.81;
constexpr double kStill = 4;  // s at the start
const geometry::LocalFrame kMap({47.0, 8.0, 400.0});

std::vector<NamedParameter> with(std::vector<NamedParameter> parameters,
                                 std::vector<NamedParameter> more) {
  parameters.insert(parameters.end(), more.begin(), more.end());
  return parameters;
}

/// A robot that stands, then drives round a circle of 20 m on a plane, and its perfect sensors.
class Drive {
 public:
  static constexpr double kSpeed = 2;
  static constexpr double kRadius = 20;

  [[nodiscard]] static double distance(double time) {
    const double since = std::max(0.0, time - kStill);
    return since < 2 ? kSpeed * since * since / 4 : kSpeed * (since - 1);
  }
  [[nodiscard]] static double speed(double time) {
    return kSpeed * std::clamp((time - kStill) / 2, 0.0, 1.0);
  }
  [[nodiscard]] static SE3 pose(double time) {
    const double angle = distance(time) / kRadius;
    return {SO3::about_z(angle), {kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)), 0}};
  }
  [[nodiscard]] static Imu imu(double time) {
    Imu message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.header.frame_id = "imu";
    message.orientation_covariance[0] = -1;
    message.angular_velocity.z = speed(time) / kRadius;
    message.linear_acceleration.x = time > kStill && time < kStill + 2 ? kSpeed / 2 : 0;
    message.linear_acceleration.y = speed(time) * speed(time) / kRadius;
    message.linear_acceleration.z = kGravity;
    return message;
  }
  [[nodiscard]] static NavSatFix fix(double time) {
    const geometry::GeodeticPosition place = kMap.geodetic(pose(time).translation());
    NavSatFix message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.latitude = place.latitude;
    message.longitude = place.longitude;
    message.altitude = place.altitude;
    message.position_covariance = {0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.16};
    message.position_covariance_type = sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
    return message;
  }
  [[nodiscard]] static pipescout_msgs::msg::FusedOdometer odometer(double time) {
    pipescout_msgs::msg::FusedOdometer message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.distance = distance(time);
    message.variance = 1e-6 * distance(time);
    message.independent_variance = 1e-6 * distance(time);
    return message;
  }
};

class StateEstimatorTest : public ::testing::Test {
 protected:
  StateEstimatorTest() { harness_.set_time(kStart); }

  StateEstimator& start(const std::vector<NamedParameter>& parameters = {}) {
    auto& estimator =
        harness_.make<StateEstimator>({.name = "estimator", .parameters = parameters});
    const auto result = harness_.bring_up(estimator);
    EXPECT_TRUE(result.success) << result.message;
    return estimator;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  /// From `from` to `to` s: the IMU 100 times a second, wheels 20, GPS 5.
  void drive(double from, double to, bool with_gps = true) {
    for (int i = static_cast<int>(std::lround(100 * from)); i < std::lround(100 * to); ++i) {
      const double time = 0.01 * i;
      harness_.set_time(kStart + from_seconds(time));
      send(topics::kImu, Drive::imu(time));
      if (i % 5 == 0) {
        send(topics::kOdometerFused, Drive::odometer(time));
      }
      if (with_gps && i % 20 == 0) {
        send(topics::kGpsFix, Drive::fix(time));
      }
    }
  }

  /// IMU readings of a base that stands, by their numbers, 100 a second; with every fourth one the
  /// pose of the camera in the rack, if it is seen.
  void stand(int first, int end, const std::optional<SE3>& T_rack_camera = std::nullopt) {
    for (int i = first; i < end; ++i) {
      const Time time = kStart + from_seconds(0.01 * i);
      harness_.set_time(time);
      Imu imu = Drive::imu(0);
      imu.header.stamp = to_message(time);
      send(topics::kImu, imu);
      if (T_rack_camera && i % 4 == 0) {
        geometry_msgs::msg::PoseWithCovarianceStamped pose;
        pose.header.stamp = imu.header.stamp;
        pose.header.frame_id = "rack";
        pose.pose.pose = to_message(*T_rack_camera);
        pose.pose.covariance =
            to_message(geometry::Matrix6d(1e-5 * geometry::Matrix6d::Identity()));
        send(topics::kRackPose, pose);
      }
    }
  }

  /// 3 s of fixes at 10 Hz, those of the first second at that latitude.
  template <class Latitude>
  void stand_with_first_fixes(Latitude&& latitude) {
    for (int i = 0; i < 30; ++i) {
      const Time stamp = kStart + from_seconds(0.1 * i);
      harness_.set_time(stamp);
      NavSatFix fix = Drive::fix(0);
      fix.header.stamp = to_message(stamp);
      if (i < 10) {
        fix.latitude = latitude(i);
        fix.longitude = 0;
      }
      send(topics::kGpsFix, fix);
    }
  }
  void expect_near_the_origin() {
    ASSERT_FALSE(odometry_.empty());
    constexpr double kCircle = 50;  // m, more than twice the radius
    EXPECT_LT(from_message(odometry_.back().pose.pose).translation().norm(), kCircle);
  }

  [[nodiscard]] static std::vector<NamedParameter> known_datum() {
    return {{"datum", std::vector<double>{47.0, 8.0, 400.0}}};
  }
  [[nodiscard]] static std::vector<NamedParameter> known_start() {
    return with(known_datum(), {{"start.position", std::vector<double>{0.0, 0.0, 0.0}},
                                {"start.position_deviation", 0.1},
                                {"start.heading", std::vector<double>{0.0, 0.05}}});
  }

  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<nav_msgs::msg::Odometry> odometry_ =
      harness_.collect(topics::kOdometryFiltered);
  testing::Collector<pipescout_msgs::msg::EstimatorState> states_ =
      harness_.collect(topics::kEstimatorState);
  testing::Collector<tf2_msgs::msg::TFMessage> transforms_ = harness_.collect(topics::kTf);
};

TEST_F(StateEstimatorTest, TellsWhereTheMapIsOnTheEarthOnceAKeyframe) {
  start(with(known_start(), {{"map_frame", "m"}}));
  drive(0, 8);
  std::size_t told = 0;
  for (const auto& message : transforms_.messages()) {
    if (const auto origin = map_origin(*message)) {
      ++told;
      EXPECT_NEAR(origin->latitude, 47.0, 1e-9);
      EXPECT_NEAR(origin->longitude, 8.0, 1e-9);
      EXPECT_NEAR(origin->altitude, 400.0, 1e-6);
      EXPECT_TRUE(std::ranges::any_of(message->transforms, [](const auto& sent) {
        return sent.child_frame_id == "earth" && sent.header.frame_id == "m";
      }));
    }
  }
  EXPECT_GT(told, 0U);
  EXPECT_LE(told, states_.size());
}

TEST_F(StateEstimatorTest, TellsTheOriginThatTheFixesGive) {
  start({});
  drive(0, 20);
  std::optional<geometry::GeodeticPosition> origin;
  for (const auto& message : transforms_.messages()) {
    const auto told = map_origin(*message);
    origin = told ? told : origin;
  }
  ASSERT_TRUE(origin.has_value());
  EXPECT_NEAR(origin->latitude, Drive::fix(0).latitude, 1e-5);
}

TEST_F(StateEstimatorTest, FindsPlaceAndHeadingFromMotionWithGps) {
  start(known_datum());
  drive(0, 20);
  ASSERT_FALSE(odometry_.empty());
  const auto& last = odometry_.back();
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_EQ(last.child_frame_id, "base_link");
  const SE3 error = Drive::pose(19.99).inverse() * from_message(last.pose.pose);
  EXPECT_LT(error.translation().norm(), 0.1);
  EXPECT_LT(error.rotation().log().norm(), 0.02);
  EXPECT_NEAR(last.twist.twist.linear.x, Drive::kSpeed, 0.02);
  EXPECT_NEAR(last.twist.twist.linear.y, 0, 0.02);
  EXPECT_NEAR(last.twist.twist.angular.z, Drive::kSpeed / Drive::kRadius, 1e-3);
  EXPECT_NO_THROW((void)covariance_from_message(last.pose.covariance));
  EXPECT_NO_THROW((void)covariance_from_message(last.twist.covariance));
  EXPECT_EQ(states_.back().phase, "running");
}

TEST_F(StateEstimatorTest, PublishesAtTheRateOfTheImu) {
  start(known_start());
  // A reading that leaps from the one before, as at 6 s, waits for the next one.
  drive(0, 7);
  const std::size_t before = odometry_.size();
  drive(7, 8);
  EXPECT_EQ(odometry_.size() - before, 100U);
  const auto& messages = odometry_.messages();
  EXPECT_EQ(to_seconds(from_message(messages.back()->header.stamp) - kStart), 7.99);
}

TEST_F(StateEstimatorTest, PublishesLessOftenWhenAsked) {
  start(with(known_start(), {{"publish_period", 0.05}}));
  drive(0, 7);
  const std::size_t before = odometry_.size();
  drive(7, 8);
  EXPECT_EQ(odometry_.size() - before, 20U);
}

TEST_F(StateEstimatorTest, InputsAreHeardOnceTheNamedNodeListensToTheState) {
  start({{"wait_for_subscribers.odometry", std::vector<std::string>{"recorder"}}});
  drive(0, 1);
  EXPECT_TRUE(states_.empty());
  Node recorder({.context = harness_.context().shared_from_this(),
                 .executor = &harness_.executor(),
                 .name = {"/", "recorder"}});
  std::size_t recorded = 0;
  const auto subscription = recorder.create_subscription(
      topics::kOdometryFiltered, [&](const nav_msgs::msg::Odometry&) { ++recorded; });
  harness_.spin();
  drive(1, 12);
  EXPECT_FALSE(odometry_.empty());
  EXPECT_EQ(recorded, odometry_.messages().size());
}

TEST_F(StateEstimatorTest, SaysWhatItWaitsFor) {
  start(known_datum());
  drive(0, 3, false);
  ASSERT_FALSE(states_.empty());
  EXPECT_EQ(states_.back().phase, "aligning");
  EXPECT_FALSE(states_.back().waits_for.empty());
  EXPECT_TRUE(odometry_.empty());
  // In its own frame it knows where it is.
  ASSERT_FALSE(transforms_.empty());
  ASSERT_EQ(transforms_.back().transforms.size(), 1U);
  EXPECT_EQ(transforms_.back().transforms[0].header.frame_id, "odom");
}

TEST_F(StateEstimatorTest, TransformsAgreeWithTheState) {
  start(with(known_start(), {{"map_frame", "m"},
                             {"odom_frame", "robot/odom"},
                             {"base_frame", "robot/base"},
                             {"imu.position", std::vector<double>{0.5, 0.0, 0.3}}}));
  drive(0, 8);
  const auto& sent = transforms_.back().transforms;
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent[0].header.frame_id, "m");
  EXPECT_EQ(sent[0].child_frame_id, "robot/odom");
  EXPECT_EQ(sent[1].child_frame_id, "robot/base");
  const auto read = [](const geometry_msgs::msg::TransformStamped& message) {
    geometry_msgs::msg::Pose pose;
    pose.orientation = message.transform.rotation;
    pose.position.x = message.transform.translation.x;
    pose.position.y = message.transform.translation.y;
    pose.position.z = message.transform.translation.z;
    return from_message(pose);
  };
  const SE3 chained = read(sent[0]) * read(sent[1]);
  EXPECT_LT((chained.inverse() * from_message(odometry_.back().pose.pose)).log().norm(), 1e-9);
}

TEST_F(StateEstimatorTest, GoesOnWithoutGps) {
  start(known_start());
  drive(0, 8);
  drive(8, 40, false);
  const SE3 error = Drive::pose(39.99).inverse() * from_message(odometry_.back().pose.pose);
  EXPECT_LT(error.translation().norm(), 0.01 * Drive::distance(40));
  EXPECT_GT(states_.back().since_absolute_position, 30);
}

TEST_F(StateEstimatorTest, TellsThatReadingsOfTheImuAreMissing) {
  const StateEstimator& estimator = start(known_start());
  drive(0, 8);
  EXPECT_EQ(estimator.diagnostics().counter("imu.gap"), 0U);
  drive(8.8, 12);
  EXPECT_EQ(estimator.diagnostics().counter("imu.gap"), 1U);
  EXPECT_EQ(states_.back().phase, "running");
  EXPECT_EQ(states_.back().restarts, 0U);
}

TEST_F(StateEstimatorTest, ShowsWhichMeasurementsItBelieves) {
  start(known_start());
  drive(0, 10);
  NavSatFix wrong = Drive::fix(10);
  wrong.latitude = wrong.latitude + 0.001;  // 111 m
  send(topics::kGpsFix, wrong);
  states_.clear();
  drive(10, 10.3, false);
  bool gated = false;
  for (const auto& state : states_.messages()) {
    ASSERT_EQ(state->factor.size(), state->factor_outcome.size());
    ASSERT_EQ(state->factor.size(), state->factor_chi_square.size());
    for (std::size_t i = 0; i < state->factor.size(); ++i) {
      if (state->factor[i] == "gps") {
        gated = gated || (state->factor_outcome[i] == "gated" && state->factor_weight[i] == 0 &&
                          state->factor_chi_square[i] > 100);
      }
    }
  }
  EXPECT_TRUE(gated);
  const SE3 error = Drive::pose(10.29).inverse() * from_message(odometry_.back().pose.pose);
  EXPECT_LT(error.translation().norm(), 0.2);
}

TEST_F(StateEstimatorTest, TakesTheRackPoseThroughTheCamera) {
  const SE3 T_base_camera(SO3::from_roll_pitch_yaw({M_PI, 0, -M_PI_2}), {0.1, 0.0, -0.2});
  start({{"preset", "uav"},
         {"camera.position", std::vector<double>{0.1, 0.0, -0.2}},
         {"rack.position", std::vector<double>{5.0, 0.0, 0.0}}});
  const SE3 T_map_base(SO3(), {6, 2, 3});
  stand(0, 400, SE3(SO3(), {5, 0, 0}).inverse() * T_map_base * T_base_camera);
  ASSERT_FALSE(odometry_.empty());
  EXPECT_LT((T_map_base.inverse() * from_message(odometry_.back().pose.pose)).log().norm(), 0.01);
  EXPECT_EQ(states_.back().phase, "running");
  // A localizer that has lost the rack is told where the camera is.
  const auto hints = harness_.collect(topics::kRackPoseHint);
  pipescout_msgs::msg::RackState lost;
  lost.status = pipescout_msgs::msg::RackState::STATUS_LOST;
  send(topics::kRackState, lost);
  stand(400, 420);
  ASSERT_EQ(hints.size(), 1U);
  const SE3 hinted = from_message(hints.back().pose.pose);
  EXPECT_LT((hinted.translation() - Eigen::Vector3d(1.1, 2, 2.8)).norm(), 0.02);
  EXPECT_NO_THROW((void)covariance_from_message(hints.back().pose.covariance));
}

TEST_F(StateEstimatorTest, SaysWhatIsKnownOfTheCameraThatItCalibrates) {
  auto& estimator = start({{"preset", "uav"},
                           {"camera.position_deviation", 0.03},
                           {"camera.rotation_deviation", 0.02}});
  const SE3 T_map_base(SO3(), {1, 2, 3});
  stand(0, 400, T_map_base * SE3(SO3::from_roll_pitch_yaw({M_PI, 0, -M_PI_2}), {}));
  EXPECT_EQ(states_.back().phase, "running");
  EXPECT_THAT(estimator.diagnostics().take().values.at("visual_pose.camera"),
              HasSubstr("the motion so far does not determine: x (+-"));
}

TEST_F(StateEstimatorTest, HintsOfThePoseAreOfTheCameraWhereItWasFoundToBe) {
  start({{"preset", "uav"}, {"camera.rotation_deviation", 0.02}});
  const auto hints = harness_.collect(topics::kRackPoseHint);
  // Against gravity the camera hangs askew by one standard deviation.
  const SE3 T_map_camera(SO3::from_roll_pitch_yaw({M_PI + 0.02, 0, -M_PI_2}), {1, 2, 3});
  stand(0, 800, T_map_camera);
  pipescout_msgs::msg::RackState lost;
  lost.status = pipescout_msgs::msg::RackState::STATUS_LOST;
  send(topics::kRackState, lost);
  stand(800, 820);
  ASSERT_FALSE(hints.messages().empty());
  EXPECT_LT((T_map_camera.inverse() * from_message(hints.back().pose.pose)).log().norm(), 5e-3);
}

TEST_F(StateEstimatorTest, NamesErrorsOfGpsThatStayAlikeForLongerThanTold) {
  auto& estimator = start(with(known_start(), {{"gps.correlation_time", 0.2}}));
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  constexpr double kDeviation = 20;  // m, as the fixes state: slow to follow
  const double kept = std::exp(-0.2 / 3.0);
  Eigen::Vector2d error(normal(engine), normal(engine));
  for (int i = 0; i < 12'000; ++i) {
    const double time = 0.02 * i;
    harness_.set_time(kStart + from_seconds(time));
    send(topics::kImu, Drive::imu(time));
    send(topics::kOdometerFused, Drive::odometer(time));
    if (i % 10 == 0) {
      const Eigen::Vector2d drawn(normal(engine), normal(engine));
      error = kept * error + std::sqrt(1 - kept * kept) * drawn;
      const Eigen::Vector2d off = kDeviation * error;
      const auto place =
          kMap.geodetic(Drive::pose(time).translation() + Eigen::Vector3d(off.x(), off.y(), 0));
      NavSatFix fix = Drive::fix(time);
      fix.latitude = place.latitude;
      fix.longitude = place.longitude;
      fix.position_covariance = {400, 0, 0, 0, 400, 0, 0, 0, 1600};
      send(topics::kGpsFix, fix);
    }
  }
  EXPECT_EQ(estimator.diagnostics().counter("gps.correlation_time"), 1U);
  EXPECT_THAT(estimator.diagnostics().take().values.at("gps.correlation"),
              AllOf(HasSubstr("errors of gps seem correlated over "),
                    HasSubstr(" s or more, told 0.2 s; set gps.correlation_time")));
}

TEST_F(StateEstimatorTest, SaysThatErrorsOfGpsAreCorrelatedForNoLongerThanTold) {
  auto& estimator = start(known_start());
  drive(0, 60);
  EXPECT_EQ(estimator.diagnostics().counter("gps.correlation_time"), 0U);
  EXPECT_THAT(estimator.diagnostics().take().values.at("gps.correlation"),
              Not(HasSubstr("set gps.correlation_time")));
}

TEST_F(StateEstimatorTest, TakesTheCameraFromTheTransforms) {
  const SE3 T_base_camera(SO3::from_roll_pitch_yaw({M_PI, 0, -M_PI_2}), {0.1, 0.0, -0.2});
  auto& estimator = start({{"preset", "uav"}, {"camera.frame", "camera_optical"}});
  const SE3 T_map_base(SO3(), {6, 2, 3});
  stand(0, 100, T_map_base * T_base_camera);
  EXPECT_EQ(estimator.diagnostics().counter("visual_pose.tf"), 25U);
  EXPECT_TRUE(odometry_.empty());
  tf2_msgs::msg::TFMessage tf;
  auto& transform = tf.transforms.emplace_back();
  transform.header.frame_id = "base_link";
  transform.child_frame_id = "camera_optical";
  transform.transform = transform_message(T_base_camera);
  send(topics::kTfStatic, tf);
  stand(100, 400, T_map_base * T_base_camera);
  EXPECT_EQ(estimator.diagnostics().counter("visual_pose.tf"), 25U);
  ASSERT_FALSE(odometry_.empty());
  EXPECT_LT((T_map_base.inverse() * from_message(odometry_.back().pose.pose)).log().norm(), 0.01);
}

TEST_F(StateEstimatorTest, TellsALocalizerThatHasNoPoseHowTheCameraIsTilted) {
  const SE3 T_base_camera(SO3::from_roll_pitch_yaw({M_PI, 0, -M_PI_2}), {0.1, 0.0, -0.2});
  start({{"preset", "uav"}, {"camera.position", std::vector<double>{0.1, 0.0, -0.2}}});
  const auto hints = harness_.collect(topics::kRackPoseHint);
  const auto hover = [&](int from, int to, const SO3& R_map_base) {
    const Eigen::Vector3d force = R_map_base.inverse() * Eigen::Vector3d(0, 0, 9.80665);
    for (int i = from; i < to; ++i) {
      const Time time = kStart + from_seconds(0.01 * i);
      harness_.set_time(time);
      Imu imu = Drive::imu(0);
      imu.header.stamp = to_message(time);
      imu.linear_acceleration.x = force.x();
      imu.linear_acceleration.y = force.y();
      imu.linear_acceleration.z = force.z();
      send(topics::kImu, imu);
    }
  };
  const SO3 tilted = SO3::from_roll_pitch_yaw({0.08, -0.05, 0});
  hover(0, 150, tilted);
  EXPECT_TRUE(hints.messages().empty());  // nobody has asked
  pipescout_msgs::msg::RackState state;
  state.status = pipescout_msgs::msg::RackState::STATUS_NOT_STARTED;
  send(topics::kRackState, state);
  hover(150, 200, tilted);
  ASSERT_FALSE(hints.messages().empty());
  const auto& hint = hints.back();
  EXPECT_EQ(hint.header.frame_id, "rack");
  const SO3 R_rack_camera = from_message(hint.pose.pose).rotation();
  const Eigen::Vector3d up = R_rack_camera.inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d truly_up =
      (tilted * T_base_camera.rotation()).inverse() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, up.dot(truly_up))), 0.02);
  const geometry::Matrix6d covariance = covariance_from_message(hint.pose.covariance);
  EXPECT_GT(covariance(0, 0), 1e4);
  EXPECT_LT(std::sqrt(covariance.diagonal().segment<2>(3).maxCoeff()), 0.1);
  EXPECT_GT(covariance(5, 5), 1);

  state.status = pipescout_msgs::msg::RackState::STATUS_TRACKING;
  send(topics::kRackState, state);
  const std::size_t before = hints.size();
  hover(200, 250, tilted);
  EXPECT_EQ(hints.size(), before);
}

TEST_F(StateEstimatorTest, PlacesACrawlerByItsWelds) {
  testing::TemporaryFolder folder;
  const std::string file = (folder.path() / "line.csv").string();
  std::ofstream(file) << "x,y,z\n0,0,0\n100,0,0\n";
  start({{"preset", "crawler"}, {"centre_line.file", file}});
  // It stands, speeds up for 2 s, and creeps at 0.5 m/s.
  const auto crept = [](double time) {
    const double since = std::clamp(time - 2, 0.0, 2.0);
    return 0.125 * since * since + 0.5 * std::max(0.0, time - 4);
  };
  const auto crawl = [&](double from, double to) {
    for (int i = static_cast<int>(std::lround(100 * from)); i < std::lround(100 * to); ++i) {
      const double time = 0.01 * i;
      harness_.set_time(kStart + from_seconds(time));
      Imu imu = Drive::imu(0);
      imu.header.stamp = to_message(kStart + from_seconds(time));
      imu.linear_acceleration.x = time > 2 && time < 4 ? 0.25 : 0.0;
      send(topics::kImu, imu);
      if (i % 10 == 0) {
        auto odometer = Drive::odometer(time);
        odometer.distance = crept(time);
        odometer.variance = 1e-6;
        odometer.independent_variance = 1e-6;
        send(topics::kOdometerFused, odometer);
      }
      if (i == 1200) {
        pipescout_msgs::msg::WeldDetection weld;
        weld.header.stamp = to_message(kStart + from_seconds(time));
        weld.chainage = 35.0;
        weld.chainage_variance = 1e-4;
        weld.standard_deviation = 0.01;
        weld.weld = 3;
        weld.weld_probability = 0.999;
        send(topics::kWeld, weld);
      }
    }
  };
  crawl(0, 11.9);
  EXPECT_TRUE(odometry_.empty());
  EXPECT_EQ(states_.back().phase, "aligning");
  crawl(11.9, 20);
  ASSERT_FALSE(odometry_.empty()) << states_.back().waits_for;
  EXPECT_NEAR(odometry_.back().pose.pose.position.x, 35 + 0.5 * (19.99 - 12), 0.2);
  EXPECT_NEAR(odometry_.back().pose.pose.position.y, 0, 0.2);
}

TEST_F(StateEstimatorTest, BadMessagesAreNamedAndLoseNothingElse) {
  auto& estimator = start(known_start());
  drive(0, 8);
  Imu imu = Drive::imu(8);
  imu.linear_acceleration.x = kNan;
  send(topics::kImu, imu);
  NavSatFix fix = Drive::fix(8);
  fix.latitude = kNan;
  send(topics::kGpsFix, fix);
  fix = Drive::fix(8);
  fix.position_covariance[4] = kNan;
  send(topics::kGpsFix, fix);
  fix = Drive::fix(8);
  fix.status.status = sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX;
  send(topics::kGpsFix, fix);
  fix = Drive::fix(100);
  send(topics::kGpsFix, fix);
  auto odometer = Drive::odometer(8);
  odometer.distance = kNan;
  send(topics::kOdometerFused, odometer);
  geometry_msgs::msg::PoseWithCovarianceStamped pose;
  pose.header.stamp = to_message(kStart + from_seconds(8));
  pose.header.frame_id = "elsewhere";
  send(topics::kRackPose, pose);
  pose.header.frame_id = "rack";
  send(topics::kRackPose, pose);  // no covariance, no orientation
  send(topics::kInitialPose, pose);
  const Diagnostics& diagnostics = estimator.diagnostics();
  EXPECT_EQ(diagnostics.counter("imu.not_finite"), 1U);
  EXPECT_EQ(diagnostics.counter("gps.refused"), 1U);
  EXPECT_EQ(diagnostics.counter("gps.not_finite"), 0U);  // gps.deviation is used for it
  EXPECT_EQ(diagnostics.counter("gps.no_fix"), 1U);
  EXPECT_EQ(diagnostics.counter("gps.header.stamp.in_future"), 1U);
  EXPECT_EQ(diagnostics.counter("odometer.not_finite"), 1U);
  EXPECT_EQ(diagnostics.counter("visual_pose.header.frame_id"), 1U);
  EXPECT_EQ(diagnostics.counter("visual_pose.refused"), 1U);
  EXPECT_EQ(diagnostics.counter("initialpose.header.frame_id"), 1U);
  drive(8, 12);
  const SE3 error = Drive::pose(11.99).inverse() * from_message(odometry_.back().pose.pose);
  EXPECT_LT(error.translation().norm(), 0.1);
}

TEST_F(StateEstimatorTest, AnInitialPoseWithoutVariancesLeavesTheRunningStateAlone) {
  auto& estimator = start(known_start());
  drive(0, 8);
  geometry_msgs::msg::PoseWithCovarianceStamped pose;
  pose.header.stamp = to_message(kStart + from_seconds(7.99));
  pose.header.frame_id = "map";
  pose.pose.pose = to_message(SE3(SO3(), {500, 0, 0}));
  pose.pose.covariance = to_message(geometry::Matrix6d(0.01 * geometry::Matrix6d::Identity()));
  pose.pose.covariance[35] = kNan;
  send(topics::kInitialPose, pose);
  EXPECT_EQ(estimator.diagnostics().counter("initialpose.refused"), 1U);
  drive(8, 10);
  const SE3 error = Drive::pose(9.99).inverse() * from_message(odometry_.back().pose.pose);
  EXPECT_LT(error.translation().norm(), 0.1);
  EXPECT_EQ(states_.back().phase, "running");
}

// Receivers that have just been switched on.
TEST_F(StateEstimatorTest, FixesOfExactlyZeroAreNone) {
  auto& estimator = start();
  stand_with_first_fixes([](int /*i*/) { return 0.0; });
  EXPECT_EQ(estimator.diagnostics().counter("gps.refused"), 10U);
  drive(3, 60);
  expect_near_the_origin();
}

TEST_F(StateEstimatorTest, TheMapsOriginIsOfFixesThatAgree) {
  start();
  stand_with_first_fixes([](int i) { return 1e-4 * (i + 1); });
  drive(3, 60);
  expect_near_the_origin();
}

TEST_F(StateEstimatorTest, AnImuThatIsMountedOtherwiseIsAFault) {
  auto& estimator = start(known_start());
  for (int i = 0; i < 300; ++i) {
    Imu imu = Drive::imu(0);
    imu.header.stamp = to_message(kStart + from_seconds(0.01 * i));
    imu.linear_acceleration.z = -kGravity;
    harness_.set_time(kStart + from_seconds(0.01 * i));
    send(topics::kImu, imu);
  }
  EXPECT_TRUE(odometry_.empty());
  EXPECT_GE(estimator.diagnostics().counter("start.fault"), 1U);
  EXPECT_EQ(estimator.diagnostics().status().level, DiagnosticLevel::kError);
}

TEST_F(StateEstimatorTest, AnOperatorPutsItElsewhere) {
  start(known_start());
  drive(0, 8, false);
  geometry_msgs::msg::PoseWithCovarianceStamped pose;
  pose.header.stamp = to_message(kStart + from_seconds(7.99));
  pose.header.frame_id = "map";
  pose.pose.pose = to_message(SE3(SO3::about_z(1.5), {50, 60, 0}));
  pose.pose.covariance = to_message(geometry::Matrix6d(0.01 * geometry::Matrix6d::Identity()));
  send(topics::kInitialPose, pose);
  odometry_.clear();
  // Stands again, so that it can level.
  for (int i = 800; i < 1100; ++i) {
    Imu imu = Drive::imu(0);
    imu.header.stamp = to_message(kStart + from_seconds(0.01 * i));
    harness_.set_time(kStart + from_seconds(0.01 * i));
    send(topics::kImu, imu);
  }
  ASSERT_FALSE(odometry_.empty());
  EXPECT_NEAR(odometry_.back().pose.pose.position.x, 50, 0.5);
  EXPECT_NEAR(from_message(odometry_.back().pose.pose).rotation().roll_pitch_yaw().z(), 1.5, 0.1);
}

TEST_F(StateEstimatorTest, TwoRobotsInOneProcessDoNotMix) {
  start(known_start());
  auto& other = harness_.make<StateEstimator>(
      {.name = "other",
       .parameters = {{"preset", "uav"}},
       .remappings = {"imu/data:=other/imu", "gps/fix:=other/fix", "odometer/fused:=other/odometer",
                      "odometry/filtered:=other/odometry", "estimator/state:=other/state"}});
  ASSERT_TRUE(harness_.bring_up(other).success);
  drive(0, 8);
  EXPECT_FALSE(odometry_.empty());
  EXPECT_EQ(other.diagnostics().counter("imu.not_finite"), 0U);
}

void expect_refused(ComponentHarness& harness, NamedParameter parameter, const std::string& text) {
  auto& estimator = harness.make<StateEstimator>({.parameters = {parameter}});
  const auto result = harness.configure(estimator);
  EXPECT_FALSE(result.success);
  EXPECT_THAT(result.message, HasSubstr(text));
  harness.destroy(estimator);
}

TEST_F(StateEstimatorTest, ParametersOutOfRangeAreRefusedByName) {
  EXPECT_THROW((void)harness_.make<StateEstimator>({.parameters = {{"lag", -1.0}}}),
               ParameterError);
  EXPECT_THROW((void)harness_.make<StateEstimator>({.parameters = {{"gps.gate", kNan}}}),
               ParameterError);
  EXPECT_THROW((void)harness_.make<StateEstimator>({.parameters = {{"preset", "submarine"}}}),
               ParameterError);
  expect_refused(harness_, {"datum", std::vector<double>{100.0, 0.0, 0.0}}, "latitude");
  expect_refused(harness_, {"datum", std::vector<double>{1.0}}, "datum");
  expect_refused(harness_, {"start.heading", std::vector<double>{1.0}}, "start.heading");
  expect_refused(harness_, {"gps.kernel", "soft"}, "gps.kernel");
  expect_refused(harness_, {"centre_line.file", "/does/not/exist.csv"}, "/does/not/exist.csv");
  expect_refused(harness_, {"weld.tally", "/does/not/exist.csv"}, "/does/not/exist.csv");
  EXPECT_THROW(
      (void)harness_.make<StateEstimator>({.parameters = {{"camera.rotation_deviation", 2.0}}}),
      ParameterError);
  expect_refused(harness_, {"camera.position_deviation", 1e-12}, "camera.position_deviation");
  expect_refused(harness_, {"camera.position", std::vector<double>{kNan, 0.0, 0.0}},
                 "camera.position");
}

}  // namespace
}  // namespace pipescout
