// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/tracking/shapes.hpp"
#include "pipescout/tracking/trackable_shape.hpp"

namespace pipescout::tracking {

/// A Kalman filter over a shape and its rates. The rate of a shape is the sum of the given motion
/// of the image and a decaying random walk estimated by the filter. Not thread-safe.
template <TrackableShape Model>
class ShapeKalman {
 public:
  using State = ShapeState<Model>;
  using Covariance = ShapeCovariance<Model>;

  void start(const State& state, const State& deviation, const State& rate_deviation);
  /// `rate_walk`: as of ShapeTrackerParameters; `memory`: s, time constant of the decay.
  void predict(double dt, const std::optional<ImageMotion>& motion, const State& rate_walk,
               double memory);

  struct Fit {
    double ratio = 0;    ///< likelihood ratio of the readings to clutter
    bool gated = false;  ///< all readings except doubtful ones are within the gate
  };
  /// Sequential update with readings. Doubtful readings less probable than `doubt` are rejected;
  /// the residuals refer to the state at which they were computed.
  Fit correct(const ObservationRows<Model::kSize>& rows, double gate, double doubt);

  void scale(double factor);
  /// Inflates the covariance of the shape and its rate.
  void widen(const State& deviation, const State& rate_deviation);

  [[nodiscard]] State state() const { return mean_.template head<kSize>(); }
  [[nodiscard]] Covariance covariance() const {
    return covariance_.template topLeftCorner<kSize, kSize>();
  }
  /// Sum of the image motion and of the filter.
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
