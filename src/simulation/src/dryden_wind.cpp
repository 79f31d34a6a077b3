// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/dryden_wind.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kLowest = 10;       // ft: the low-altitude model's range
constexpr double kHighest = 1000;    // ft
constexpr double kRoughness = 0.15;  // ft, z_0 of flight category C (terminal phases)
constexpr double kPi = std::numbers::pi;

double cube_root_term(const DrydenModel& model) {
  return 0.8 * std::cbrt(kPi * model.length_scale.z() / (4 * model.span));
}

template <int kStates>
using Square = Eigen::Matrix<double, kStates, kStates>;

/// x' = A x + white noise of covariance `intensity` per second, looked at after an interval:
/// x is then `transition` x + noise of covariance `covariance`.
template <int kStates>
struct Discretised {
  Square<kStates> transition;
  Square<kStates> covariance;
};

/// Taylor series over a fraction of the interval short enough for it, then doubled: unlike the
/// difference of two stationary covariances, that keeps its precision for intervals far below the
/// time constants, where the covariance goes with high powers of the interval.
template <int kStates>
Discretised<kStates> discretised(const Square<kStates>& a, const Square<kStates>& intensity,
                                 double interval, int doublings_beyond = 0) {
  constexpr double kShort = 0.1;
  constexpr int kTerms = 14;
  const double size = a.cwiseAbs().rowwise().sum().maxCoeff() * interval;
  const int doublings = size > kShort ? static_cast<int>(std::ceil(std::log2(size / kShort))) : 0;
  const double fraction = std::ldexp(interval, -doublings);
  Discretised<kStates> result{Square<kStates>::Identity(), intensity * fraction};
  Square<kStates> power = Square<kStates>::Identity();
  Square<kStates> term = result.covariance;
  for (int k = 1; k <= kTerms; ++k) {
    power = (power * a * (fraction / k)).eval();
    term = ((a * term + term * a.transpose()) * (fraction / (k + 1))).eval();
    result.transition += power;
    result.covariance += term;
  }
  for (int k = 0; k < doublings + doublings_beyond; ++k) {
    result.covariance +=
        (result.transition * result.covariance * result.transition.transpose()).eval();
    result.transition = (result.transition * result.transition).eval();
  }
  return result;
}

/// A factor L with L L^T = covariance.
template <int kStates>
Square<kStates> factor(const Square<kStates>& covariance) {
  const Eigen::LLT<Square<kStates>> decomposition(covariance);
  if (decomposition.info() != Eigen::Success) {
    throw std::logic_error("dryden_wind: a covariance is not positive definite");
  }
  return decomposition.matrixL();
}

template <int kStates>
Eigen::Matrix<double, kStates, 1> white(std::mt19937_64& engine) {
  Eigen::Matrix<double, kStates, 1> result;
  for (double& entry : result) {
    entry = statistics::normal(engine);
  }
  return result;
}

/// Fills in the filter of x' = A x + noise and draws its first state from where it always is.
template <typename Filter, int kStates>
void set_up(Filter& filter, const Square<kStates>& a, const Square<kStates>& intensity,
            double period, std::mt19937_64& engine) {
  // 2^64 times the period is beyond any memory: what is left of the start is exactly 0.
  constexpr int kForever = 64;
  const Discretised<kStates> step = discretised<kStates>(a, intensity, period);
  filter.transition = step.transition;
  filter.noise = factor<kStates>(step.covariance);
  filter.state = factor<kStates>(discretised<kStates>(a, intensity, period, kForever).covariance) *
                 white<kStates>(engine);
}

}  // namespace

void DrydenWindParameters::validate() const {
  using validation::check_within;
  check_within("speed_at_20_feet", speed_at_20_feet, 0, 40);
  check_within("direction", direction, -100, 100);
  check_within("height", height, 0, kHighest * kMetresPerFoot);
  check_within("vehicle_speed", vehicle_speed, 0, 100);
  check_within("smallest_airspeed", smallest_airspeed, 0.1, 10);
  check_within("span", span, 0.05, 100);
  check_within("period", period, 1e-4, 10);
}

DrydenModel dryden_model(const DrydenWindParameters& parameters) {
  parameters.validate();
  const double height = std::clamp(parameters.height / kMetresPerFoot, kLowest, kHighest);
  const double shape = 0.177 + 0.000823 * height;
  const double length = height / std::pow(shape, 1.2) * kMetresPerFoot;
  const double intensity_up = 0.1 * parameters.speed_at_20_feet;
  const double intensity = intensity_up / std::pow(shape, 0.4);
  DrydenModel model;
  model.mean_speed =
      parameters.speed_at_20_feet * std::log(height / kRoughness) / std::log(20 / kRoughness);
  model.airspeed =
      std::max(parameters.smallest_airspeed, model.mean_speed + parameters.vehicle_speed);
  model.length_scale = {length, length, height * kMetresPerFoot};
  model.intensity = {intensity, intensity, intensity_up};
  model.span = parameters.span;
  return model;
}

