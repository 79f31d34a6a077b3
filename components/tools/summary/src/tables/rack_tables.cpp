// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <iterator>
#include <optional>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/grey_image.hpp"
#include "pipescout/mission_tables/pose_csv.hpp"
#include "pipescout/mission_tables/thinning.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/validation/number_text.hpp"
#include "tables/camera_files.hpp"
#include "tables/makers.hpp"
#include "tables/rack_lines.hpp"
#include "tables/rack_report.hpp"

namespace pipescout::summary {

namespace {

namespace fs = std::filesystem;
using pipescout_msgs::msg::RackState;

/// Bytes; a rack file has a few kB.
constexpr std::uintmax_t kLargestRackFile = 1 << 20;

void require_finite(const char* field, double value) {
  if (!std::isfinite(value)) {
    throw std::invalid_argument(std::string(field) + " is " + validation::number_text(value) +
                                "; it must be finite");
  }
}

std::string image_name(std::size_t number) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "images/%06zu.pgm", number);
  return name.data();
}

class RackTables final : public TableMaker {
 public:
  RackTables(const Robot& robot, const TableOptions::Rack& options);

 protected:
  MissionSection section(const std::string& figure_prefix) const override;
  std::string counts() const override {
    return std::to_string(report_.poses()) + " poses and " + std::to_string(images_) +
           " images recorded";
  }
  bool has_data() const override { return report_.poses() > 0; }
  bool has_section() const override { return has_states_ || report_.poses() > 0; }
  std::string file_names() const override {
    return "pose.csv, state.csv, offsets.csv, truth.csv, command.csv, way_points.csv, images.csv, "
           "camera.yaml, rack.yaml";
  }
  void on_source(const pipescout_msgs::msg::MissionStatus& status) override;

 private:
  using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using TruePose = geometry_msgs::msg::PoseStamped;
  using State = RackState;
  using Command = geometry_msgs::msg::TwistStamped;
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;

  void on_pose(const Pose& message);
  void on_truth(const TruePose& message);
  void on_state(const State& message);
  void on_command(const Command& message);
  void on_image(const Image& message);
  void on_camera_info(const CameraInfo& message);
  /// Once it is known that there is a flight.
  void copy_rack_file();

  fs::path rack_;  // empty: none, or copied
  std::size_t most_images_;
  Thinning image_thinning_;
  RackReport report_;
  GreyImageReader reader_;
  bool has_states_ = false;
  std::size_t images_ = 0;
  std::string calibration_;  // as written
  std::optional<std::uint32_t> way_points_done_;
};

RackTables::RackTables(const Robot& robot, const TableOptions::Rack& options)
    : TableMaker(robot, "rack"),
      rack_(options.rack),
      most_images_(options.image_period > 0.0 ? options.maximum_images : 0),
      image_thinning_(from_seconds(options.image_period)) {
  record(topics::kRackPose, "poses", [this](const Pose& m) { on_pose(m); });
  record(topics::kTrueRackPose, "truth", [this](const TruePose& m) { on_truth(m); });
  record(topics::kRackState, "states", [this](const State& m) { on_state(m); });
  record(topics::kVelocityCommand, "commands", [this](const Command& m) { on_command(m); });
  record(topics::kCameraInfo, "calibrations", [this](const CameraInfo& m) { on_camera_info(m); });
  record(topics::kCameraImage, "images", [this](const Image& m) { on_image(m); });
}

void RackTables::copy_rack_file() {
  const fs::path source = std::exchange(rack_, {});
  if (source.empty()) {
    return;
  }
  std::ifstream stream(source, std::ios::binary);
  if (!stream || !fs::is_regular_file(source)) {
    throw std::system_error(ENOENT, std::generic_category(),
                            "summary.rack.rack: cannot read " + source.string());
  }
  if (fs::file_size(source) > kLargestRackFile) {
    throw std::runtime_error("summary.rack.rack: " + source.string() +
                             " is too large for a rack file");
  }
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  files().write_whole("rack.yaml", content);
}

void RackTables::on_pose(const Pose& message) {
  const geometry::SE3 T_rack_camera = from_message(message.pose.pose);
  const geometry::Matrix6d covariance = covariance_from_message(message.pose.covariance);
  const Time stamp = from_message(message.header.stamp);
  file("pose.csv", uncertain_pose_csv_header)
      .write(uncertain_pose_csv_line(stamp, T_rack_camera, covariance).text());
  report_.add_pose({.stamp = stamp,
                    .T_rack_camera = T_rack_camera,
                    .standard_deviation = covariance.diagonal().cwiseSqrt()});
}

void RackTables::on_truth(const TruePose& message) {
  const geometry::SE3 T_rack_camera = from_message(message.pose);
  const Time stamp = from_message(message.header.stamp);
  file("truth.csv", pose_csv_header).write(pose_csv_line(stamp, T_rack_camera).text());
  report_.add_truth(stamp, T_rack_camera);
}

void RackTables::on_state(const State& message) {
  has_states_ = true;
  copy_rack_file();
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
  report_.add_state(from_message(message.header.stamp),
                    message.status == RackState::STATUS_TRACKING, message.losses);
}

void RackTables::on_command(const Command& message) {
  for (const auto& vector : {message.twist.linear, message.twist.angular}) {
    require_finite("x", vector.x);
    require_finite("y", vector.y);
    require_finite("z", vector.z);
  }
  file("command.csv", command_csv_header).write(command_csv_line(message));
}

void RackTables::on_image(const Image& message) {
  const Time stamp = from_message(message.header.stamp);
  if (images_ == most_images_ || !image_thinning_.due(stamp)) {
    return;
  }
  const rack_vision::ImageView image = reader_.read(message);
  const std::string name = image_name(images_);
  files().write_whole(name, pgm_file(image));
  file("images.csv", image_csv_header).write(image_csv_line(stamp, name));
  image_thinning_.keep(stamp);
  ++images_;
}

void RackTables::on_camera_info(const CameraInfo& message) {
  const std::string calibration = camera_yaml(from_message(message));
  if (calibration_.empty()) {
    files().write_whole("camera.yaml", calibration);
    calibration_ = calibration;
  } else if (calibration != calibration_) {
    throw std::invalid_argument("another one than the first");
  }
}

void RackTables::on_source(const pipescout_msgs::msg::MissionStatus& status) {
  if (status.total == 0 || way_points_done_ == status.done) {
    return;
  }
  way_points_done_ = status.done;
  report_.set_way_points(status.done, status.total, status.message);
  file("way_points.csv", way_point_csv_header).write(way_point_csv_line(status));
}

MissionSection RackTables::section(const std::string& figure_prefix) const {
  MissionSection section = report_.section(figure_prefix);
  if (images_ > 0 && images_ == most_images_) {
    section.notes.push_back("No more than the first " + std::to_string(images_) +
                            " images were recorded.");
  }
  return section;
}

}  // namespace

std::unique_ptr<TableMaker> rack_tables(const Robot& robot, const TableOptions::Rack& options) {
  return std::make_unique<RackTables>(robot, options);
}

}  // namespace pipescout::summary
