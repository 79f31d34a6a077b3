// SPDX-License-Identifier: Apache-2.0
// Pipes that are not as the rack file has them in height, direction or radius.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "shape_contour.hpp"
#include "shape_memory.hpp"

namespace pipescout::rack_vision {
namespace {

using test::draw;
using test::drawn_camera;
using test::drawn_pose;
using test::drawn_rack;
using test::rack_on_a_beam;

constexpr std::size_t kPipe = 2;
constexpr PipeShape kLagged{.height = 0.02, .turn_aside = 0.004, .turn_up = -0.003, .radius = 0.02};
constexpr ShapeDeviation kStated{.height = 0.03, .direction = 0.006, .radius = 0.02};

TEST(ShapedPipe, TurnsAboutItsMiddleAndGrowsByItsRadius) {
  const Pipe pipe = drawn_rack().pipes[kPipe];
  const Pipe other =
      shaped(pipe, {.offset = 0.01, .height = 0.02, .turn_aside = 0.1, .radius = 0.03});
  const auto middle = [](const Pipe& of) -> Eigen::Vector3d {
    return of.start + 0.5 * of.length() * of.direction;
  };
  EXPECT_TRUE(middle(other).isApprox(middle(pipe) + Eigen::Vector3d(0.01, 0, 0.02)));
  EXPECT_NEAR(other.direction.norm(), 1, 1e-12);
  EXPECT_GT(other.direction.x(), 0.09) << "to the right of a pipe along y";
  EXPECT_GT(shaped(pipe, {.turn_up = 0.1}).direction.z(), 0.09);
  EXPECT_NEAR(other.radii.front().radius, pipe.radii.front().radius + 0.03, 1e-12);
}

/// Of one contour of the pipe in the middle of the view.
TEST(ShapeContour, MovesAsItsDerivativeSays) {
  const Pipe pipe = drawn_rack().pipes[kPipe];
  const geometry::Camera camera = drawn_camera();
  const CameraView seen(camera, drawn_pose(0.5, 4, 2.5, 0.1).inverse());
  const Eigen::Vector2d pixel(200, 100);
  const Eigen::Vector2d normal = Eigen::Vector2d(1, 0.2).normalized();
  for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}}) {
    const EdgeId edge{.body = kPipe, .side = side};
    const ShapeVector by_shape =
        distance_by_shape(pipe, ShapeVector::Zero(), edge, seen, pixel, normal);
    ShapeVector small;
    small << 0.002, 0.003, 0.001, -0.001, 0.002;
    const auto before = distance_to_contour(pipe, edge, seen, pixel, normal);
    const auto after =
        distance_to_contour(shaped(pipe, to_shape(small)), edge, seen, pixel, normal);
    ASSERT_TRUE(before && after);
    EXPECT_NEAR(*after - *before, by_shape.dot(small), 0.01);
    EXPECT_GT(std::abs(by_shape(0)), 50) << "px/m of an offset";
    EXPECT_GT(side == 0 ? -by_shape(4) : by_shape(4), 50) << "a thicker pipe is wider";
  }
}

/// Flies a camera over the rack as it is drawn, and to and fro across the pipes.
class ShapedRackFlight {
 public:
  ShapedRackFlight(const RackModel& drawn, const RackModel& file)
      : drawn_(drawn), tracker_(file, drawn_camera()) {
    const geometry::Matrix6d covariance = 1e-4 * geometry::Matrix6d::Identity();
    EXPECT_TRUE(tracker_.set_pose(pose(0), covariance));
  }

  RackTrackerResult fly(int images) {
    RackTrackerResult result;
    for (int i = 0; i < images; ++i, ++image_) {
      result = tracker_.track(draw(drawn_, drawn_camera(), pose(image_)).view(), 0.04 * image_);
      if (result.status == TrackStatus::kTracking) {
        ++tracked_;
        const Eigen::Vector3d error =
            result.T_rack_camera.translation() - pose(image_).translation();
        worst_ = std::max(worst_, error.norm());
      }
    }
    return result;
  }

  [[nodiscard]] int tracked() const { return tracked_; }
  [[nodiscard]] double worst() const { return worst_; }

