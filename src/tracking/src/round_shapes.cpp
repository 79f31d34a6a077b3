// SPDX-License-Identifier: Apache-2.0
// Valves and vessels: what is read off a region are its numbers.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {
namespace {

using Eigen::Vector2d;

/// A reading of one number itself.
template <class Model>
void read(std::size_t number, const ShapeState<Model>& seen, const ShapeState<Model>& predicted,
          double deviation, double span, ObservationRows<Model::kSize>& rows) {
  const auto i = static_cast<Eigen::Index>(number);
  const double period = Model::kPeriods[number];
  ObservationRow<Model::kSize> row;
  row.gradient[i] = 1;
  row.residual =
      period > 0 ? std::remainder(seen[i] - predicted[i], period) : seen[i] - predicted[i];
  row.variance = deviation * deviation;
  row.span = span;
  rows.add(row);
}

/// As long as its middle is in the picture nothing is said of its border.
template <class Model>
ShapeInView<Model::kSize> whole_in_view(const ShapeState<Model>& state, const ImageSize& image) {
  ShapeInView<Model::kSize> result;
  result.shape = state;
  result.in_view =
      state[0] >= 0 && state[1] >= 0 && state[0] <= image.width - 1 && state[1] <= image.height - 1;
  return result;
}

/// Growth of lengths in all directions, 1/s.
double growth(const ImageMotion& motion) {
  return motion.gradient.trace() / 2;
}

}  // namespace

ShapeState<ValveShape> ValveShape::state_of(const Region& region) {
  return region;
}

double ValveShape::size_of(const Region& region) {
  return region[kRadius];
}

void ValveShape::observe(const Region& region, const ShapeState<ValveShape>& predicted,
                         const Covariance& /*covariance*/, const ImageSize& image,
                         ObservationRows<kSize>& rows) const {
  rows.clear();
  read<ValveShape>(kX, region, predicted, edge_deviation, image.width, rows);
  read<ValveShape>(kY, region, predicted, edge_deviation, image.height, rows);
  read<ValveShape>(kRadius, region, predicted, edge_deviation, std::min(image.width, image.height),
                   rows);
}

ShapeInView<ValveShape::kSize> ValveShape::in_view(const ShapeState<ValveShape>& state,
                                                   const ImageSize& image) {
  return whole_in_view<ValveShape>(state, image);
}

ShapeState<ValveShape> ValveShape::moved_by(const ShapeState<ValveShape>& state,
                                            const ImageMotion& motion) {
  const Vector2d centre = motion.of(state.head<2>());
  return {centre.x(), centre.y(), state[kRadius] * growth(motion)};
}

ShapeState<ValveShape> ValveShape::scaled(const ShapeState<ValveShape>& state, double factor) {
  return {factor * (state[kX] + 0.5) - 0.5, factor * (state[kY] + 0.5) - 0.5,
          factor * state[kRadius]};
}

ShapeState<VesselShape> VesselShape::state_of(const Region& region) {
  ShapeState<VesselShape> state = region;
  state[kAngle] = std::remainder(region[kAngle], std::numbers::pi);
  return state;
}

double VesselShape::size_of(const Region& region) {
  return region[kLength];
}

void VesselShape::observe(const Region& region, const ShapeState<VesselShape>& predicted,
                          const Covariance& /*covariance*/, const ImageSize& image,
                          ObservationRows<kSize>& rows) const {
  rows.clear();
  const double longest = std::hypot(image.width, image.height);
  read<VesselShape>(kX, region, predicted, edge_deviation, image.width, rows);
  read<VesselShape>(kY, region, predicted, edge_deviation, image.height, rows);
  read<VesselShape>(kLength, region, predicted, edge_deviation, longest, rows);
  read<VesselShape>(kWidth, region, predicted, edge_deviation, longest, rows);
  // The line through the middles of two halves.
  const double turn = 2 * std::numbers::sqrt2 * edge_deviation / std::max(region[kLength], 2.0);
  read<VesselShape>(kAngle, region, predicted, turn, std::numbers::pi, rows);
}

ShapeInView<VesselShape::kSize> VesselShape::in_view(const ShapeState<VesselShape>& state,
                                                     const ImageSize& image) {
  return whole_in_view<VesselShape>(state, image);
}

ShapeState<VesselShape> VesselShape::moved_by(const ShapeState<VesselShape>& state,
                                              const ImageMotion& motion) {
  const Vector2d centre = motion.of(state.head<2>());
  const Vector2d u(std::cos(state[kAngle]), std::sin(state[kAngle]));
  const Vector2d n(-u.y(), u.x());
  const Vector2d along = motion.gradient * u;
  ShapeState<VesselShape> rate;
  rate << centre, state[kLength] * u.dot(along), state[kWidth] * n.dot(motion.gradient * n),
      n.dot(along);
  return rate;
}

ShapeState<VesselShape> VesselShape::scaled(const ShapeState<VesselShape>& state, double factor) {
  ShapeState<VesselShape> result;
  result << factor * (state[kX] + 0.5) - 0.5, factor * (state[kY] + 0.5) - 0.5,
      factor * state[kLength], factor * state[kWidth], state[kAngle];
  return result;
}

}  // namespace pipescout::tracking
