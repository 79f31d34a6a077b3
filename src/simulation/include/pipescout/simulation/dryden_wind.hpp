// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <random>

/// Wind with the gusts of MIL-F-8785C (Dryden form, low-altitude model): a mean wind by height, and
/// turbulence of known spectrum along, across and above it, with the rotation of the air that goes
/// with it. SI units outside; the standard's feet inside.
namespace pipescout::simulation {

struct DrydenWindParameters {
  /// W20: mean wind at 20 feet (6.1 m) above the ground, m/s, [0, 40]. The standard calls 7.7
  /// (15 knots) light, 15.4 moderate and 23.1 severe. It scales the turbulence too.
  double speed_at_20_feet = 5;
  double direction = 0;  ///< rad: direction in which the mean wind blows, from x towards y
  /// m above the ground, [0, 304.8]: the model's range; below 10 feet as at 10 feet.
  double height = 3;
  double vehicle_speed = 0;  ///< m/s, [0, 100]: of the vehicle over the ground, as a rule
  /// m/s, [0.1, 10]. The model carries frozen turbulence past the vehicle at its airspeed V, here
  /// the mean wind plus `vehicle_speed`; a hovering vehicle in still air would never meet another
  /// gust. This is the lower bound of V.
  double smallest_airspeed = 1;
  double span = 0.5;     ///< b, m, [0.05, 100]: of the vehicle; smaller gusts do not rotate it
  double period = 0.01;  ///< s, [1e-4, 10]: between samples

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Parameters of MIL-F-8785C for one height and airspeed. Axes of the turbulence: u along the mean
/// wind, v to its left, w up.
struct DrydenModel {
  double airspeed = 0;                                     ///< V, m/s
  double mean_speed = 0;                                   ///< of the wind at this height, m/s
  Eigen::Vector3d length_scale = Eigen::Vector3d::Zero();  ///< L_u, L_v, L_w, m
  Eigen::Vector3d intensity = Eigen::Vector3d::Zero();     ///< sigma_u, sigma_v, sigma_w, m/s
  double span = 0;                                         ///< b, m

  /// One-sided spectral densities at an angular frequency, rad/s: their integrals over [0, inf) are
  /// variances. (m/s)^2 s/rad of u, v, w; (rad/s)^2 s/rad of the rotation rates p, q, r.
  [[nodiscard]] Eigen::Vector3d velocity_spectrum(double angular_frequency) const noexcept;
  [[nodiscard]] Eigen::Vector3d rotation_spectrum(double angular_frequency) const noexcept;
};

/// Mean wind: the standard's logarithmic profile over ground of roughness 0.15 ft. Throws what
/// `DrydenWindParameters::validate` throws.
[[nodiscard]] DrydenModel dryden_model(const DrydenWindParameters& parameters);

struct WindSample {
  /// Of the air: mean and gust, m/s, in the frame of `direction` (x, y level, z up).
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  /// Rotation of the air around the vehicle, treated as rigid, rad/s, in that frame: p about u, q
  /// about v (-dw/dx), r about w (dv/dx). The standard's signs, which it leaves open, are chosen
  /// so.
  Eigen::Vector3d rotation_rate = Eigen::Vector3d::Zero();
};

/// The forming filters of the spectra, driven by white noise and discretised exactly: at the
/// samples, variances and correlations are those of the continuous process, whatever the period,
/// from the first sample on. The same seed gives the same bits. Allocates nothing after
/// construction.
class DrydenWind {
 public:
  /// Throws what `DrydenWindParameters::validate` throws.
  DrydenWind(const DrydenWindParameters& parameters, std::uint64_t seed);

  /// The first at time 0, the next a period later, and so on.
  WindSample next();

  [[nodiscard]] const DrydenModel& model() const noexcept { return model_; }

 private:
  /// x(t + period) = transition x(t) + noise n, n white of unit covariance; outputs = output x.
  template <int kStates, int kOutputs>
  struct Filter {
    using State = Eigen::Matrix<double, kStates, 1>;
    using Square = Eigen::Matrix<double, kStates, kStates>;
    Square transition = Square::Zero();
    Square noise = Square::Zero();
    Eigen::Matrix<double, kOutputs, kStates> output =
        Eigen::Matrix<double, kOutputs, kStates>::Zero();
    State state = State::Zero();

    /// The output now; then one period on.
    Eigen::Matrix<double, kOutputs, 1> next(std::mt19937_64& engine);
  };
  /// Gust across the motion, and the rotation that its change along the motion makes.
  using CrossFilter = Filter<3, 2>;
  static CrossFilter cross_filter(double airspeed, double length, double intensity,
                                  double rotation_time, double period, std::mt19937_64& engine);
  static Filter<1, 1> first_order_filter(double pole, double deviation, double period,
                                         std::mt19937_64& engine);

  DrydenModel model_;
  Eigen::Matrix3d R_frame_wind_;
  std::mt19937_64 engine_;
  Filter<1, 1> along_;  ///< u
  CrossFilter left_;    ///< v, r
  CrossFilter up_;      ///< w, q
  Filter<1, 1> roll_;   ///< p
};

}  // namespace pipescout::simulation
