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

#include "pipescout/interfaces/conversions.hpp"
#include "pipescout/interfaces/register_component.hpp"
#include "pipescout/interfaces/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/rack_recorder/camera_files.hpp"
#include "pipescout/rack_recorder/csv_lines.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout {

namespace {

namespace fs = std::filesystem;
namespace state_constants = pipescout_msgs::msg::RackState_Constants;

/// Frames do not come by the clock of the recorder: one that is this early counts as due.
constexpr Duration kEarly = std::chrono::milliseconds(5);
/// Bytes; a rack file has a few kB.
constexpr std::uintmax_t kLargestRackFile = 1 << 20;
/// It is noticed by a quarter of itself late.
constexpr int kLooksPerSilence = 4;

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

RackRecorder::RackRecorder(ComponentOptions options) : MissionRecorder(std::move(options), "rack") {
  settle_time_ = parameters().declare<double>(
      "settle_time", 0.5,
      {.description = "s after the end of the source in which messages that are under way arrive",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  silent_after_ = parameters().declare<double>(
      "silent_after", 30.0,
      {.description = "s without any message; with a source that is not complete, the recording "
                      "then fails; 0: waits for ever",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  image_period_ =
      parameters().declare<double>("image_period", 1.0,
                                   {.description = "s between the images that are kept; 0: none",
                                    .floating_point_range = FloatingPointRange{0.0, 3600.0}});
  maximum_images_ =
      parameters().declare<std::int64_t>("maximum_images", 600,
                                         {.description = "images that are kept of one flight",
                                          .integer_range = IntegerRange{1, 1000000}});
  rack_ = parameters().declare<std::string>(
      "rack", "", {.description = "YAML file with the pipes, kept with the flight; empty: none"});
}

RackRecorder::~RackRecorder() {
  close();
}

CallbackReturn RackRecorder::on_configure() {
  settle_ = from_seconds(settle_time_.get());
  silence_ = from_seconds(silent_after_.get());
  period_ = from_seconds(image_period_.get());
  most_images_ = static_cast<std::uint64_t>(maximum_images_.get());
  report_.emplace();
  last_image_.reset();
  images_ = 0;
  calibration_.clear();
  way_points_done_.reset();
  heard_at_.reset();
  open_recording();
  copy_rack_file();
  pose_subscription_ = record(topics::kRackPose, "pose", &RackRecorder::on_pose);
  truth_subscription_ = record(topics::kTrueRackPose, "truth", &RackRecorder::on_truth);
  state_subscription_ = record(topics::kRackState, "state", &RackRecorder::on_state);
  command_subscription_ = record(topics::kVelocityCommand, "command", &RackRecorder::on_command);
  camera_info_subscription_ =
      record(topics::kCameraInfo, "camera_info", &RackRecorder::on_camera_info);
  if (period_ > Duration::zero()) {
    // Best effort: a picture for people must never hold up the camera.
    image_subscription_ = record(Topic<Image>{topics::kCameraImage.name, QoS::sensor_data()},
                                 "image", &RackRecorder::on_image);
  }
  if (silence_ > Duration::zero()) {
    silence_timer_ = create_timer(silence_ / kLooksPerSilence, [this] { look_for_silence(); });
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn RackRecorder::on_deactivate() {
  // It does not hear what comes meanwhile.
  heard_at_.reset();
  return MissionRecorder::on_deactivate();
}

template <class T>
Subscription<T> RackRecorder::record(const Topic<T>& topic, const char* counter,
                                     void (RackRecorder::*write)(const T&)) {
  return create_subscription(topic, [this, counter, write](const T& message) {
    heard_at_ = steady_now();
    section_has_changed();
    guarded([&] {
      try {
        (this->*write)(message);
      } catch (const std::invalid_argument& error) {
        report_fault(std::string(counter) + ".malformed",
                     std::string(counter) + " is not recorded: " + error.what());
      }
    });
  });
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
  const geometry::SE3 T_rack_camera = from_message(message.pose().pose());
  const geometry::Matrix6d covariance = covariance_from_message(message.pose().covariance());
  const Time stamp = from_message(message.header().stamp());
  file(pose_file_, "pose.csv", pose_csv_header())
      .write(pose_csv_line(stamp, T_rack_camera, covariance));
  report_->add_pose({.stamp = stamp,
                     .T_rack_camera = T_rack_camera,
                     .standard_deviation = covariance.diagonal().cwiseSqrt()});
}

void RackRecorder::on_truth(const TruePose& message) {
  const geometry::SE3 T_rack_camera = from_message(message.pose());
  const Time stamp = from_message(message.header().stamp());
  file(truth_file_, "truth.csv", truth_csv_header()).write(truth_csv_line(stamp, T_rack_camera));
  report_->add_truth(stamp, T_rack_camera);
}

void RackRecorder::on_state(const State& message) {
  const std::size_t pipes = message.pipe().size();
  if (pipes > rack_vision::kMaxPipes || message.offset().size() != pipes ||
      message.offset_variance().size() != pipes || message.offset_observed().size() != pipes) {
    throw std::invalid_argument("its lists are not of one length, or of more pipes than " +
                                std::to_string(rack_vision::kMaxPipes));
  }
  file(state_file_, "state.csv", state_csv_header()).write(state_csv_line(message));
  for (std::size_t pipe = 0; pipe < pipes; ++pipe) {
    file(offsets_file_, "offsets.csv", offset_csv_header()).write(offset_csv_line(message, pipe));
  }
  report_->add_state(from_message(message.header().stamp()),
                     message.status() == state_constants::STATUS_TRACKING, message.losses());
}

void RackRecorder::on_command(const Command& message) {
  for (const auto& vector : {message.twist().linear(), message.twist().angular()}) {
    require_finite("x", vector.x());
    require_finite("y", vector.y());
    require_finite("z", vector.z());
  }
  file(command_file_, "command.csv", command_csv_header()).write(command_csv_line(message));
}

void RackRecorder::on_image(const Image& message) {
  const Time stamp = from_message(message.header().stamp());
  // A stamp from before: the clock began again.
  const bool due = !last_image_ || stamp >= *last_image_ + period_ - kEarly || stamp < *last_image_;
  if (!due || images_ == most_images_) {
    return;
  }
  const rack_vision::ImageView image = reader_.read(message);
  if (images_ == 0) {
    fs::create_directory(data_folder() / "images");
  }
  const std::string name = image_name(images_);
  replace_file(data_folder() / name, pgm_file(image), Survives::kKill);
  file(images_file_, "images.csv", image_csv_header()).write(image_csv_line(stamp, name));
  last_image_ = stamp;
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

void RackRecorder::on_source(const pipescout_msgs::msg::MissionStatus& status) {
  namespace constants = pipescout_msgs::msg::MissionStatus_Constants;
  heard_at_ = steady_now();
  section_has_changed();
  guarded([&] { on_progress(status); });
  if (status.state() == constants::COMPLETE && !settle_timer_) {
    settle_timer_ = create_timer(settle_, [this] {
      end(report_->poses() > 0 ? Outcome::kComplete : Outcome::kFailed, counts());
    });
  } else if (status.state() == constants::RUNNING && status.total() != 0) {
    report_progress(status.done(), status.total());
  }
}

void RackRecorder::on_progress(const pipescout_msgs::msg::MissionStatus& status) {
  if (status.total() == 0 || way_points_done_ == status.done()) {
    return;
  }
  way_points_done_ = status.done();
  report_->set_way_points(status.done(), status.total(), status.message());
  file(way_points_file_, "way_points.csv", way_point_csv_header())
      .write(way_point_csv_line(status));
}

void RackRecorder::look_for_silence() {
  if (!heard_at_ || settle_timer_ || steady_now() - *heard_at_ < silence_) {
    return;
  }
  heard_at_.reset();
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "nothing has arrived for %g s", to_seconds(silence_));
  const auto source = parameters().get("source").get<std::string>();
  if (source.empty()) {
    report_fault("silent", text.data());
  } else {
    end(Outcome::kFailed, std::string(text.data()) + ", and '" + source +
                              "' has not said that it is complete: " + counts());
  }
}

LineFile& RackRecorder::file(std::unique_ptr<LineFile>& file, const char* name,
                             const std::string& header) {
  if (!file) {
    file = std::make_unique<LineFile>(data_folder() / name);
    file->write(header);
  }
  return *file;
}

std::string RackRecorder::counts() const {
  return std::to_string(report_->poses()) + " poses and " + std::to_string(images_) +
         " images recorded";
}

MissionSection RackRecorder::section(const std::string& figure_prefix) const {
  MissionSection section = report_->section(figure_prefix);
  if (images_ == most_images_) {
    section.notes.push_back("No more than the first " + std::to_string(images_) +
                            " images were kept.");
  }
  section.notes.push_back("Data: " + data_folder_name() +
                          "/pose.csv, state.csv, offsets.csv, truth.csv, command.csv, "
                          "way_points.csv, images.csv, camera.yaml, rack.yaml.");
  return section;
}

void RackRecorder::stop_timers() {
  settle_timer_.reset();
  silence_timer_.reset();
}

void RackRecorder::sync_files() {
  for (const auto* lines : {&pose_file_, &truth_file_, &state_file_, &offsets_file_, &command_file_,
                            &way_points_file_, &images_file_}) {
    if (*lines) {
      (*lines)->sync();
    }
  }
}

void RackRecorder::close_files() {
  pose_subscription_ = {};
  truth_subscription_ = {};
  state_subscription_ = {};
  command_subscription_ = {};
  image_subscription_ = {};
  camera_info_subscription_ = {};
  for (auto* lines : {&pose_file_, &truth_file_, &state_file_, &offsets_file_, &command_file_,
                      &way_points_file_, &images_file_}) {
    lines->reset();
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::RackRecorder)
