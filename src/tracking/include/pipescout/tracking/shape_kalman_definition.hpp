// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/tracking/shape_kalman.hpp"

/// Implementation of `ShapeKalman`, for shapes that are not compiled in the library.
namespace pipescout::tracking {

template <TrackableShape Model>
void ShapeKalman<Model>::start(const State& state, const State& deviation,
                               const State& rate_deviation) {
  mean_ << state, State::Zero();
  covariance_.setZero();
  covariance_.diagonal() << deviation.cwiseAbs2(), rate_deviation.cwiseAbs2();
  moved_.setZero();
}

template <TrackableShape Model>
void ShapeKalman<Model>::predict(double dt, const std::optional<ImageMotion>& motion,
                                 const State& rate_walk, double memory) {
  // The total rate is continuous when the camera's motion becomes available or unavailable.
  const State moved = motion ? Model::moved_by(state(), *motion) : State::Zero();
  if (motion.has_value() != told_) {
    mean_.template tail<kSize>() += moved_ - moved;
    told_ = motion.has_value();
  }
  moved_ = moved;
  const double kept = std::exp(-dt / memory);
  const double path = memory * (1 - kept);  // that a rate of 1 makes until it has faded so far
  mean_.template head<kSize>() += dt * moved_ + path * mean_.template tail<kSize>();
  mean_.template tail<kSize>() *= kept;
  FullCovariance transition = FullCovariance::Identity();
  transition.template topRightCorner<kSize, kSize>().diagonal().setConstant(path);
  transition.template bottomRightCorner<kSize, kSize>().diagonal().setConstant(kept);
  covariance_ = transition * covariance_ * transition.transpose();
  const State density = rate_walk.cwiseAbs2();
  covariance_.template topLeftCorner<kSize, kSize>().diagonal() += density * (dt * dt * dt / 3);
  covariance_.template topRightCorner<kSize, kSize>().diagonal() += density * (dt * dt / 2);
  covariance_.template bottomLeftCorner<kSize, kSize>().diagonal() += density * (dt * dt / 2);
  covariance_.template bottomRightCorner<kSize, kSize>().diagonal() += density * dt;
  wrap();
}

template <TrackableShape Model>
typename ShapeKalman<Model>::Fit ShapeKalman<Model>::correct(
    const ObservationRows<Model::kSize>& rows, double gate, double doubt) {
  Fit fit{.ratio = 1, .gated = true};
  const State predicted = state();
  for (const ObservationRow<Model::kSize>& row : rows.all()) {
    covariance_.template topLeftCorner<kSize, kSize>() += row.slack * row.slack.transpose();
    const Full cross = covariance_.template leftCols<kSize>() * row.gradient;
    const double variance = row.gradient.dot(cross.template head<kSize>()) + row.variance;
    const double innovation = row.residual - row.gradient.dot(state() - predicted);
    const double square = innovation * innovation / variance;
    const double ratio =
        row.span * std::exp(-0.5 * square) / std::sqrt(2 * std::numbers::pi * variance);
    if (row.doubtful && ratio < doubt) {
      fit.ratio *= doubt;
      continue;
    }
    if (!row.bound) {
      fit.ratio *= ratio;
      fit.gated = fit.gated && square <= gate * gate;
    }
    const Full gain = cross / variance;
    mean_ += gain * innovation;
    covariance_ -= gain * cross.transpose();
  }
  wrap();
  return fit;
}

template <TrackableShape Model>
void ShapeKalman<Model>::scale(double factor) {
  // Of differences, which know no origin.
  Full by;
  by << Model::scaled(State::Ones(), factor) - Model::scaled(State::Zero(), factor), State::Zero();
  by.template tail<kSize>() = by.template head<kSize>();
  mean_.template head<kSize>() = Model::scaled(state(), factor);
  mean_.template tail<kSize>().array() *= by.template tail<kSize>().array();
  moved_.array() *= by.template tail<kSize>().array();
  covariance_ = by.asDiagonal() * covariance_ * by.asDiagonal();
}

template <TrackableShape Model>
void ShapeKalman<Model>::widen(const State& deviation, const State& rate_deviation) {
  covariance_.diagonal().template head<kSize>() += deviation.cwiseAbs2();
  covariance_.diagonal().template tail<kSize>() += rate_deviation.cwiseAbs2();
}

template <TrackableShape Model>
void ShapeKalman<Model>::wrap() {
  for (int i = 0; i < kSize; ++i) {
    const double period = Model::kPeriods[static_cast<std::size_t>(i)];
    if (period > 0) {
      mean_[i] = std::remainder(mean_[i], period);
    }
  }
  // What rounding takes from the symmetry would grow.
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

}  // namespace pipescout::tracking
