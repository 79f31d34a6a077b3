// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/mission.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "pipescout/move_base/global_planner.hpp"
#include "pipescout/move_base/move_base.hpp"
#include "pipescout/plant_world/localisation_errors.hpp"
#include "pipescout/plant_world/yard_map.hpp"
#include "pipescout/simulation/ackermann_vehicle.hpp"
#include "pipescout/simulation/plant_yard.hpp"

namespace pipescout::navigation_study {
namespace {

using navigation::DriveCommand;
using navigation::Footprint;
using navigation::MoveState;
using navigation::MoveStatus;
using navigation::Pose2d;
using simulation::AckermannVehicle;
using simulation::PlantYard;
using simulation::YardBox;
using statistics::Draw;

// What each kind of draw is for.
enum Purpose : std::uint64_t { kPlant = 30, kVehicle, kEnds, kErrors, kTracker };

// The robot's body; its origin is in the middle of the rear axle.
constexpr double kFront = 1.55;        // m
constexpr double kRear = 0.35;         // m
constexpr double kWidth = 1.0;         // m
constexpr double kLidarForward = 0.8;  // m
constexpr int kScanEvery = 2;          // control cycles: 10 Hz
constexpr int kImageEvery = 2;
constexpr int kTraceEvery = 4;
constexpr double kCoverageCell = 0.1;  // m

simulation::PlantYardParameters draw_yard(Draw& draw, bool tour) {
  simulation::PlantYardParameters p;
  p.rows = 3 + static_cast<int>(draw.index(3));
  p.row_length = draw.uniform(25, 50);
  p.aisle = draw.uniform(4, 6.5);
  p.row_width = draw.uniform(1, 2.5);
  p.road = draw.uniform(6, 9);
  p.people = static_cast<int>(draw.index(tour ? 3 : 6));
  p.vehicles = static_cast<int>(draw.index(3));
  p.unmapped = static_cast<int>(draw.index(5));
  return p;
}

/// Another vehicle than the one that the planner is told of.
simulation::AckermannVehicleParameters draw_vehicle(Draw& draw) {
  simulation::AckermannVehicleParameters p;
  p.wheel_base = draw.uniform(1.17, 1.23);
  p.steering_rate = draw.uniform(0.5, 0.8);
  p.steering_delay = draw.uniform(0.05, 0.15);
  p.drive_delay = draw.uniform(0.05, 0.15);
  p.understeer = draw.uniform(0, 0.02);
  p.wheel_slip = draw.uniform(0, 0.02);
  p.slope = draw.uniform(0, 0.05);
  p.uphill = draw.uniform(-std::numbers::pi, std::numbers::pi);
  return p;
}

YardBox body_at(double x, double y, double heading) {
  const double middle = (kFront - kRear) / 2;
  return {.centre = {x + middle * std::cos(heading), y + middle * std::sin(heading)},
          .heading = heading,
          .half_length = (kFront + kRear) / 2,
          .half_width = kWidth / 2};
}

/// In an aisle, along it, with room for the body.
Pose2d draw_end(Draw& draw, const PlantYard& yard) {
  constexpr double kRoom = 0.45;  // m
  constexpr double kMoverRoom = 2.5;
  while (true) {
    const auto& p = yard.parameters();
    const int aisle = static_cast<int>(draw.index(static_cast<std::size_t>(p.rows - 1)));
    const double heading = (draw.happens(0.5) ? 0 : std::numbers::pi) + draw.uniform(-0.1, 0.1);
    const Pose2d pose{draw.uniform(-1, p.row_length + 1),
                      yard.aisle_middle(aisle) + draw.uniform(-0.5, 0.5) * (p.aisle / 2 - 1),
                      navigation::wrap_angle(heading)};
    PlantYard standing = yard;
    standing.remove_movers();
    const YardBox body = body_at(pose.x, pose.y, pose.heading);
    const bool alone = std::all_of(
        yard.movers().begin(), yard.movers().end(),
        [&](const auto& mover) { return simulation::box_distance(body, mover.box) > kMoverRoom; });
    if (alone && standing.clearance(body) > kRoom) {
      return pose;
    }
  }
}

class Mission {
 public:
  Mission(const MissionSettings& settings, std::uint64_t seed, const Clock& clock)
      : settings_(settings),
        seed_(seed),
        clock_(clock),
        yard_(yard_of(settings, seed)),
        map_(simulation::map_of(yard_)),
        planner_(map_, footprint_, {}),
        base_(base_parameters(settings), footprint_),
        errors_(
            {.position_sigma = settings.position_sigma, .heading_sigma = settings.heading_sigma},
            seed),
        sensors_(seed, kErrors),
        tracker_(seed, kTracker),
        coverage_(kCoverageCell, navigation::InspectionParameters{}.largest_blur) {
    Draw ends(seed, kEnds);
    start_ = draw_end(ends, yard_);
    goal_ = draw_end(ends, yard_);
    Draw draw(seed, kVehicle);
    vehicle_.emplace(
        draw_vehicle(draw),
        simulation::AckermannState{.x = start_.x, .y = start_.y, .heading = start_.heading});
  }

