// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/pose_csv.hpp"

#include <cstddef>

namespace pipescout {

std::string pose_csv_header() {
  return "stamp,x,y,z,qx,qy,qz,qw,roll,pitch,yaw";
}

CsvLine pose_csv_line(Stamp stamp, const geometry::SE3& pose) {
  CsvLine line(stamp);
  line.add_each(pose.translation())
      .add_each(pose.rotation().quaternion().coeffs())
      .add_each(pose.rotation().roll_pitch_yaw());
  return line;
}

std::string uncertain_pose_csv_header() {
  std::string header = pose_csv_header();
  for (const char* axis : kPoseAxes) {
    header += std::string(",") + axis + "_standard_deviation";
  }
  for (std::size_t i = 0; i < kPoseAxes.size(); ++i) {
    for (std::size_t j = i + 1; j < kPoseAxes.size(); ++j) {
      header += std::string(",") + kPoseAxes.at(i) + "_" + kPoseAxes.at(j) + "_correlation";
    }
  }
  return header;
}

CsvLine uncertain_pose_csv_line(Stamp stamp, const geometry::SE3& pose,
                                const geometry::Matrix6d& covariance) {
  CsvLine line = pose_csv_line(stamp, pose);
  const geometry::Vector6d deviation = covariance.diagonal().cwiseSqrt();
  line.add_each_short(deviation);
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) {
      line.add_short(covariance(i, j) / (deviation[i] * deviation[j]));
    }
  }
  return line;
}

}  // namespace pipescout
