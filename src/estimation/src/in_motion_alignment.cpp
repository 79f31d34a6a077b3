// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/in_motion_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::SO3;

constexpr double kUnlikely = 25;            // below the best, of the logarithm of a weight
constexpr double kLikely = 7;               // the same: what may speak for a position
constexpr double kByChance = 0.9999;        // share of good ones that gates let through
constexpr std::size_t kContradictions = 5;  // running
constexpr double kRemembered = 90;          // degrees of freedom of the misfit

template <int Rows>
using RowsOfState = Eigen::Matrix<double, Rows, kStateSize>;

template <int Rows>
struct Innovation {
  Eigen::Matrix<double, Rows, Rows> covariance;
  double chi_square = 0;
  double log_likelihood = 0;  // up to a constant
};

template <int Rows>
Innovation<Rows> innovation_of(const StateMatrix& covariance, const RowsOfState<Rows>& derivative,
                               const Eigen::Matrix<double, Rows, 1>& innovation,
                               const Eigen::Matrix<double, Rows, Rows>& noise) {
  Innovation<Rows> result;
  result.covariance = linear_algebra::propagate(derivative, covariance) + noise;
  const linear_algebra::Cholesky<Rows> root(result.covariance);
  result.chi_square = root.whiten(innovation).squaredNorm();
  result.log_likelihood = -0.5 * (result.chi_square + root.log_determinant());
  return result;
}

/// The update of an extended Kalman filter.
template <int Rows>
void correct(NavState& state, StateMatrix& covariance, const RowsOfState<Rows>& derivative,
             const Eigen::Matrix<double, Rows, 1>& innovation,
             const Eigen::Matrix<double, Rows, Rows>& innovation_covariance) {
  const RowsOfState<Rows> seen = derivative * covariance;
  const linear_algebra::Cholesky<Rows> root(innovation_covariance);
  const RowsOfState<Rows> whitened = root.whiten_columns(seen);
  const StateVector step = whitened.transpose() * root.whiten(innovation);
  state = state.retract(step);
  covariance.noalias() -= whitened.transpose() * whitened;
}

RowsOfState<3> antenna_derivative(const NavState& state, const Vector3d& lever_arm) {
  RowsOfState<3> derivative = RowsOfState<3>::Zero();
  derivative.middleCols<3>(kPosition).setIdentity();
  derivative.middleCols<3>(kRotation) = -state.R_map_body.matrix() * geometry::skew(lever_arm);
  return derivative;
}

Vector3d antenna(const NavState& state, const Vector3d& lever_arm) {
  return state.position + state.R_map_body * lever_arm;
}

double heading_of(const NavState& state) {
  return state.R_map_body.roll_pitch_yaw().z();
}

/// Of a turn about the map's z axis.
RowsOfState<1> heading_derivative(const NavState& state) {
  RowsOfState<1> derivative = RowsOfState<1>::Zero();
  derivative.middleCols<3>(kRotation) = state.R_map_body.matrix().row(2);
  return derivative;
}

}  // namespace

InMotionAlignment::InMotionAlignment(const ImuIntegration& how, std::size_t samples)
    : how_(how), imu_(samples), gate_(statistics::chi_square_quantile(kByChance, 3)) {
  hypotheses_.reserve(kHeadings * kMostStarts);
  told_.reserve(kHeadings * kMostStarts);
}

