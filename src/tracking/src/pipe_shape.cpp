// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {
namespace {

using Eigen::Vector2d;
using State = ShapeState<PipeShape>;
using Row = ObservationRow<PipeShape::kSize>;

Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

Vector2d across(const Vector2d& u) {
  return {-u.y(), u.x()};
}

double diagonal(const ImageSize& image) {
  return std::hypot(image.width, image.height);
}

/// How far within the border of the picture a point is, px; negative outside.
double inside(const Vector2d& point, const ImageSize& image) {
  return std::min(
      {point.x(), point.y(), image.width - 1 - point.x(), image.height - 1 - point.y()});
}

/// From a point in the picture to its border, px, in a direction.
double ahead(const Vector2d& point, const Vector2d& towards, const ImageSize& image) {
  const Vector2d last(image.width - 1, image.height - 1);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 2; ++i) {
    if (towards[i] != 0) {
      least = std::min(least, ((towards[i] > 0 ? last[i] : 0) - point[i]) / towards[i]);
    }
  }
  return least;
}

/// In (-pi/2, pi/2].
double axis_angle(double angle) {
  const double wrapped = std::remainder(angle, std::numbers::pi);
  return wrapped <= -std::numbers::pi / 2 ? std::numbers::pi / 2 : wrapped;
}

/// Of the diagonal: of an end that is uncertain by more nothing is known.
constexpr double kOpenShare = 0.25;

/// px: by how much an end is uncertain beside the pipe as a whole, which coasting makes uncertain.
double own_deviation(const Row& row, double side, const PipeShape::Covariance& covariance) {
  return std::sqrt(std::max(0.0, side * row.gradient.dot(covariance.col(PipeShape::kLength))));
}

/// About a diagonal beyond the border, anywhere. `to_border`: px, from the predicted end, along u.
void set_open(Row& row, const Vector2d& u, double side, double span, double to_border) {
  row.bound = true;
  row.residual = to_border + side * span;
  row.variance = span * span;
  row.slack << side * span * u, 2 * span, 0;
}

State section(const Vector2d& from, const Vector2d& to) {
  const Vector2d middle = 0.5 * (from + to);
  const Vector2d along = to - from;
  return {middle.x(), middle.y(), along.norm(), axis_angle(std::atan2(along.y(), along.x()))};
}

}  // namespace

State PipeShape::state_of(const PipeRegion& region) {
  return section(region.start, region.end);
}

double PipeShape::size_of(const PipeRegion& region) {
  const bool sensible = region.half_width >= 0 && std::isfinite(region.half_width);
  return sensible ? (region.end - region.start).norm() : 0;
}

PipeRegion PipeShape::joined(const PipeRegion& likelier, const PipeRegion& other,
                             const ImageSize& image, const Ends& censored) const {
  const Vector2d u = direction(state_of(likelier)[kAngle]);
  PipeRegion both = likelier;
  const bool forwards = u.dot(both.end - both.start) >= 0;
  Vector2d& start = forwards ? both.start : both.end;
  Vector2d& end = forwards ? both.end : both.start;
  for (const Vector2d& of_other : {other.start, other.end}) {
    if (inside(of_other, image) > border) {
      continue;
    }
    if (censored.start && u.dot(of_other - start) < 0) {
      start = of_other;
    } else if (censored.end && u.dot(of_other - end) > 0) {
      end = of_other;
    }
  }
  return both;
}

