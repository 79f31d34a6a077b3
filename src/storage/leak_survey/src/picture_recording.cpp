// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/picture_recording.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "pipescout/leak_survey/survey_poses.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using leak_findings::FramePose;

constexpr std::size_t kDigits =
    8;  // of the number of a picture: more than a year at 2 Hz, 46 days at 25

/// The camera's place for that of the base. An error of the base's orientation moves the camera
/// about the base.
FramePose of_camera(const FramePose& base, const geometry::SE3& T_base_camera) {
  const Eigen::Vector3d lever = base.T_map_base.rotation() * T_base_camera.translation();
  geometry::Matrix6d derivative = geometry::Matrix6d::Identity();
  derivative.topRightCorner<3, 3>() = -geometry::skew(lever);
  FramePose camera;
  camera.T_map_base = base.T_map_base * T_base_camera;
  camera.covariance = derivative * base.covariance * derivative.transpose();
  return camera;
}

std::string file_name(std::size_t number) {
  const std::string digits = std::to_string(number);
  return std::string(kDigits - std::min(kDigits, digits.size()), '0') + digits + ".tiff";
}

}  // namespace

PictureRecording::PictureRecording(fs::path folder, const ThermalSettings& thermal,
                                   SurveySettings survey)
    : folder_(std::move(folder)),
      survey_(std::move(survey)),
      T_base_camera_(survey_.findings.T_base_camera) {
  survey_.findings.T_base_camera = geometry::SE3();
  survey_.camera.reset();
  fs::create_directories(folder_);
  if (!fs::is_empty(folder_)) {
    throw std::runtime_error(folder_.string() +
                             ": is not empty; a recording of images needs an empty folder");
  }
  try {
    replace_file(folder_ / kThermalFile, to_yaml(thermal), Survives::kKill);
    poses_.emplace(folder_ / kPosesFile);
    poses_->write(survey_pose_header());
  } catch (...) {
    discard();
    throw;
  }
}

PictureRecording::~PictureRecording() {
  if (pictures_ == 0) {
    discard();
  }
}

void PictureRecording::discard() noexcept {
  std::error_code ignored;
  for (const char* file : {kThermalFile, kSurveyFile, kPosesFile}) {
    fs::remove(folder_ / file, ignored);
  }
  fs::remove(folder_, ignored);
}

void PictureRecording::add(const ThermalView& picture, const leak_findings::Frame& frame,
                           const geometry::CameraParameters& camera) {
  if (!survey_.camera) {
    survey_.camera = camera;
    try {
      replace_file(folder_ / kSurveyFile, to_yaml(survey_), Survives::kKill);
    } catch (...) {
      survey_.camera.reset();
      throw;
    }
  }
  PicturePose pose{.time = frame.time, .pose = std::nullopt};
  if (frame.pose) {
    pose.pose = of_camera(*frame.pose, frame.T_base_camera.value_or(T_base_camera_));
  }
  const std::string name = file_name(pictures_ + 1);
  replace_file(folder_ / name, to_tiff(picture), Survives::kKill);
  try {
    poses_->write(survey_pose_line(name, pose));
  } catch (...) {
    std::error_code ignored;
    fs::remove(folder_ / name, ignored);
    throw;
  }
  ++pictures_;
}

}  // namespace pipescout