void InMotionAlignment::begin(double time, const StartHypothesis* starts, std::size_t count) {
  constexpr double kSpacing = 2 * std::numbers::pi / kHeadings;
  // A sum of Gaussians half their spacing wide is even within a per mille's fraction of a radian.
  constexpr double kHeadingDeviation = 0.6 * kSpacing;
  imu_.clear();
  hypotheses_.clear();
  for (std::size_t s = 0; s < std::min(count, kMostStarts); ++s) {
    const StartHypothesis& start = starts[s];
    for (int i = 0; i < kHeadings; ++i) {
      const SO3 turn = SO3::about_z(i * kSpacing);
      Hypothesis h;
      h.stands = start.stands;
      h.state = start.mean;
      h.state.R_map_body = turn * start.mean.R_map_body;
      h.state.velocity = turn * start.mean.velocity;
      h.state.position.setZero();
      StateVector deviations;
      deviations << Vector3d::Zero(), start.tilt_deviation, start.tilt_deviation, kHeadingDeviation,
          Vector3d::Constant(start.velocity_deviation),
          Vector3d::Constant(start.gyro_bias_deviation),
          Vector3d::Constant(start.accelerometer_bias_deviation);
      h.covariance = deviations.cwiseAbs2().asDiagonal();
      // Tilt and heading are about the axes of the map; a rotation is perturbed in the body.
      const Matrix3d to_body = h.state.R_map_body.inverse().matrix();
      h.covariance.block<3, 3>(kRotation, kRotation) =
          to_body * h.covariance.block<3, 3>(kRotation, kRotation) * to_body.transpose();
      hypotheses_.push_back(h);
    }
  }
  begun_ = !hypotheses_.empty();
  time_ = time;
  positions_ = 0;
  gated_running_ = 0;
}

const InMotionAlignment::Hypothesis& InMotionAlignment::best() const noexcept {
  return *std::ranges::max_element(hypotheses_, {}, &Hypothesis::log_weight);
}

ImuPreintegration InMotionAlignment::motion_between(double from, double to) const {
  const NavState& likely = best().state;
  ImuPreintegration motion(likely.gyro_bias, likely.accelerometer_bias);
  imu_.integrate(how_, likely.R_map_body, from, to, motion);
  return motion;
}

void InMotionAlignment::carry(Hypothesis& h, const ImuPreintegration& motion) const {
  // The covariance of the motion has position and velocity in the axes of its beginning.
  StateMatrix turned = StateMatrix::Identity();
  turned.block<3, 3>(kPosition, kPosition) = h.state.R_map_body.matrix();
  turned.block<3, 3>(kVelocity, kVelocity) = h.state.R_map_body.matrix();
  StateMatrix derivative;
  h.state = motion.motion().propagate(h.state, how_.gravity, &derivative);
  h.covariance = linear_algebra::propagate(derivative, h.covariance) +
                 linear_algebra::propagate(turned, motion.covariance());
}

void InMotionAlignment::place(const GpsMeasurement& m, const Vector3d& lever_arm) {
  for (Hypothesis& h : hypotheses_) {
    h.state.position = m.position - h.state.R_map_body * lever_arm;
    // The body is where the antenna is, less the arm: nothing else was known of it.
    StateMatrix to_place = StateMatrix::Identity();
    to_place.middleRows<3>(kPosition) = -antenna_derivative(h.state, lever_arm);
    to_place.block<3, 3>(kPosition, kPosition).setZero();
    h.covariance = linear_algebra::propagate(to_place, h.covariance);
    h.covariance.block<3, 3>(kPosition, kPosition) += m.covariance;
  }
}

void InMotionAlignment::drop_unlikely() {
  const double least = best().log_weight - kUnlikely;
  std::erase_if(hypotheses_, [&](const Hypothesis& h) { return h.log_weight < least; });
}

