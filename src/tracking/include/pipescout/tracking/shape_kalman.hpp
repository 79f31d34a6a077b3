// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/tracking/shapes.hpp"
#include "pipescout/tracking/trackable_shape.hpp"

namespace pipescout::tracking {

/// A Kalman filter over a shape and its rates. The rate of a shape is that of the picture, where
/// it is told, and what the filter adds: a random walk that fades. Not thread-safe.
template <TrackableShape Model>
class ShapeKalman {
 public:
  using State = ShapeState<Model>;
  using Covariance = ShapeCovariance<Model>;

  void start(const State& state, const State& deviation, const State& rate_deviation);
  /// `rate_walk`: as of ShapeTrackerParameters; `memory`: s, in which the added rate fades.
  void predict(double dt, const std::optional<ImageMotion>& motion, const State& rate_walk,
               double memory);

  struct Fit {
    double ratio = 0;    ///< likelihood of the readings over that of clutter
    bool gated = false;  ///< all of them but doubtful ones are within the gate
  };
  /// Takes readings in, one after the other. Doubtful ones are left out that are less probable than
  /// `doubt` has it; the residuals are beside the state at which they were taken.
  Fit correct(const ObservationRows<Model::kSize>& rows, double gate, double doubt);

  void scale(double factor);
  /// Adds to what is uncertain of the shape and its rate.
  void widen(const State& deviation, const State& rate_deviation);

  [[nodiscard]] State state() const { return mean_.template head<kSize>(); }
  [[nodiscard]] Covariance covariance() const {
    return covariance_.template topLeftCorner<kSize, kSize>();
  }
  /// Of picture and filter together.
  [[nodiscard]] State rate() const { return moved_ + mean_.template tail<kSize>(); }

 private:
  static constexpr int kSize = static_cast<int>(Model::kSize);
  using Full = Eigen::Matrix<double, 2 * kSize, 1>;
  using FullCovariance = Eigen::Matrix<double, 2 * kSize, 2 * kSize>;

  void wrap();

  Full mean_ = Full::Zero();  // the shape, and the rate beside `moved_`
  FullCovariance covariance_ = FullCovariance::Identity();
  State moved_ = State::Zero();
  bool told_ = false;  // whether the motion of the picture was, at the last prediction
};

extern template class ShapeKalman<PipeShape>;
extern template class ShapeKalman<ValveShape>;
extern template class ShapeKalman<VesselShape>;

}  // namespace pipescout::tracking
