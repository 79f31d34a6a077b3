// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {
namespace {

constexpr std::array kPose{"x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr std::array kDeviations{"x_deviation",          "y_deviation",
                                 "z_deviation",          "rotation_x_deviation",
                                 "rotation_y_deviation", "rotation_z_deviation"};

std::size_t needed(const CsvReader& reader, const char* name) {
  const auto column = reader.find_column(name);
  if (!column) {
    throw CsvError(reader.path(), reader.header_line(),
                   std::string("there is no column '") + name + "'");
  }
  return *column;
}

double number(const CsvReader& reader, std::size_t column) {
  const auto value = reader.number(column);
  if (!value || !std::isfinite(*value)) {
    reader.refuse(column, "a number");
  }
  return *value;
}

/// Nothing where all of its cells are empty.
std::optional<geometry::SE3> pose_of(const CsvReader& reader,
                                     const std::array<std::size_t, 7>& columns) {
  if (std::all_of(columns.begin(), columns.end(),
                  [&](std::size_t column) { return reader.cells()[column].empty(); })) {
    return std::nullopt;
  }
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = number(reader, columns[i]);
  }
  try {
    return geometry::SE3(geometry::SO3::from_quaternion(Eigen::Quaterniond(v[6], v[3], v[4], v[5])),
                         {v[0], v[1], v[2]});
  } catch (const std::invalid_argument&) {
    reader.refuse(columns[6], "part of a quaternion of norm 1");
  }
}

geometry::Matrix6d covariance_of(const CsvReader& reader, const SurveySettings& settings) {
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  for (std::size_t i = 0; i < kDeviations.size(); ++i) {
    double deviation = i < 3 ? settings.position_deviation : settings.orientation_deviation;
    if (const auto column = reader.find_column(kDeviations[i])) {
      deviation = number(reader, *column);
      if (!(deviation > 0)) {
        reader.refuse(*column, "above 0");
      }
    }
    const auto k = static_cast<Eigen::Index>(i);
    covariance(k, k) = deviation * deviation;
  }
  return covariance;
}

}  // namespace

SurveyPoses parse_survey_poses(const std::string& text, const std::string& path,
                               const SurveySettings& settings) {
  SurveyPoses poses;
  CsvReader reader(text, path, {.cut_end = true});
  poses.notes = reader.notes();
  const std::size_t file = needed(reader, "file");
  std::array<std::size_t, kPose.size()> pose{};
  for (std::size_t i = 0; i < kPose.size(); ++i) {
    pose[i] = needed(reader, kPose[i]);
  }
  const auto time = reader.find_column("time");
  if (time) {
    if (const std::string note = reader.numbers()->time_note(*time); !note.empty()) {
      poses.notes.push_back(note);
    }
  }
  while (reader.next()) {
    PicturePose entry;
    if (time) {
      entry.time = reader.numbers()->seconds(*time, reader.line(), reader.cells()[*time]);
      if (!entry.time || !std::isfinite(*entry.time)) {
        reader.refuse(*time, "a time in seconds or one such as 2026-11-29T07:36:05.25Z");
      }
    }
    if (const auto T_map_base = pose_of(reader, pose)) {
      entry.pose = {.T_map_base = *T_map_base, .covariance = covariance_of(reader, settings)};
    }
    if (!poses.by_file.emplace(std::string(reader.cells()[file]), entry).second) {
      reader.refuse(file, "named once");
    }
  }
  return poses;
}

std::string survey_pose_header() {
  std::string header = "time";
  for (const char* column : kPose) {
    header += std::string(",") + column;
  }
  for (const char* column : kDeviations) {
    header += std::string(",") + column;
  }
  return header + ",file";
}

std::string survey_pose_line(const std::string& file, const PicturePose& picture) {
  std::string line = picture.time ? format_csv_number(*picture.time) : "";
  const auto add = [&line](double value) { line += "," + format_csv_number(value); };
  if (picture.pose) {
    const geometry::SE3& T = picture.pose->T_map_base;
    const Eigen::Quaterniond q = T.rotation().quaternion();
    for (const double value : {T.translation().x(), T.translation().y(), T.translation().z(), q.x(),
                               q.y(), q.z(), q.w()}) {
      add(value);
    }
    for (Eigen::Index k = 0; k < 6; ++k) {
      add(std::sqrt(picture.pose->covariance(k, k)));
    }
  } else {
    line.append(kPose.size() + kDeviations.size(), ',');
  }
  return line + "," + file;
}

}  // namespace pipescout
