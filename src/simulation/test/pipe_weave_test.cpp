// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_weave.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "pipescout/simulation/motion.hpp"
#include "strapdown.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;

std::vector<RoutePiece> crooked() {
  return {RoutePiece::straight(5), RoutePiece::bend(1.5, std::numbers::pi / 2),
          RoutePiece::straight(3), RoutePiece::slope_bend(2, 0.5),
          RoutePiece::straight(4), RoutePiece::bend(3, -1)};
}

TEST(PipeWeave, HasItsAutocorrelation) {
  constexpr int kSeeds = 4000;
  constexpr PipeWeaveParameters kParameters{
      .deviation = 0.01, .crab_deviation = 0.02, .shortest_wavelength = 2};
  const Eigen::Vector4d scale(100, 100, 50, 50);
  for (const double apart : {0.0, 0.3, 1.0, 1.4, 2.0}) {
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const PipeWeave weave(kParameters, seed);
      covariance += scale.cwiseProduct(weave.offset(3).value) *
                    scale.cwiseProduct(weave.offset(3 + apart).value).transpose() / kSeeds;
    }
    const double x = std::numbers::pi * apart;
    const double expected = apart > 0 ? std::sin(x) / x : 1;
    // Of 4000 products: deviation at most sqrt(2 / 4000) = 0.022.
    EXPECT_LT((covariance - expected * Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 0.09)
        << apart;
  }
}

TEST(PipeWeave, AStretchOfOnePipeIsLikeIndependentDraws) {
  constexpr int kSeeds = 4000;
  constexpr int kPlaces = 32;
  constexpr PipeWeaveParameters kParameters{.deviation = 0.01, .crab_deviation = 0.02};
  const Eigen::Array4d scale(100, 100, 50, 50);
  Eigen::Array4d second = Eigen::Array4d::Zero();
  Eigen::Array4d fourth = Eigen::Array4d::Zero();
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const PipeWeave weave(kParameters, seed);
    Eigen::Array4d sum = Eigen::Array4d::Zero();
    for (int place = 0; place < kPlaces; ++place) {
      sum += scale * weave.offset(place * kParameters.shortest_wavelength / 2).value.array();
    }
    second += sum.square() / kPlaces / kSeeds;
    fourth += sum.square().square() / (kPlaces * kPlaces) / kSeeds;
  }
  // Of 4000 draws of a normal one: deviations 0.022 and 0.15.
  EXPECT_LT((second - 1).abs().maxCoeff(), 0.09) << second.transpose();
  EXPECT_LT((fourth - 3).abs().maxCoeff(), 0.7) << fourth.transpose();
}

TEST(PipeWeave, WithoutADeviationItIsTheLine) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, 0.6, {1, 2, 3}, 0.4);
  const PipeWeave weave({.deviation = 0, .crab_deviation = 0}, 1);
  for (double s = -1; s < route.length(); s += 0.7) {
    const BodyMotion line = route.motion(s, 0.6, -0.2);
    const BodyMotion body = weave.motion(route, s, 0.6, -0.2);
    EXPECT_LT((body.T_map_body.translation() - line.T_map_body.translation()).norm(), 1e-15);
    EXPECT_LT((body.velocity - line.velocity).norm(), 1e-15);
    EXPECT_LT((body.acceleration - line.acceleration).norm(), 1e-15);
    EXPECT_LT((body.angular_rate - line.angular_rate).norm(), 1e-15);
    EXPECT_LT((body.angular_acceleration - line.angular_acceleration).norm(), 1e-15);
  }
}

TEST(PipeWeave, RatesAndAccelerationsAreDerivatives) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, 0.6);
  const PipeWeave weave({}, 5);
  constexpr double kSpeed = 0.6;
  constexpr double kAcceleration = -0.3;
  constexpr double kDt = 1e-4;
  const auto at = [&](double s, double t) {
    return weave.motion(route, s + kSpeed * t + kAcceleration * t * t / 2,
                        kSpeed + kAcceleration * t, kAcceleration);
  };
  for (double s = 0.53; s < route.length(); s += 0.37) {
    const BodyMotion before = at(s, -kDt);
    const BodyMotion now = at(s, 0);
    const BodyMotion after = at(s, kDt);
    const Vector3d moved = after.T_map_body.translation() - before.T_map_body.translation();
    const geometry::SO3 turned =
        before.T_map_body.rotation().inverse() * after.T_map_body.rotation();
    EXPECT_LT((moved / (2 * kDt) - now.velocity).norm(), 1e-6) << s;
    EXPECT_LT(((after.velocity - before.velocity) / (2 * kDt) - now.acceleration).norm(), 1e-4);
    EXPECT_LT((turned.log() / (2 * kDt) - now.angular_rate).norm(), 1e-6) << s;
    EXPECT_LT(
        ((after.angular_rate - before.angular_rate) / (2 * kDt) - now.angular_acceleration).norm(),
        2e-3)  // jumps where the rates of the line begin to change
        << s;
  }
}

TEST(PipeWeave, TheVehiclePointsWhereItGoes) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, 0.6);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PipeWeave weave({.crab_deviation = 0}, seed);
    for (double s = 0.1; s < route.length(); s += 0.3) {
      const BodyMotion motion = weave.motion(route, s, 0.5, 0);
      const Vector3d in_body = motion.T_map_body.rotation().inverse() * motion.velocity;
      // What it leaves out: that the offset is carried round by the bend, per metre of the line,
      // and that the way upwards is seen from the side as far as it also goes sideways.
      const double bend = route.motion(s, 1, 0).angular_rate.norm();
      const PipeWeave::Offset off = weave.offset(s);
      const double both = std::abs(off.first[1]) * off.first[0] * off.first[0] / 2;
      EXPECT_LE(in_body.tail<2>().norm() / in_body.x(),
                1.1 * (bend * off.value.head<2>().norm() + both) + 1e-12);
    }
  }
}

TEST(PipeWeave, APerfectImuGivesTheTruthBack) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, 0.6);
  const PipeWeave weave({}, 3);
  const Motion drive({{.speed = 0.4, .duration = 30}, {.speed = -0.3, .duration = 10}}, 0.25);
  constexpr double kStep = 0.002;
  const auto at = [&](double t) {
    return weave.motion(route, drive.distance(t), drive.speed(t),
                        drive.pieces()[drive.piece_at(t)].acceleration);
  };
  test::Strapdown navigator(at(0));
  const int steps = static_cast<int>(drive.duration() / kStep);
  for (int i = 1; i <= steps; ++i) {
    navigator.advance(at(i * kStep), kStep);
  }
  EXPECT_LT(navigator.position_error(), 0.05);  // accelerations jump between samples
  EXPECT_LT(navigator.velocity_error(), 0.002);
}

TEST(PipeWeave, RefusesNonsense) {
  EXPECT_THROW(PipeWeave({.deviation = -0.1}, 1), std::invalid_argument);
  EXPECT_THROW(PipeWeave({.crab_deviation = 1}, 1), std::invalid_argument);
  EXPECT_THROW(PipeWeave({.shortest_wavelength = std::nan("")}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
