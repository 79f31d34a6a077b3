// SPDX-License-Identifier: Apache-2.0
#include "estimator_robots.hpp"

#include <cmath>

namespace pipescout::reproduce {

using estimation_study::Sensor;
using estimation_study::Vehicle;

const std::vector<Robot>& robots() {
  static const std::vector<Robot> all{{Vehicle::kGroundRobot,
                                       "ground_robot",
                                       "A ground robot cross-country",
                                       {Sensor::kImu, Sensor::kOdometer, Sensor::kGps}},
                                      {Vehicle::kUav,
                                       "uav",
                                       "A UAV that flies to a rack and stays over it",
                                       {Sensor::kImu, Sensor::kGps, Sensor::kVisualPose}},
                                      {Vehicle::kCrawler,
                                       "crawler",
                                       "A crawler in a pipe",
                                       {Sensor::kImu, Sensor::kOdometer, Sensor::kWeld}}};
  return all;
}

const char* name_of(Sensor sensor) {
  switch (sensor) {
    case Sensor::kImu:
      return "IMU";
    case Sensor::kOdometer:
      return "odometer";
    case Sensor::kGps:
      return "GPS";
    case Sensor::kVisualPose:
      return "visual pose";
    case Sensor::kWeld:
      return "welds";
  }
  return "";
}

double pooled(const std::vector<double>& root_mean_squares) {
  double sum = 0;
  for (const double value : root_mean_squares) {
    sum += value * value;
  }
  return std::sqrt(sum / static_cast<double>(root_mean_squares.size()));
}

}  // namespace pipescout::reproduce