  MissionScore run(std::vector<MissionTrace>* trace);

 private:
  static PlantYard yard_of(const MissionSettings& settings, std::uint64_t seed) {
    Draw draw(seed, kPlant);
    const auto parameters = draw_yard(draw, settings.tour);
    return {parameters, draw.seed()};
  }
  static navigation::MoveBaseParameters base_parameters(const MissionSettings& settings) {
    navigation::MoveBaseParameters parameters;
    parameters.inspection.exposure = settings.exposure;
    // Nearer than what is asked for, by what the localisation errs.
    parameters.driving.goal_distance = 0.06;
    parameters.driving.goal_heading = 0.04;
    return parameters;
  }

  void begin();
  void sense(int cycle, double now);
  void observe(double now);
  void plan(double now);
  void move(const DriveCommand& command, double period);
  void finish(const MoveStatus& status);

  MissionSettings settings_;
  std::uint64_t seed_;
  const Clock& clock_;
  Footprint footprint_ = Footprint::rectangle(kFront, kRear, kWidth);
  PlantYard yard_;
  navigation::HybridMap map_;
  navigation::GlobalPlanner planner_;
  navigation::MoveBase base_;
  simulation::LocalisationErrors errors_;
  Draw sensors_;
  Draw tracker_;
  navigation::CoverageMap coverage_;
  std::optional<AckermannVehicle> vehicle_;
  Pose2d start_;
  Pose2d goal_;
  std::optional<std::pair<double, navigation::NavigationPlan>> plan_;  // due at
  std::vector<float> ranges_;
  std::vector<double> cycle_times_;
  double inspected_time_ = 0;
  double inspected_length_ = 0;
  MissionScore score_;
};

void Mission::begin() {
  score_.least_clearance = std::numeric_limits<double>::infinity();
  if (!settings_.tour) {
    base_.start(navigation::PoseGoal{goal_});
    return;
  }
  navigation::TourGoal tour;
  for (int i = 0; i + 1 < yard_.parameters().rows; ++i) {
    tour.rows.push_back(i);
  }
  base_.start(tour);
}

void Mission::sense(int cycle, double now) {
  const auto& state = vehicle_->state();
  const auto error = errors_.next(navigation::DrivingParameters{}.period);
  base_.add(navigation::Localisation{
      .time = now,
      .pose = {state.x + error.x, state.y + error.y, state.heading + error.heading},
      .speed = state.speed + 0.01 * sensors_.normal(),
      .yaw_rate = state.yaw_rate + 0.005 * sensors_.normal(),
      .sigma = settings_.position_sigma,
      .heading_sigma = settings_.heading_sigma});
  if (cycle % kScanEvery != 0) {
    return;
  }
  const simulation::LidarParameters lidar;
  yard_.scan(lidar,
             {state.x + kLidarForward * std::cos(state.heading),
              state.y + kLidarForward * std::sin(state.heading)},
             state.heading, seed_ + static_cast<std::uint64_t>(cycle), ranges_);
  const double turn = 2 * std::numbers::pi;
  base_.add(navigation::ScanView{.time = now,
                                 .angle_min = -std::numbers::pi,
                                 .angle_increment = turn / lidar.beams,
                                 .range_min = 0.1,
                                 .range_max = lidar.largest_range,
                                 .ranges = ranges_},
            {kLidarForward, 0, 0});
}

/// A tracker that sees the pipe at the side of an aisle, and misses it at times.
void Mission::observe(double now) {
  constexpr double kMisses = 0.01;
  const auto& state = vehicle_->state();
  const auto& p = yard_.parameters();
  const double pitch = p.aisle + p.row_width;
  const int aisle = static_cast<int>(std::floor(state.y / pitch));
  const bool beside = state.x > 0 && state.x < p.row_length && aisle >= 0 && aisle < p.rows - 1;
  const bool tracked = beside && !tracker_.happens(kMisses);
  const double range = beside ? (aisle + 1) * pitch - p.row_width / 2 - state.y : 0;
  base_.add(navigation::PipeObservation{
      .time = now, .tracked = tracked, .confidence = tracked ? 0.9 : 0, .range = range});
  if (!tracked || range <= 0) {
    return;
  }
  const navigation::InspectionParameters camera;
  const double half = range * std::tan(navigation::MoveBaseParameters{}.view_angle / 2);
  coverage_.add({.pipe = aisle,
                 .from = std::max(0.0, state.x - half),
                 .to = std::min(p.row_length, state.x + half),
                 .time = now,
                 .blur = std::abs(state.speed) * settings_.exposure * camera.focal_length / range});
  inspected_time_ += std::abs(state.speed) > 0.05 ? 1 : 0;
  inspected_length_ += std::abs(state.speed) > 0.05 ? std::abs(state.speed) : 0;
}

void Mission::plan(double now) {
  if (const auto request = base_.take_request()) {
    double reading = 0;
    const double step = 1 / static_cast<double>(settings_.questions);
    plan_.emplace(now + settings_.planning_delay,
                  planner_.plan(*request, [&] { return reading += step; }));
  }
  if (plan_ && now >= plan_->first) {
    base_.give(plan_->second);
    plan_.reset();
  }
}

void Mission::move(const DriveCommand& command, double period) {
  const navigation::DrivingParameters told;
  vehicle_->command(command.speed, std::atan(told.wheel_base * command.curvature));
  const int steps = static_cast<int>(std::lround(period / AckermannVehicle::kStep));
  for (int i = 0; i < steps; ++i) {
    vehicle_->step();
    const auto& state = vehicle_->state();
    const YardBox body = body_at(state.x, state.y, state.heading);
    yard_.step(AckermannVehicle::kStep, body);
    const double clearance = yard_.clearance(body);
    score_.least_clearance = std::min(score_.least_clearance, clearance);
    score_.collisions += clearance <= 0 ? 1 : 0;
    score_.driven += std::abs(state.speed) * AckermannVehicle::kStep;
  }
}

void Mission::finish(const MoveStatus& status) {
  score_.reached = status.state == MoveState::kSucceeded;
  score_.failure = status.failure;
  score_.replans = status.replans;
  score_.text = status.text;
  if (!score_.reached && status.failure == navigation::NavigationFailure::kNone) {
    score_.text = std::string(to_string(status.state)) + ", " + to_string(status.command.state) +
                  ", " + to_string(status.command.reason);
  }
  const auto& state = vehicle_->state();
  score_.goal_distance = std::hypot(state.x - goal_.x, state.y - goal_.y);
  score_.goal_heading = std::abs(navigation::wrap_angle(state.heading - goal_.heading));
  if (!cycle_times_.empty()) {
    const auto middle = cycle_times_.begin() + static_cast<std::ptrdiff_t>(cycle_times_.size() / 2);
    std::nth_element(cycle_times_.begin(), middle, cycle_times_.end());
    score_.typical_cycle_time = *middle;
  }
  if (settings_.tour) {
    const double length = yard_.parameters().row_length;
    double seen = 0;
    for (int i = 0; i + 1 < yard_.parameters().rows; ++i) {
      score_.pipe_metres += length;
      seen += length * coverage_.sharp_percent(i, 0, length);
    }
    score_.seen_percent = seen / score_.pipe_metres;
    score_.speed = inspected_time_ > 0 ? inspected_length_ / inspected_time_ : 0;
  }
}

MissionScore Mission::run(std::vector<MissionTrace>* trace) {
  const double period = navigation::DrivingParameters{}.period;
  constexpr double kBegin = 1000;  // s: a stamp of zero means nothing to some
  begin();
  MoveStatus status;
  const int cycles = static_cast<int>(settings_.time_limit / period);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    const double now = kBegin + cycle * period;
    sense(cycle, now);
    if (settings_.tour && cycle % kImageEvery == 0) {
      observe(now);
    }
    const double before = clock_();
    status = base_.cycle(now);
    cycle_times_.push_back(clock_() - before);
    score_.cycle_time = std::max(score_.cycle_time, cycle_times_.back());
    score_.gap = std::max(score_.gap, period + cycle_times_.back());
    plan(now);
    if (trace != nullptr && cycle % kTraceEvery == 0) {
      const auto& state = vehicle_->state();
      trace->push_back(
          {now - kBegin,
           {state.x, state.y, state.heading},
           state.speed,
           std::string(to_string(status.state)) + "/" + to_string(status.command.state),
           to_string(status.command.reason)});
    }
    const bool ended = status.state == MoveState::kSucceeded || status.state == MoveState::kFailed;
    if (ended && std::abs(vehicle_->state().speed) < 1e-3) {
      break;
    }
    move(status.command, period);
    score_.time = now - kBegin;
  }
  finish(status);
  return score_;
}

}  // namespace

MissionScore run_mission(const MissionSettings& settings, std::uint64_t seed, const Clock& clock,
                         std::vector<MissionTrace>* trace) {
  return Mission(settings, seed, clock).run(trace);
}

}  // namespace pipescout::navigation_study
