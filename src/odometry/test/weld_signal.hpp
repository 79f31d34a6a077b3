// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"

namespace pipescout::odometry::test {

using Complex = std::complex<double>;
using Signal = std::function<Complex(double distance)>;

/// Two bells of opposite sign, `width` apart.
Complex doublet(double distance, double middle, double width, Complex peak = {1.0, 0.0});

/// Doublets of the same width and peak.
Signal welds_at(std::vector<double> middles, double width = 0.04, Complex peak = {1.0, 0.0});

/// A crawler that samples a signal in white noise and hands it to a detector.
class Crawl {
 public:
  Crawl(WeldDetector& detector, Signal signal, double noise, std::uint64_t seed);

  /// In equal steps up or down to a place, without the last one.
  void go_to(double distance, double step = 0.0015);
  /// One sample that says it was taken somewhere.
  void sample(double distance);
  void sample(double distance, Impedance value);
  void finish();

  [[nodiscard]] const std::vector<WeldEvent>& events() const { return events_; }
  [[nodiscard]] std::vector<double> distances() const;

 private:
  void keep(std::span<const WeldEvent> events);

  WeldDetector& detector_;
  Signal signal_;
  double noise_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  double at_ = 0.0;
  std::vector<WeldEvent> events_;
};

}  // namespace pipescout::odometry::test
