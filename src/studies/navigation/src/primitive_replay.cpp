// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/primitive_replay.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/navigation_maps/pose2d.hpp"
#include "pipescout/simulation/ackermann_vehicle.hpp"

namespace pipescout::navigation_study {
namespace {

using navigation::ArcPiece;
using simulation::AckermannVehicle;

constexpr double kReplaySpeed = 0.3;  // m/s
constexpr double kApproach = 2;       // 1/s: speed per metre that is left
constexpr double kReplayDone = 1e-3;  // m
constexpr double kSteered = 1e-4;     // rad
constexpr double kReplayLimit = 300;  // s, of a piece

/// Straight on from its pose, with the wheels turned before.
void drive_piece(AckermannVehicle& vehicle, double wheel_base, const ArcPiece& piece) {
  const double steering = std::atan(wheel_base * piece.curvature);
  const double sign = piece.length < 0 ? -1 : 1;
  double driven = 0;
  bool steered = false;
  for (double time = 0; time < kReplayLimit; time += AckermannVehicle::kStep) {
    const auto& state = vehicle.state();
    const double left = std::abs(piece.length) - driven;
    steered = steered || std::abs(state.steering - steering) < kSteered;
    if (left < kReplayDone && std::abs(state.speed) < kReplayDone) {
      return;
    }
    vehicle.command(steered ? sign * std::clamp(kApproach * left, 0.0, kReplaySpeed) : 0, steering);
    vehicle.step();
    driven += sign * state.speed * AckermannVehicle::kStep;
  }
}

}  // namespace

PrimitiveReplay replay_primitives(const navigation::LatticePrimitives& lattice) {
  PrimitiveReplay result;
  simulation::AckermannVehicleParameters parameters;
  parameters.wheel_slip = 0;
  for (const navigation::MotionPrimitive& primitive : lattice.primitives) {
    const auto heading = [&](int i) { return lattice.headings[static_cast<std::size_t>(i)]; };
    AckermannVehicle vehicle(parameters, {.heading = heading(primitive.start_heading)});
    for (const ArcPiece& piece : primitive.pieces) {
      drive_piece(vehicle, parameters.wheel_base, piece);
    }
    const auto& state = vehicle.state();
    ++result.primitives;
    result.position =
        std::max(result.position, std::hypot(state.x - primitive.columns * lattice.spacing,
                                             state.y - primitive.rows * lattice.spacing));
    result.heading =
        std::max(result.heading,
                 std::abs(navigation::wrap_angle(state.heading - heading(primitive.end_heading))));
  }
  return result;
}

}  // namespace pipescout::navigation_study
