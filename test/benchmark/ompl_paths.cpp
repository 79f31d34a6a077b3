// SPDX-License-Identifier: Apache-2.0
#include "ompl_paths.hpp"

#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/ReedsSheppStateSpace.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <chrono>
#include <limits>
#include <utility>

#include "pipescout/navigation_maps/distance_field.hpp"

namespace pipescout::benchmarks {
namespace {

using navigation::Pose2d;
using navigation::UnknownCells;
using Space = ompl::base::ReedsSheppStateSpace;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

class OmplPaths::Checker {
 public:
  Checker(const navigation::OccupancyGrid& grid, navigation::Footprint footprint, double radius)
      : grid_(grid),
        footprint_(std::move(footprint)),
        field_(grid, UnknownCells::kBlocked,
               footprint_.circumscribed_radius() + 2 * grid.resolution()),
        radius_(radius) {}

  [[nodiscard]] bool is_valid(const ompl::base::State* state) const {
    const auto* pose = state->as<Space::StateType>();
    const auto bounds =
        field_.bounds(grid_.to_grid(navigation::Point2d{pose->getX(), pose->getY()}));
    if (bounds.low > footprint_.circumscribed_radius()) {
      return true;
    }
    if (bounds.high < footprint_.inscribed_radius()) {
      return false;
    }
    return !collides(footprint_, grid_, {pose->getX(), pose->getY(), pose->getYaw()},
                     UnknownCells::kBlocked);
  }
  [[nodiscard]] const navigation::OccupancyGrid& grid() const { return grid_; }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  navigation::OccupancyGrid grid_;
  navigation::Footprint footprint_;
  navigation::DistanceField field_;
  double radius_;
};

OmplPaths::OmplPaths(const navigation::OccupancyGrid& grid, navigation::Footprint footprint,
                     double turning_radius)
    : checker_(std::make_unique<Checker>(grid, std::move(footprint), turning_radius)) {}
OmplPaths::~OmplPaths() = default;

OmplPaths::Result OmplPaths::plan(Algorithm algorithm, const Pose2d& start, const Pose2d& goal,
                                  double seconds, std::uint32_t seed) {
  constexpr double kStep = 0.05;  // m
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  ompl::RNG::setSeed(seed);
  const auto space = std::make_shared<Space>(checker_->radius());
  ompl::base::RealVectorBounds bounds(2);
  const auto& grid = checker_->grid();
  const Pose2d& origin = grid.geometry().origin;
  bounds.setLow(0, origin.x);
  bounds.setLow(1, origin.y);
  bounds.setHigh(0, origin.x + grid.width() * grid.resolution());
  bounds.setHigh(1, origin.y + grid.height() * grid.resolution());
  space->setBounds(bounds);
  const auto information = std::make_shared<ompl::base::SpaceInformation>(space);
  information->setStateValidityChecker(
      [this](const ompl::base::State* state) { return checker_->is_valid(state); });
  information->setStateValidityCheckingResolution(kStep / space->getMaximumExtent());
  information->setup();
  const auto problem = std::make_shared<ompl::base::ProblemDefinition>(information);
  const auto state_of = [&](const Pose2d& pose) {
    ompl::base::ScopedState<Space> state(space);
    state->setX(pose.x);
    state->setY(pose.y);
    state->setYaw(navigation::wrap_angle(pose.heading));
    return state;
  };
  problem->setStartAndGoalStates(state_of(start), state_of(goal));
  problem->setOptimizationObjective(
      std::make_shared<ompl::base::PathLengthOptimizationObjective>(information));
  Result result{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const double begin = now();
  problem->setIntermediateSolutionCallback([&](const ompl::base::Planner*,
                                               const std::vector<const ompl::base::State*>&,
                                               const ompl::base::Cost& cost) {
    result.first = std::min(result.first, now() - begin);
    result.length = std::min(result.length, cost.value());
  });
  ompl::base::PlannerPtr planner;
  if (algorithm == Algorithm::kRrtStar) {
    planner = std::make_shared<ompl::geometric::RRTstar>(information);
  } else {
    planner = std::make_shared<ompl::geometric::BITstar>(information);
  }
  planner->setProblemDefinition(problem);
  planner->setup();
  (void)planner->solve(ompl::base::timedPlannerTerminationCondition(seconds));
  if (problem->hasExactSolution()) {
    result.first = std::min(result.first, now() - begin);
    result.length = std::min(result.length, problem->getSolutionPath()->length());
  }
  return result;
}

}  // namespace pipescout::benchmarks
