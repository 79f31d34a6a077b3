// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry::test {

/// What a wheel shows after the crawler has gone `distance` m in `time` s; NaN: nothing usable.
using WheelModel = std::function<double(double time, double distance)>;

struct BenchWheel {
  WheelModel model = [](double, double distance) { return distance; };
  double period = 0.02;  ///< s
  double start = 0.0;    ///< s, of the first sample
  /// Samples that are sent at all.
  std::function<bool(double time)> sends = [](double) { return true; };
};

/// Drives wheels along `position(time)` and feeds their samples to the stream in the order of time.
class OdometerBench {
 public:
  OdometerBench(OdometerStream& stream, std::vector<BenchWheel> wheels,
                std::function<double(double time)> position);

  /// Up to and including `time`.
  void run_until(double time);
  /// After each sample.
  std::function<void()> observe = [] {};

 private:
  OdometerStream& stream_;
  std::vector<BenchWheel> wheels_;
  std::function<double(double)> position_;
  std::vector<long> sent_;
};

/// `count` absolute odometers of 1 mm and 0.003 m per square root of metre.
OdometerStreamParameters fine_odometers(std::size_t count);

}  // namespace pipescout::odometry::test
