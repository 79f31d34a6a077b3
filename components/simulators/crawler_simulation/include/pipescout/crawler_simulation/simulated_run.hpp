// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <pipescout/simulation/crawler.hpp>
#include <pipescout/simulation/eddy_current_signal.hpp>
#include <pipescout/simulation/imu_sensor.hpp>
#include <pipescout/simulation/pipe_route.hpp>
#include <pipescout/weld_ledger/tally_file.hpp>
#include <vector>

namespace pipescout {

struct SimulatedRunParameters {
  simulation::JointedPipeParameters pipe{};  ///< of these only what a given tally leaves open
  simulation::PipeParameters features{};     ///< welds and length are those of the tally
  simulation::EddyCurrentParameters signal{};
  simulation::InspectionParameters motion{};  ///< `length` is at most that of the pipe
  simulation::CrawlerParameters crawler{};
  std::size_t start_joint = 0;  ///< of the tally; the crawler starts at its first weld
  /// The centre line in the map, from chainage 0 at its origin on, along x at first; empty:
  /// straight.
  std::vector<simulation::RoutePiece> route{};
  /// m, from the axis to where the wheels touch the wall, at most 10: in the bends of the route
  /// each goes its own way, by its `clock`. 0: all go as far as the axis.
  double pipe_radius = 0.0;
  std::optional<simulation::ImuParameters> imu{};  ///< at the probe; nothing: there is none
  std::uint64_t seed = 1;
};

/// A run of a crawler through a pipe as a tally has it, in the order of time: wheels, probe, truth.
/// Pure; the same parameters give the same bits. Not thread-safe.
class SimulatedRun {
 public:
  /// Throws std::invalid_argument naming the field when a parameter is out of range or the tally
  /// has no such joint.
  SimulatedRun(const SimulatedRunParameters& parameters, const Tally& tally);

  /// What the wheels show at one time.
  struct Readings {
    double time = 0.0;  ///< s
    std::vector<std::size_t> wheels;
    std::vector<double> values;  ///< m; NaN where the wheel gave none
  };
  struct Position {
    std::size_t joint = 0;    ///< of the tally
    double into_joint = 0.0;  ///< m
    double chainage = 0.0;    ///< m, by the true lengths, from the tally's chainage of the start
    double distance = 0.0;    ///< m, from the start
  };

  /// The readings up to a time, s; called with rising times.
  [[nodiscard]] std::vector<Readings> readings_until(double time);
  /// Probe samples up to a time, one each 1 / sample rate; NaN where one is missing.
  [[nodiscard]] std::vector<std::complex<double>> samples_until(double time);
  [[nodiscard]] double sample_interval() const noexcept { return sample_interval_; }
  /// Of the next sample, s.
  [[nodiscard]] double next_sample_time() const noexcept {
    return static_cast<double>(samples_) * sample_interval_;
  }
  struct ImuSample {
    double time = 0.0;  ///< s
    simulation::ImuReading reading{};
  };
  /// What the IMU shows up to a time, s; called with rising times. The first is that of the first
  /// call, which may be before 0: the crawler stands until then.
  [[nodiscard]] std::vector<ImuSample> imu_samples_until(double time);
  /// Before 0: that of 0.
  [[nodiscard]] Position position(double time) const noexcept;
  /// In the map.
  [[nodiscard]] simulation::BodyMotion body_motion(double time) const;
  [[nodiscard]] double duration() const noexcept { return crawler_.motion().duration(); }

 private:
  std::size_t start_joint_;
  double start_chainage_;
  double sample_interval_;
  simulation::Crawler crawler_;
  simulation::EddyCurrentSignal signal_;
  std::optional<simulation::WheelSample> pending_;
  std::uint64_t samples_ = 0;
  simulation::PipeRoute route_;
  std::optional<simulation::ImuSensor> imu_;
  std::optional<double> next_imu_sample_;  // s
};

}  // namespace pipescout
