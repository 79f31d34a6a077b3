// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_route.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kKnotSpacing = 0.1;  // m, so that five points of Gauss suffice for 1e-9 m
constexpr std::array<double, 5> kGaussPlaces{-0.9061798459386640, -0.5384693101056831, 0,
                                             0.5384693101056831, 0.9061798459386640};
constexpr std::array<double, 5> kGaussWeights{0.2369268850561891, 0.4786286704993665,
                                              0.5688888888888889, 0.4786286704993665,
                                              0.2369268850561891};

Vector3d along(const Vector2d& angles) {
  return {std::cos(angles[1]) * std::cos(angles[0]), std::cos(angles[1]) * std::sin(angles[0]),
          std::sin(angles[1])};
}

}  // namespace

RoutePiece RoutePiece::bend(double radius, double angle) noexcept {
  return {radius * std::abs(angle), std::copysign(1 / radius, angle), 0};
}

RoutePiece RoutePiece::slope_bend(double radius, double angle) noexcept {
  return {radius * std::abs(angle), 0, std::copysign(1 / radius, angle)};
}

std::vector<RoutePiece> route_pieces(const JointedPipe& pipe) {
  std::vector<RoutePiece> pieces;
  pieces.reserve(pipe.joints().size());
  for (const Joint& joint : pipe.joints()) {
    pieces.push_back({joint.length, joint.heading_rate, joint.pitch_rate});
  }
  return pieces;
}

PipeRoute::PipeRoute(std::span<const RoutePiece> pieces, double ease, const Vector3d& start,
                     double heading) {
  validation::check_within("ease", ease, 0.001, 100);
  if (pieces.empty() || !start.allFinite() || !std::isfinite(heading)) {
    throw std::invalid_argument("pipe_route: it takes a piece, and a start that is finite");
  }
  for (const RoutePiece& piece : pieces) {
    validation::check_within("pieces.length", piece.length, ease, 1e7);
    validation::check_within("pieces.heading_rate", piece.heading_rate, -10, 10);
    validation::check_within("pieces.pitch_rate", piece.pitch_rate, -10, 10);
  }
  const auto rates = [](const RoutePiece& piece) {
    return Vector2d(piece.heading_rate, piece.pitch_rate);
  };
  knots_.push_back({.position = start, .angles = {heading, 0}, .rates = rates(pieces.front())});
  double end = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    end += pieces[i].length;
    if (i + 1 < pieces.size()) {
      append(end - ease / 2, rates(pieces[i]));
      append(end + ease / 2, rates(pieces[i + 1]));
    } else {
      append(end, rates(pieces[i]));
    }
  }
  knots_.back().rates.setZero();
}

void PipeRoute::append(double chainage, const Vector2d& rates) {
  const Knot from = knots_.back();
  const double length = chainage - from.chainage;
  if (length <= 0) {  // two eased ends that meet
    return;
  }
  knots_.back().change = (rates - from.rates) / length;
  const int parts = static_cast<int>(std::ceil(length / kKnotSpacing));
  for (int i = 1; i <= parts; ++i) {
    const Knot last = knots_.back();
    const double step = from.chainage + length * i / parts - last.chainage;
    knots_.push_back({.chainage = last.chainage + step,
                      .position = advance(last, step),
                      .angles = last.angles + step * (last.rates + step / 2 * last.change),
                      .rates = last.rates + step * last.change,
                      .change = last.change});
  }
  knots_.back().change.setZero();
}

Vector3d PipeRoute::advance(const Knot& knot, double length) noexcept {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < kGaussPlaces.size(); ++i) {
    const double s = length * (1 + kGaussPlaces[i]) / 2;
    sum += kGaussWeights[i] * along(knot.angles + s * (knot.rates + s / 2 * knot.change));
  }
  return knot.position + length / 2 * sum;
}

const PipeRoute::Knot& PipeRoute::knot_at(double chainage) const noexcept {
  const auto after = std::ranges::upper_bound(knots_, chainage, {}, &Knot::chainage);
  return after == knots_.begin() ? knots_.front() : *std::prev(after);
}

Vector3d PipeRoute::position(double chainage) const noexcept {
  if (chainage < 0) {
    return knots_.front().position + chainage * along(knots_.front().angles);
  }
  const Knot& knot = knot_at(chainage);
  return advance(knot, chainage - knot.chainage);
}

BodyMotion PipeRoute::motion(double chainage, double speed, double acceleration) const {
  const Knot& knot = knot_at(chainage);
  const double s = chainage - knot.chainage;
  const bool before = chainage < 0;
  const Vector2d rates = before ? Vector2d::Zero() : Vector2d(knot.rates + s * knot.change);
  const Vector2d change = before ? Vector2d::Zero() : knot.change;
  const Vector2d angles =
      before ? knot.angles : Vector2d(knot.angles + s * (knot.rates + s / 2 * knot.change));
  const double ch = std::cos(angles[0]);
  const double sh = std::sin(angles[0]);
  const double cp = std::cos(angles[1]);
  const double sp = std::sin(angles[1]);
  const Vector3d tangent = along(angles);
  const Vector3d bending =
      rates[0] * cp * Vector3d(-sh, ch, 0) + rates[1] * Vector3d(-sp * ch, -sp * sh, cp);
  // Turn of the body per metre: heading about the map's z axis, pitch about its own y axis.
  const Vector3d turn(rates[0] * sp, -rates[1], rates[0] * cp);
  const double both = rates[0] * rates[1];
  const Vector3d turn_change(change[0] * sp + both * cp, -change[1], change[0] * cp - both * sp);

  BodyMotion motion;
  motion.T_map_body = geometry::SE3(geometry::SO3::from_roll_pitch_yaw({0, -angles[1], angles[0]}),
                                    position(chainage));
  motion.velocity = speed * tangent;
  motion.acceleration = acceleration * tangent + speed * speed * bending;
  motion.angular_rate = speed * turn;
  motion.angular_acceleration = acceleration * turn + speed * speed * turn_change;
  return motion;
}

std::vector<Vector3d> PipeRoute::polyline(double spacing) const {
  validation::check_within("spacing", spacing, 0.001, 1e6);
  const auto segments = static_cast<std::size_t>(std::ceil(length() / spacing));
  std::vector<Vector3d> points;
  points.reserve(segments + 1);
  for (std::size_t i = 0; i <= segments; ++i) {
    points.push_back(position(length() * static_cast<double>(i) / static_cast<double>(segments)));
  }
  return points;
}

}  // namespace pipescout::simulation