Eigen::Vector3d DrydenModel::velocity_spectrum(double angular_frequency) const noexcept {
  const Eigen::Array3d time = length_scale.array() / airspeed;
  const Eigen::Array3d x = (time * angular_frequency).square();
  const Eigen::Array3d level = intensity.array().square() * time / kPi;
  return {level[0] * 2 / (1 + x[0]), level[1] * (1 + 3 * x[1]) / ((1 + x[1]) * (1 + x[1])),
          level[2] * (1 + 3 * x[2]) / ((1 + x[2]) * (1 + x[2]))};
}

Eigen::Vector3d DrydenModel::rotation_spectrum(double angular_frequency) const noexcept {
  const double wave_number = angular_frequency / airspeed;
  const Eigen::Vector3d velocity = velocity_spectrum(angular_frequency);
  const double x4 = 4 * span * wave_number / kPi;
  const double x3 = 3 * span * wave_number / kPi;
  return {intensity.z() * intensity.z() / (airspeed * length_scale.z()) * cube_root_term(*this) /
              (1 + x4 * x4),
          wave_number * wave_number / (1 + x4 * x4) * velocity.z(),
          wave_number * wave_number / (1 + x3 * x3) * velocity.y()};
}

template <int kStates, int kOutputs>
Eigen::Matrix<double, kOutputs, 1> DrydenWind::Filter<kStates, kOutputs>::next(
    std::mt19937_64& engine) {
  const Eigen::Matrix<double, kOutputs, 1> now = output * state;
  state = (transition * state + noise * white<kStates>(engine)).eval();
  return now;
}

DrydenWind::Filter<1, 1> DrydenWind::first_order_filter(double pole, double deviation,
                                                        double period, std::mt19937_64& engine) {
  Filter<1, 1> filter;
  set_up<Filter<1, 1>, 1>(filter, Square<1>(-pole), Square<1>(2 * pole), period, engine);
  filter.output(0, 0) = deviation;
  return filter;
}

DrydenWind::CrossFilter DrydenWind::cross_filter(double airspeed, double length, double intensity,
                                                 double rotation_time, double period,
                                                 std::mt19937_64& engine) {
  // sigma sqrt(a) (a + sqrt(3) s) / (s + a)^2 in parallel form, with z_1 = sqrt(2 a) / (s + a) n of
  // unit variance and z_2 = a / (s + a) z_1; then f, the gust through 1 / (1 + rotation_time s):
  // (gust - f) / rotation_time is the filtered derivative that makes the rotation.
  const double a = airspeed / length;
  const Eigen::RowVector2d unit_gust =
      Eigen::RowVector2d(std::numbers::sqrt3, 1 - std::numbers::sqrt3) / std::numbers::sqrt2;
  Square<3> dynamics = Square<3>::Zero();
  dynamics(0, 0) = -a;
  dynamics.row(1) << a, -a, 0;
  dynamics.row(2) << unit_gust / rotation_time, -1 / rotation_time;
  Square<3> noise = Square<3>::Zero();
  noise(0, 0) = 2 * a;
  CrossFilter filter;
  set_up<CrossFilter, 3>(filter, dynamics, noise, period, engine);
  filter.output.row(0) << intensity * unit_gust, 0;
  filter.output.row(1) << unit_gust, -1;
  filter.output.row(1) *= intensity / (rotation_time * airspeed);
  return filter;
}

DrydenWind::DrydenWind(const DrydenWindParameters& parameters, std::uint64_t seed)
    : model_(dryden_model(parameters)),
      R_frame_wind_(Eigen::AngleAxisd(parameters.direction, Eigen::Vector3d::UnitZ())),
      engine_(statistics::make_engine(seed, 1)) {
  const double airspeed = model_.airspeed;
  const double period = parameters.period;
  const Eigen::Vector3d& length = model_.length_scale;
  const Eigen::Vector3d& intensity = model_.intensity;
  const double pass = model_.span / (kPi * airspeed);  // s
  along_ = first_order_filter(airspeed / length.x(), intensity.x(), period, engine_);
  left_ = cross_filter(airspeed, length.y(), intensity.y(), 3 * pass, period, engine_);
  up_ = cross_filter(airspeed, length.z(), intensity.z(), 4 * pass, period, engine_);
  const double roll_variance = model_.rotation_spectrum(0).x() * kPi / (8 * pass);
  roll_ = first_order_filter(1 / (4 * pass), std::sqrt(roll_variance), period, engine_);
}

WindSample DrydenWind::next() {
  const double along = along_.next(engine_)(0);
  const Eigen::Vector2d left = left_.next(engine_);
  const Eigen::Vector2d up = up_.next(engine_);
  const double roll = roll_.next(engine_)(0);
  // The turbulence is carried along u, so that what changes in time at the vehicle changes the
  // other way along u: d/dx = -1/V d/dt. Hence q = -dw/dx = w'/V, and r = dv/dx = -v'/V.
  return {.velocity = R_frame_wind_ * Eigen::Vector3d(model_.mean_speed + along, left[0], up[0]),
          .rotation_rate = R_frame_wind_ * Eigen::Vector3d(roll, up[1], -left[1])};
}

}  // namespace pipescout::simulation