void PipeShape::observe(const PipeRegion& region, const State& predicted,
                        const Covariance& covariance, const ImageSize& image,
                        ObservationRows<kSize>& rows) const {
  rows.clear();
  const Vector2d u = direction(predicted[kAngle]);
  const Vector2d n = across(u);
  const Vector2d centre = predicted.head<2>();
  const State seen = state_of(region);
  const Vector2d middle = seen.head<2>();
  const double length = seen[kLength];
  const double span = diagonal(image);

  const double cut = region.cut_along ? region.half_width : 0;
  Row offset;
  offset.gradient << n.x(), n.y(), 0, u.dot(middle - centre);
  offset.residual = n.dot(middle - centre);
  // The mean of two halves.
  offset.variance = edge_deviation * edge_deviation / 2 + cut * cut;
  offset.span = span;
  rows.add(offset);

  Row turn;
  turn.gradient[kAngle] = 1;
  turn.residual = std::remainder(seen[kAngle] - predicted[kAngle], std::numbers::pi);
  // The line through the middles of two halves.
  const double deviation = std::numbers::sqrt2 * edge_deviation / std::max(length / 2, 1.0);
  turn.variance = deviation * deviation;
  turn.span = std::numbers::pi;
  rows.add(turn);

  const bool forwards = u.dot(region.end - region.start) >= 0;
  for (const double side : {-1.0, 1.0}) {
    const Vector2d& end = (side > 0) == forwards ? region.end : region.start;
    Row row;
    row.gradient << u.x(), u.y(), side / 2, n.dot(centre - end);
    row.residual = u.dot(end - centre) - side * predicted[kLength] / 2;
    row.variance = end_deviation * end_deviation;
    row.span = span;
    const double uncertain = std::sqrt(row.gradient.dot(covariance * row.gradient));
    const double short_piece = least_piece * std::max(image.width, image.height);
    if (inside(end, image) <= border || (own_deviation(row, side, covariance) >= short_piece &&
                                         ahead(end, side * u, image) <= short_piece)) {
      const double beyond = -side * row.residual;  // px, of the predicted end
      // What is farther away would be a lever by which the smallest turn throws what is in view.
      constexpr double kFarthest = 2;  // diagonals
      if (uncertain < kOpenShare * span && beyond < kFarthest * span) {
        if (beyond > 0) {
          continue;  // as it is known to be
        }
        constexpr double kNear = 3;  // deviations
        if (-beyond <= border + kNear * std::hypot(uncertain, end_deviation)) {
          rows.add(row);  // about to leave the picture
          continue;
        }
      }
      set_open(row, u, side, span, row.residual);
    } else {
      row.doubtful = true;
    }
    rows.add(row);
  }
}

void PipeShape::keep_open(const State& predicted, const Covariance& covariance,
                          const ImageSize& image, ObservationRows<kSize>& rows) const {
  rows.clear();
  const Vector2d u = direction(predicted[kAngle]);
  State endless = predicted;
  constexpr double kEndless = 1e7;  // px
  endless[kLength] = kEndless;
  const auto across_picture = in_view(endless, image);
  if (!across_picture.in_view) {
    return;
  }
  const double span = diagonal(image);
  for (const double side : {-1.0, 1.0}) {
    Row row;
    row.gradient << u.x(), u.y(), side / 2, 0;
    const double border_at = u.dot(across_picture.shape.head<2>() - predicted.head<2>()) +
                             side * across_picture.shape[kLength] / 2;
    const double beyond = predicted[kLength] / 2 - side * border_at;  // px, of the predicted end
    if (own_deviation(row, side, covariance) < kOpenShare * span || beyond > span / 2) {
      continue;
    }
    set_open(row, u, side, span, border_at - side * predicted[kLength] / 2);
    rows.add(row);
  }
}

ShapeInView<PipeShape::kSize> PipeShape::in_view(const State& state, const ImageSize& image) {
  const Vector2d u = direction(state[kAngle]);
  const Vector2d centre = state.head<2>();
  const Vector2d last(image.width - 1, image.height - 1);
  double from = -state[kLength] / 2;
  double to = state[kLength] / 2;
  ShapeInView<PipeShape::kSize> result;
  result.shape = state;
  for (int i = 0; i < 2; ++i) {
    // At what place along the axis it crosses the lower and the upper border.
    if (u[i] == 0) {
      if (centre[i] < 0 || centre[i] > last[i]) {
        return result;
      }
      continue;
    }
    const double low = -centre[i] / u[i];
    const double high = (last[i] - centre[i]) / u[i];
    if (std::min(low, high) > from) {
      from = std::min(low, high);
      result.start_censored = true;
    }
    if (std::max(low, high) < to) {
      to = std::max(low, high);
      result.end_censored = true;
    }
  }
  if (!(from < to)) {
    result.start_censored = false;
    result.end_censored = false;
    return result;
  }
  result.in_view = true;
  result.shape.head<2>() = centre + 0.5 * (from + to) * u;
  result.shape[kLength] = to - from;
  return result;
}

State PipeShape::moved_by(const State& state, const ImageMotion& motion) {
  const Vector2d u = direction(state[kAngle]);
  const Vector2d centre = motion.of(state.head<2>());
  const Vector2d along = motion.gradient * u;
  return {centre.x(), centre.y(), state[kLength] * u.dot(along), across(u).dot(along)};
}

State PipeShape::scaled(const State& state, double factor) {
  // Pixel 0 reaches from -0.5 to 0.5.
  return {factor * (state[kX] + 0.5) - 0.5, factor * (state[kY] + 0.5) - 0.5,
          factor * state[kLength], state[kAngle]};
}

}  // namespace pipescout::tracking