 private:
  static geometry::SE3 pose(int image) {
    const double share = image / 100.0;
    return drawn_pose(0.85 + 0.6 * std::sin(2 * std::numbers::pi * share), 3.2 + 1.2 * share, 2.4,
                      0.05);
  }

  RackModel drawn_;
  RackTracker tracker_;
  int image_ = 0;
  int tracked_ = 0;
  double worst_ = 0;
};

RackModel as_it_is() {
  RackModel rack = rack_on_a_beam();
  rack.pipes[kPipe] = shaped(rack.pipes[kPipe], kLagged);
  return rack;
}

RackModel as_the_file_has_it() {
  RackModel rack = rack_on_a_beam();
  rack.pipes[kPipe].shape_deviation = kStated;
  return rack;
}

TEST(TrackedShape, IsFoundFromSeveralViews) {
  ShapedRackFlight flight(as_it_is(), as_the_file_has_it());
  const RackTrackerResult result = flight.fly(100);
  EXPECT_EQ(flight.tracked(), 100);
  EXPECT_LT(flight.worst(), 0.015);
  ASSERT_EQ(result.shapes.size(), 1U);
  const PipeShapeEstimate& found = result.shapes[0];
  EXPECT_EQ(found.pipe, kPipe);
  ASSERT_TRUE(found.found);
  const auto expect_near = [](double value, double truth, double deviation, double most) {
    EXPECT_NEAR(value, truth, 3 * deviation);
    EXPECT_LT(deviation, most);
  };
  expect_near(found.shape.height, kLagged.height, found.deviation.height, 0.015);
  expect_near(found.shape.radius, kLagged.radius, found.deviation.radius, 0.005);
  expect_near(found.shape.turn_aside, kLagged.turn_aside, found.deviation.turn_aside, 0.003);
  expect_near(found.shape.offset, 0, found.deviation.offset, 0.006);
}

TEST(TrackedShape, IsAsUncertainAsTheFileSaysBeforeItIsFound) {
  ShapedRackFlight flight(as_it_is(), as_the_file_has_it());
  const RackTrackerResult first = flight.fly(1);
  ASSERT_EQ(first.status, TrackStatus::kTracking) << first.reason;
  ASSERT_EQ(first.shapes.size(), 1U);
  EXPECT_FALSE(first.shapes[0].found);
  EXPECT_NEAR(first.shapes[0].deviation.height, kStated.height, 1e-9);
  EXPECT_LT(flight.worst(), 0.01);
}

TEST(TrackedShape, OfAPipeAsTheFileHasItStaysSo) {
  ShapedRackFlight flight(rack_on_a_beam(), as_the_file_has_it());
  const RackTrackerResult result = flight.fly(60);
  ASSERT_TRUE(result.shapes[0].found);
  EXPECT_LT(std::abs(result.shapes[0].shape.radius), 0.005);
  EXPECT_LT(flight.worst(), 0.01);
}

/// Exact samples of all contours that a camera sees.
std::vector<EdgeSample> samples_of(const RackModel& drawn, const geometry::SE3& T_camera_rack) {
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(drawn, {}, drawn_camera(), T_camera_rack, edges);
  std::vector<EdgeSample> samples;
  for (const VisibleEdge& edge : edges) {
    for (int i = 0; i < 10; ++i) {
      EdgeSample& sample = samples.emplace_back();
      sample.edge = edge.id;
      sample.candidates[0] = edge.image_start + 0.1 * i * (edge.image_end - edge.image_start);
      sample.sigma = 0.2;
    }
  }
  return samples;
}

class SolvedShape : public ::testing::Test {
 protected:
  SolvedShape()
      : solver_(fixed_rack()), samples_(samples_of(as_it_is(), T_rack_camera_.inverse())) {
    belief_.pipe = kPipe;
    belief_.covariance.diagonal() << 0, 9e-4, 3.6e-5, 3.6e-5, 4e-4;
    problem_.T_camera_rack =
        geometry::SE3(T_rack_camera_.rotation(),
                      T_rack_camera_.translation() + Eigen::Vector3d(0.01, 0, -0.01))
            .inverse();
    problem_.pose_prior =
        PosePrior{problem_.T_camera_rack, 1e4 * geometry::Matrix6d::Identity().eval()};
    problem_.edges = samples_;
    problem_.shapes = {&belief_, 1};
  }