InMotionAlignment::Verdict InMotionAlignment::add(const GpsMeasurement& m,
                                                  const Vector3d& lever_arm,
                                                  const std::optional<Standstill>& standstill) {
  constexpr double kLeastStep = 1e-4;  // s
  if (!begun_ || m.time < time_ + kLeastStep) {
    return Verdict::kLate;
  }
  const ImuPreintegration motion = motion_between(time_, m.time);
  time_ = m.time;
  for (Hypothesis& h : hypotheses_) {
    carry(h, motion);
    if (h.stands && standstill) {
      // Not part of the weight: it is what this hypothesis takes for granted.
      RowsOfState<6> derivative = RowsOfState<6>::Zero();
      derivative.block<3, 3>(0, kVelocity).setIdentity();
      derivative.block<3, 3>(3, kGyroBias).setIdentity();
      Eigen::Matrix<double, 6, 1> off;
      off << -h.state.velocity, standstill->rate - h.state.gyro_bias;
      Eigen::Matrix<double, 6, 1> deviations;
      deviations << Vector3d::Constant(standstill->velocity_deviation),
          Vector3d::Constant(standstill->rate_deviation);
      const geometry::Matrix6d noise = deviations.cwiseAbs2().asDiagonal();
      const auto innovation = innovation_of<6>(h.covariance, derivative, off, noise);
      correct<6>(h.state, h.covariance, derivative, off, innovation.covariance);
    }
  }
  if (positions_ == 0) {
    place(m, lever_arm);
    ++positions_;
    return Verdict::kUsed;
  }
  const auto off_by = [&](const Hypothesis& h) -> Eigen::Vector3d {
    return m.position - antenna(h.state, lever_arm);
  };
  const double likely = best().log_weight - kLikely;
  const bool reached = std::ranges::any_of(hypotheses_, [&](const Hypothesis& h) {
    return h.log_weight >= likely &&
           innovation_of<3>(h.covariance, antenna_derivative(h.state, lever_arm), off_by(h),
                            m.covariance)
                   .chi_square <= gate_;
  });
  if (!reached) {
    return ++gated_running_ >= kContradictions ? Verdict::kContradicts : Verdict::kGated;
  }
  gated_running_ = 0;
  ++positions_;
  for (Hypothesis& h : hypotheses_) {
    const RowsOfState<3> derivative = antenna_derivative(h.state, lever_arm);
    const Vector3d off = off_by(h);
    const auto innovation = innovation_of<3>(h.covariance, derivative, off, m.covariance);
    correct<3>(h.state, h.covariance, derivative, off, innovation.covariance);
    h.log_weight += innovation.log_likelihood;
    h.misfit += innovation.chi_square;
    h.degrees += 3;
    if (h.degrees > kRemembered) {
      h.misfit /= 2;
      h.degrees /= 2;
    }
  }
  drop_unlikely();
  return Verdict::kUsed;
}

std::optional<InMotionAlignment::Result> InMotionAlignment::solve(
    double time, const std::optional<Heading>& heading) {
  if (!begun_ || positions_ == 0) {
    return std::nullopt;
  }
  told_ = hypotheses_;
  const ImuPreintegration motion = motion_between(time_, time);
  for (Hypothesis& h : told_) {
    if (motion.motion().duration() > 0) {
      carry(h, motion);
    }
    if (heading) {
      using Row = Eigen::Matrix<double, 1, 1>;
      const RowsOfState<1> derivative = heading_derivative(h.state);
      const Row off(std::remainder(heading->value - heading_of(h.state), 2 * std::numbers::pi));
      const Row noise(heading->deviation * heading->deviation);
      const auto innovation = innovation_of<1>(h.covariance, derivative, off, noise);
      correct<1>(h.state, h.covariance, derivative, off, innovation.covariance);
      h.log_weight += innovation.log_likelihood;
    }
  }
  const Hypothesis& likeliest = *std::ranges::max_element(told_, {}, &Hypothesis::log_weight);
  const int degrees = static_cast<int>(likeliest.degrees);
  if (degrees > 0 && likeliest.misfit > statistics::chi_square_quantile(kByChance, degrees)) {
    return std::nullopt;
  }
  double sum = 0;
  StateVector mean = StateVector::Zero();
  for (const Hypothesis& h : told_) {
    const double weight = std::exp(h.log_weight - likeliest.log_weight);
    sum += weight;
    mean += weight * likeliest.state.local(h.state);
  }
  mean /= sum;
  Result result;
  result.positions = positions_;
  for (const Hypothesis& h : told_) {
    const double weight = std::exp(h.log_weight - likeliest.log_weight) / sum;
    const StateVector apart = likeliest.state.local(h.state) - mean;
    result.covariance += weight * (h.covariance + apart * apart.transpose());
  }
  result.state = likeliest.state.retract(mean);
  const RowsOfState<1> derivative = heading_derivative(result.state);
  result.heading_deviation =
      std::sqrt(linear_algebra::propagate(derivative, result.covariance).value());
  return result;
}

}  // namespace pipescout::estimation
