// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>

/// An inertial measurement unit with the error terms of its data sheet. SI units and radians.
///
/// The reading of an axis is (1 + scale error) (true + misalignment * the other axes) + bias +
/// white noise, limited to the range and rounded to the resolution. The bias is a constant, flicker
/// noise and a random walk. Flicker: Gauss-Markov processes of equal variance, with time constants
/// 4 times apart from 1/16 s to 4096 s. The sum of so many has a spectrum of 1/f between, and an
/// Allan deviation that is flat, as high as the deviation of one of them: within 3 % from 1 to 1000
/// s.
namespace pipescout::simulation {

/// Three axes of one kind. Unit u: rad/s for a gyro, m/s^2 for an accelerometer. Standard
/// deviations are those of one draw per axis at construction.
struct InertialTriadParameters {
  double noise_density = 0;     ///< u/sqrt(Hz), [0, 10]: angle or velocity random walk
  double bias_instability = 0;  ///< u, [0, 10]: floor of the Allan deviation
  double bias_random_walk = 0;  ///< u/s/sqrt(Hz), [0, 10]: rate or acceleration random walk
  double turn_on_bias = 0;      ///< u, [0, 10], deviation
  double scale_error = 0;       ///< [0, 0.2], deviation
  double misalignment = 0;      ///< rad, [0, 0.2], deviation, towards each of the other two axes
  double range = 1e6;           ///< u, (0, 1e6]
  double resolution = 0;        ///< u, [0, 10]; 0: exact
};

struct ImuParameters {
  InertialTriadParameters gyro{};
  InertialTriadParameters accelerometer{};
  double period = 0.004;  ///< s, [1e-4, 1]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;

  /// ADIS16495-1 (Analog Devices, data sheet Rev. C): 0.09 deg/sqrt(h), 0.8 deg/h, +-125 deg/s,
  /// 3.2 ug, +-8 g, 0.05 degrees axis to axis; 0.008 m/s/sqrt(h).
  [[nodiscard]] static ImuParameters tactical();
  /// ADIS16470 (Analog Devices, data sheet Rev. C): 0.008 deg/s/sqrt(Hz), 8 deg/h, +-2000 deg/s,
  /// 13 ug, +-40 g; 0.037 m/s/sqrt(h).
  [[nodiscard]] static ImuParameters industrial();
  /// BMI088 (Bosch Sensortec, data sheet BST-BMI088-DS001): 0.014 deg/s/sqrt(Hz), below 2 deg/h in
  /// its best axis (10 deg/h here), offset 1 deg/s; 175 ug/sqrt(Hz), offset 20 mg, +-24 g;
  /// sensitivity 1 % and 0.5 %; 16 bits.
  [[nodiscard]] static ImuParameters consumer();
  /// "tactical", "industrial" or "consumer". Throws std::invalid_argument for another name.
  [[nodiscard]] static ImuParameters of_grade(std::string_view grade);
};

/// One sample, of an instant.
struct ImuReading {
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();    ///< rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s^2
};

/// The same parameters, seed and truth give the same bits. Allocates nothing after construction.
class ImuSensor {
 public:
  /// Throws what `ImuParameters::validate` throws.
  ImuSensor(const ImuParameters& parameters, std::uint64_t seed);

  /// The sample for this truth; one per period.
  ImuReading measure(const ImuReading& truth);

  /// Biases of the last sample (before the first: the initial ones).
  [[nodiscard]] ImuReading biases() const noexcept;
  [[nodiscard]] const ImuParameters& parameters() const noexcept { return parameters_; }

  static constexpr std::size_t kFlickerProcesses = 9;

 private:
  struct Triad {
    Eigen::Matrix3d shown_by_true = Eigen::Matrix3d::Identity();
    Eigen::Vector3d constant = Eigen::Vector3d::Zero();
    Eigen::Vector3d walk = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector3d, kFlickerProcesses> flicker{};

    [[nodiscard]] Eigen::Vector3d bias() const noexcept;
  };

  [[nodiscard]] Triad make(const InertialTriadParameters& parameters);
  void drift(const InertialTriadParameters& parameters, Triad& triad);
  Eigen::Vector3d show(const InertialTriadParameters& parameters, const Triad& triad,
                       const Eigen::Vector3d& truth);

  ImuParameters parameters_;
  std::mt19937_64 engine_;
  std::array<double, kFlickerProcesses> decay_{};  ///< of a flicker process over a period
  Triad gyro_;
  Triad accelerometer_;
  bool started_ = false;
};

}  // namespace pipescout::simulation