  static RackModel fixed_rack() {
    RackModel rack = rack_on_a_beam();
    for (Pipe& pipe : rack.pipes) {
      pipe.movable = false;
    }
    return rack;
  }

  [[nodiscard]] double position_error() const {
    return (solution_.T_camera_rack.inverse().translation() - T_rack_camera_.translation()).norm();
  }

  geometry::SE3 T_rack_camera_ = drawn_pose(0.85, 3.9, 2.4, 0.05);
  PoseSolver solver_;
  std::vector<EdgeSample> samples_;
  ShapeBelief belief_;
  PoseProblem problem_;
  PoseSolution solution_;
};

TEST_F(SolvedShape, IsToldTogetherWithThePose) {
  solver_.solve(drawn_camera(), problem_, solution_);
  ASSERT_EQ(solution_.status, PoseStatus::kOk);
  EXPECT_LT(position_error(), 0.004);
  ASSERT_EQ(solution_.shapes.size(), 1U);
  const ShapeBelief& found = solution_.shapes[0];
  EXPECT_NEAR(found.mean(0), 0, 1e-6) << "what is exact stays";
  ShapeVector truth;
  truth << 0, kLagged.height, kLagged.turn_aside, kLagged.turn_up, kLagged.radius;
  for (int k = 1; k < kShapeUnknowns; ++k) {
    EXPECT_LT(std::abs(found.mean(k) - truth(k)), 2 * std::sqrt(found.covariance(k, k))) << k;
    EXPECT_LE(found.covariance(k, k), belief_.covariance(k, k)) << k;
  }
  EXPECT_LT(std::sqrt(found.covariance(4, 4)), 0.005);
}

TEST_F(SolvedShape, LeavesMoreOfThePoseUncertainThanACertainOne) {
  solver_.solve(drawn_camera(), problem_, solution_);
  const geometry::Matrix6d uncertain = solution_.covariance;
  EXPECT_GT(solution_.covariance_by_offsets.trace(), 0);
  belief_.mean << 0, kLagged.height, kLagged.turn_aside, kLagged.turn_up, kLagged.radius;
  belief_.covariance.setZero();
  solver_.solve(drawn_camera(), problem_, solution_);
  EXPECT_GT(uncertain(0, 0), 1.1 * solution_.covariance(0, 0));
}

TEST_F(SolvedShape, OfNoPipeOrOfOneTwiceIsRefused) {
  const std::array<ShapeBelief, 2> twice{belief_, belief_};
  problem_.shapes = twice;
  solver_.solve(drawn_camera(), problem_, solution_);
  EXPECT_EQ(solution_.status, PoseStatus::kBadInput);
  belief_.pipe = kMaxPipes;
  problem_.shapes = {&belief_, 1};
  solver_.solve(drawn_camera(), problem_, solution_);
  EXPECT_EQ(solution_.status, PoseStatus::kBadInput);
  belief_.pipe = kPipe;
  belief_.mean(1) = std::numeric_limits<double>::quiet_NaN();
  solver_.solve(drawn_camera(), problem_, solution_);
  EXPECT_EQ(solution_.status, PoseStatus::kBadInput);
}

TEST(ShapeMemory, LearnsNothingBeforeAShapeIsFound) {
  Pipe pipe = drawn_rack().pipes[kPipe];
  pipe.shape_deviation = kStated;
  ShapeMemory memory(pipe, 0.005);
  ShapeBelief told{.pipe = kPipe};
  told.mean(4) = 0.01;
  memory.learn(told, {.searched = 40, .found = 40}, 1);
  EXPECT_EQ(memory.mean(), ShapeVector::Zero().eval());
  EXPECT_NEAR(memory.deviation().radius, kStated.radius, 1e-12);
  EXPECT_NEAR(memory.deviation().offset, 0.005, 1e-12);
}

}  // namespace
}  // namespace pipescout::rack_vision
