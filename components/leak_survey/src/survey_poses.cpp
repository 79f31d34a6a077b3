// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_poses.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

#include "pipescout/odometer_replay/csv_table.hpp"

namespace pipescout {
namespace {

constexpr std::array kPose{"x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr std::array kDeviations{"x_deviation",          "y_deviation",
                                 "z_deviation",          "rotation_x_deviation",
                                 "rotation_y_deviation", "rotation_z_deviation"};

std::size_t needed(const CsvReader& reader, const char* name) {
  const auto column = reader.find_column(name);
  if (!column) {
    throw CsvError(reader.path(), 1, std::string("there is no column '") + name + "'");
  }
  return *column;
}

double number(const CsvReader& reader, std::size_t column) {
  const auto value = parse_csv_number(reader.cells()[column]);
  if (!value || !std::isfinite(*value)) {
    reader.refuse(column, "a number");
  }
  return *value;
}

geometry::SE3 pose_of(const CsvReader& reader, const std::array<std::size_t, 7>& columns) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = number(reader, columns[i]);
  }
  try {
    return {geometry::SO3::from_quaternion(Eigen::Quaterniond(v[6], v[3], v[4], v[5])),
            {v[0], v[1], v[2]}};
  } catch (const std::invalid_argument&) {
    reader.refuse(columns[6], "part of a quaternion of norm 1");
  }
}

}  // namespace

std::map<std::string, PicturePose> parse_survey_poses(const std::string& text,
                                                      const std::string& path,
                                                      const SurveySettings& settings) {
  CsvReader reader(text, path);
  const std::size_t file = needed(reader, "file");
  std::array<std::size_t, kPose.size()> pose{};
  for (std::size_t i = 0; i < kPose.size(); ++i) {
    pose[i] = needed(reader, kPose[i]);
  }
  const auto time = reader.find_column("time");
  std::map<std::string, PicturePose> poses;
  while (reader.next()) {
    PicturePose entry;
    if (time) {
      entry.time = number(reader, *time);
    }
    entry.pose.T_map_base = pose_of(reader, pose);
    for (std::size_t i = 0; i < kDeviations.size(); ++i) {
      double deviation = i < 3 ? settings.position_deviation : settings.orientation_deviation;
      if (const auto column = reader.find_column(kDeviations[i])) {
        deviation = number(reader, *column);
        if (!(deviation > 0)) {
          reader.refuse(*column, "above 0");
        }
      }
      const auto k = static_cast<Eigen::Index>(i);
      entry.pose.covariance(k, k) = deviation * deviation;
    }
    if (!poses.emplace(reader.cells()[file], entry).second) {
      reader.refuse(file, "named once");
    }
  }
  return poses;
}

}  // namespace pipescout
