// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_recorder/rack_recorder.hpp"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/mission_tables/pose_csv.hpp"
#include "pipescout/rack_recorder/camera_files.hpp"
#include "pipescout/rack_recorder/csv_lines.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

namespace fs = std::filesystem;
using pipescout_msgs::msg::RackState;

/// Bytes; a rack file has a few kB.
constexpr std::uintmax_t kLargestRackFile = 1 << 20;

void require_finite(const char* field, double value) {
  if (!std::isfinite(value)) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                "; it must be finite");
  }
}

std::string image_name(std::uint64_t number) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "images/%06llu.pgm",
                static_cast<unsigned long long>(number));
  return name.data();
}

}  // namespace

RackRecorder::RackRecorder(ComponentOptions options) : StreamRecorder(std::move(options), "rack") {
  image_period_ =
      parameters().declare<double>("image_period", 1.0,
                                   {.description = "s between recorded images; 0: none",
                                    .floating_point_range = FloatingPointRange{0.0, 3600.0}});
  maximum_images_ =
      parameters().declare<std::int64_t>("maximum_images", 600,
                                         {.description = "largest number of recorded images",
                                          .integer_range = IntegerRange{1, 1000000}});
  rack_ = parameters().declare<std::string>(
      "rack", "",
      {.description = "YAML file with the pipes, copied to the recording; empty: none"});
}

RackRecorder::~RackRecorder() = default;

CallbackReturn RackRecorder::on_configure() {
  const Duration period = from_seconds(image_period_.get());
  most_images_ = static_cast<std::uint64_t>(maximum_images_.get());
  report_.emplace();
  image_thinning_ = Thinning(period);
  images_ = 0;
  calibration_.clear();
  way_points_done_.reset();
  begin_recording();
  copy_rack_file();
  record(topics::kRackPose, "pose", [this](const Pose& message) { on_pose(message); });
  record(topics::kTrueRackPose, "truth", [this](const TruePose& message) { on_truth(message); });
  record(topics::kRackState, "state", [this](const State& message) { on_state(message); });
  record(topics::kVelocityCommand, "command",
         [this](const Command& message) { on_command(message); });
  record(topics::kCameraInfo, "camera_info",
         [this](const CameraInfo& message) { on_camera_info(message); });
  if (period > Duration::zero()) {
    record(topics::kCameraImage, "image", [this](const Image& message) { on_image(message); });
  }
  return CallbackReturn::kSuccess;
}

void RackRecorder::copy_rack_file() {
  const fs::path source = rack_.get();
  if (source.empty()) {
    return;
  }
  std::ifstream stream(source, std::ios::binary);
  if (!stream || !fs::is_regular_file(source)) {
    throw std::system_error(ENOENT, std::generic_category(),
                            "parameter 'rack': cannot read " + source.string());
  }
  if (fs::file_size(source) > kLargestRackFile) {
    throw std::invalid_argument("parameter 'rack': " + source.string() +
                                " is too large for a rack file");
  }
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  replace_file(data_folder() / "rack.yaml", content, Survives::kKill);
}

void RackRecorder::on_pose(const Pose& message) {
  const geometry::SE3 T_rack_camera = from_message(message.pose.pose);
  const geometry::Matrix6d covariance = covariance_from_message(message.pose.covariance);
  const Time stamp = from_message(message.header.stamp);
  file("pose.csv", uncertain_pose_csv_header)
      .write(uncertain_pose_csv_line(stamp, T_rack_camera, covariance).text());
  report_->add_pose({.stamp = stamp,
                     .T_rack_camera = T_rack_camera,
                     .standard_deviation = covariance.diagonal().cwiseSqrt()});
}

void RackRecorder::on_truth(const TruePose& message) {
  const geometry::SE3 T_rack_camera = from_message(message.pose);
  const Time stamp = from_message(message.header.stamp);
  file("truth.csv", pose_csv_header).write(pose_csv_line(stamp, T_rack_camera).text());
  report_->add_truth(stamp, T_rack_camera);
}

void RackRecorder::on_state(const State& message) {
  const std::size_t pipes = message.pipe.size();
  if (pipes > rack_vision::kMaxPipes || message.offset.size() != pipes ||
      message.offset_variance.size() != pipes || message.offset_observed.size() != pipes) {
    throw std::invalid_argument("its lists have different lengths, or more pipes than " +
                                std::to_string(rack_vision::kMaxPipes));
  }
  file("state.csv", state_csv_header).write(state_csv_line(message));
  for (std::size_t pipe = 0; pipe < pipes; ++pipe) {
    file("offsets.csv", offset_csv_header).write(offset_csv_line(message, pipe));
  }
  report_->add_state(from_message(message.header.stamp),
                     message.status == RackState::STATUS_TRACKING, message.losses);
}

void RackRecorder::on_command(const Command& message) {
  for (const auto& vector : {message.twist.linear, message.twist.angular}) {
    require_finite("x", vector.x);
    require_finite("y", vector.y);
    require_finite("z", vector.z);
  }
  file("command.csv", command_csv_header).write(command_csv_line(message));
}

void RackRecorder::on_image(const Image& message) {
  const Time stamp = from_message(message.header.stamp);
  if (!image_thinning_.due(stamp) || images_ == most_images_) {
    return;
  }
  const rack_vision::ImageView image = reader_.read(message);
  if (images_ == 0) {
    fs::create_directory(data_folder() / "images");
  }
  const std::string name = image_name(images_);
  replace_file(data_folder() / name, pgm_file(image), Survives::kKill);
  file("images.csv", image_csv_header).write(image_csv_line(stamp, name));
  image_thinning_.keep(stamp);
  ++images_;
}

void RackRecorder::on_camera_info(const CameraInfo& message) {
  const std::string calibration = camera_yaml(from_message(message));
  if (calibration_.empty()) {
    replace_file(data_folder() / "camera.yaml", calibration, Survives::kKill);
    calibration_ = calibration;
  } else if (calibration != calibration_) {
    report_fault("camera_info.changed", "a calibration other than the first is not recorded");
  }
}

bool RackRecorder::has_data() const {
  return report_->poses() > 0;
}

void RackRecorder::on_progress(const pipescout_msgs::msg::MissionStatus& status) {
  if (status.total == 0 || way_points_done_ == status.done) {
    return;
  }
  way_points_done_ = status.done;
  report_->set_way_points(status.done, status.total, status.message);
  file("way_points.csv", way_point_csv_header).write(way_point_csv_line(status));
}

std::string RackRecorder::counts() const {
  return std::to_string(report_->poses()) + " poses and " + std::to_string(images_) +
         " images recorded";
}

MissionSection RackRecorder::section(const std::string& figure_prefix) const {
  MissionSection section = report_->section(figure_prefix);
  if (images_ == most_images_) {
    section.notes.push_back("No more than the first " + std::to_string(images_) +
                            " images were recorded.");
  }
  section.notes.push_back("Data: " + data_folder_name() +
                          "/pose.csv, state.csv, offsets.csv, truth.csv, command.csv, "
                          "way_points.csv, images.csv, camera.yaml, rack.yaml.");
  return section;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::RackRecorder)
