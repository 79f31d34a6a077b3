// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/leak_inspector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>

#include "leak_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/leak_findings/rack_lines.hpp"
#include "pipescout/leak_inspector/rack_offsets.hpp"
#include "pipescout/leak_store/findings_archive.hpp"
#include "pipescout/leak_store/leak_exports.hpp"
#include "pipescout/leak_survey/picture_recording.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using leak_findings::EventKind;
using leak_findings::Finding;
using leak_findings::FramePose;
using leak_findings::FrameResult;
using leak_findings::InputFault;
using thermal::Detections;
using thermal::FrameFault;

constexpr std::size_t kOdometryHistory = 2000;
/// s over which odometry is interpolated, and moved on beyond its last message.
constexpr double kOdometryReach = 0.2;
/// m, between places of the robot that the report shows.
constexpr double kTrackStep = 1.0;

/// degC of a picture; `buffer` is used where it is none of degC itself.
thermal::TemperatureView temperatures(const ThermalImageReader::View& picture,
                                      std::span<const float> celsius, std::vector<float>& buffer) {
  return std::visit(
      [&](const auto& image) -> thermal::TemperatureView {
        if constexpr (std::is_same_v<std::decay_t<decltype(image)>, thermal::TemperatureView>) {
          return image;
        } else {
          buffer.clear();
          for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) {
              const std::size_t value = image(x, y);
              buffer.push_back(value < celsius.size() ? celsius[value]
                                                      : std::numeric_limits<float>::quiet_NaN());
            }
          }
          return {buffer.data(), image.width, image.height, image.width};
        }
      },
      picture);
}

}  // namespace

LeakInspector::LeakInspector(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters()) {}

LeakInspector::~LeakInspector() = default;

CallbackReturn LeakInspector::on_configure() {
  settings_ = declared_.read(*this);
  detector_.emplace(settings_->detection.detector);
  posterior_ = settings_->posterior;
  levels_ = false;
  odometry_.emplace(kOdometryHistory, kOdometryReach);
  camera_.reset();
  calibration_.reset();
  findings_.reset();
  archive_ = std::make_unique<FindingsArchive>(settings_->store, settings_->report_folder);
  recording_.reset();
  if (!settings_->pictures_folder.empty()) {
    recording_ = std::make_unique<PictureRecording>(
        settings_->pictures_folder, settings_->thermal_settings, settings_->survey_settings);
  }
  track_.clear();
  ConditionRecord conditions = settings_->conditions;
  conditions.time = to_seconds(now().time_since_epoch());
  archive_->log(conditions);
  frame_ = 0;
  with_pipe_ = 0;
  failed_ = 0;

  detections_publisher_ =
      create_publisher(topics::kLeakDetections, {.events = {.matched = awaited_.on_matched()}});
  event_publisher_ =
      create_publisher(topics::kLeakEvents, {.events = {.matched = awaited_.on_matched()}});
  odometry_subscription_ = create_subscription(
      topics::kOdometryFiltered, [this](const Odometry& message) { on_odometry(message); });
  if (settings_->rack) {
    rack_subscription_ = create_subscription(
        topics::kRackState, [this](const RackState& message) { on_rack_state(message); });
  }
  image_silence_.start("image", settings_->silent_after);
  counts_timer_ = create_timer(std::chrono::seconds(1), [this] { tell_counts(); });
  awaited_.watch({detections_publisher_.untyped(), event_publisher_.untyped()},
                 [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

void LeakInspector::subscribe() {
  camera_info_subscription_ = create_subscription(
      topics::kThermalCameraInfo, [this](const CameraInfo& message) { on_camera_info(message); });
  image_subscription_ = create_subscription(topics::kThermalImage,
                                            [this](const Image& message) { on_image(message); });
}

CallbackReturn LeakInspector::on_deactivate() {
  if (findings_) {
    try_to_keep([this] {
      for (const Finding& finding : findings_->findings()) {
        archive_->save(finding);
      }
      LeakReport report;
      report.title = "Leaks";
      report.made =
          iso_time(to_seconds(now().time_since_epoch())) + ", by " + node_name().fully_qualified();
      report.pipes = settings_->findings.lines;
      report.track = track_;
      report.datum = settings_->datum;
      report.degrees = degrees_text(posterior_ ? &*posterior_ : nullptr, levels_);
      report.pictures_read = frame_;
      report.pictures_failed = failed_;
      archive_->write_report(findings_->findings(), std::move(report));
    });
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn LeakInspector::on_cleanup() {
  awaited_.stop();
  image_silence_.stop();
  counts_timer_.reset();
  image_subscription_ = {};
  camera_info_subscription_ = {};
  odometry_subscription_ = {};
  rack_subscription_ = {};
  detections_publisher_ = {};
  event_publisher_ = {};
  findings_.reset();
  archive_.reset();
  recording_.reset();
  detector_.reset();
  posterior_.reset();
  odometry_.reset();
  return CallbackReturn::kSuccess;
}

void LeakInspector::on_camera_info(const CameraInfo& message) {
  if (calibration_ && same_calibration(*calibration_, message)) {
    return;
  }
  try {
    camera_.emplace(from_message(message));
  } catch (const std::invalid_argument& error) {
    report_fault("camera_info.refused", std::string("calibration refused: ") + error.what());
    return;
  }
  leak_findings::LeakFindings anew(settings_->findings, *camera_);
  if (findings_) {
    report_fault("camera_info.changed",
                 "the calibration has changed: candidates are discarded" +
                     std::string(recording_ ? ", and no more images are recorded" : ""));
    recording_.reset();  // is of one camera
    anew.restore(findings_->findings());
  } else {
    try_to_keep([&] {
      const std::vector<Finding> known = archive_->known();
      if (const std::size_t taken = anew.restore(known); taken > 0) {
        logger().info(std::to_string(taken) + " findings were loaded");
      }
    });
  }
  findings_.emplace(std::move(anew));
  calibration_ = message;
}

void LeakInspector::on_odometry(const Odometry& message) {
  const auto entry = take_odometry(
      *odometry_, message,
      {settings_->stamp_limits, settings_->map_frame, /*needs_covariance=*/true}, now(),
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
  if (!entry) {
    return;
  }
  const Eigen::Vector2d place = entry->T_odom_base.translation().head<2>();
  if (track_.empty() || (place - track_.back()).norm() >= kTrackStep) {
    track_.push_back(place);
  }
}

void LeakInspector::on_rack_state(const RackState& message) {
  if (message.status != RackState::STATUS_TRACKING) {
    return;
  }
  const std::vector<leak_findings::PipeLine> moved =
      leak_findings::rack_lines(*settings_->rack, rack_offsets(*settings_->rack, message));
  std::ranges::copy(moved, settings_->findings.lines.begin());
  if (findings_) {
    findings_->set_lines(settings_->findings.lines);
  }
}

std::optional<FramePose> LeakInspector::pose_at(Time stamp) const {
  const auto T_map_base = odometry_->at(stamp);
  const auto covariance = odometry_->covariance_at(stamp);
  if (!T_map_base || !covariance) {
    return std::nullopt;
  }
  return FramePose{.T_map_base = *T_map_base, .covariance = *covariance};
}

void LeakInspector::on_image(const Image& message) {
  image_silence_.heard();
  const Time stamp = from_message(message.header.stamp);
  if (const auto fault = settings_->stamp_limits.find_fault("image", stamp, now())) {
    report_fault(fault->counter, fault->text);
    return;
  }
  ThermalImageReader::View picture;
  try {
    picture = reader_.read(message);
  } catch (const std::invalid_argument& error) {
    report_fault("image.refused", std::string("picture refused: ") + error.what());
    return;
  }
  std::span<const float> celsius;
  try {
    celsius = settings_->detection.celsius_of(picture);
  } catch (const UndescribedPicture& error) {
    report_fault(error.counter(), error.what());
    return;
  }
  ++frame_;
  std::string missing;
  const std::optional<geometry::SE3> T_base_camera =
      settings_->mount.T_base_camera(stamp, &missing);
  if (!T_base_camera) {
    report_fault("tf.missing",
                 "where the camera was on the robot is not known of a picture: " + missing);
  }
  const leak_findings::Frame frame{.time = to_seconds(stamp.time_since_epoch()),
                                   .number = frame_,
                                   .pose = T_base_camera ? pose_at(stamp) : std::nullopt,
                                   .T_base_camera = T_base_camera};
  thermal::FrameConditions circumstances =
      findings_ ? findings_->conditions(frame) : thermal::FrameConditions{};
  if (std::holds_alternative<thermal::CountView>(picture)) {
    circumstances.errors = settings_->errors;
    circumstances.posterior = posterior_ ? &*posterior_ : nullptr;
  } else if (std::holds_alternative<thermal::GreyView>(picture)) {
    circumstances.levels = settings_->detection.levels;
    levels_ = levels_ || circumstances.levels;
  }
  const Detections& detections = detect(*detector_, picture, celsius, circumstances);
  if (const thermal::PipeSection* pipe = detections.main_pipe();
      circumstances.posterior != nullptr && pipe != nullptr) {
    posterior_->observe(pipe->reference_temperature);
  }
  if (detections.fault != FrameFault::kNone) {
    ++failed_;
    report_fault("image." + std::string(to_string(detections.fault)),
                 "detection failed in an image of " + std::to_string(message.width) + " x " +
                     std::to_string(message.height) + ": " +
                     std::string(to_string(detections.fault)));
  }
  with_pipe_ += detections.pipes.empty() ? 0 : 1;

  std::span<const std::uint64_t> finding_of;
  if (!findings_) {
    report_fault("camera_info.missing",
                 "images without a calibration on thermal/camera_info: leaks have no position");
  } else {
    const FrameResult& result = findings_->update(frame, detections);
    // A picture without detections is told above; before the first odometry there is no pose.
    const bool has_begun =
        result.fault != InputFault::kNoPose || odometry_subscription_.statistics().received > 0;
    if (result.fault != InputFault::kNone && result.fault != InputFault::kNoDetections &&
        has_begun) {
      report_fault(
          "findings." + std::string(to_string(result.fault)),
          "the findings cannot use all of an image: " + std::string(to_string(result.fault)));
    }
    if (result.fault != InputFault::kBadTime) {
      record(picture, frame);
    }
    finding_of = result.finding_of;
    keep_evidence(result, frame, picture, celsius, detections);
    for (const leak_findings::Event& event : result.events) {
      publish(event, message);
    }
  }
  auto told = std::make_unique<pipescout_msgs::msg::LeakDetections>(
      detections_message(detections, finding_of));
  told->header = message.header;
  detections_publisher_.publish(std::move(told));
}

void LeakInspector::record(const ThermalImageReader::View& picture,
                           const leak_findings::Frame& frame) {
  if (!recording_) {
    return;
  }
  try {
    recording_->add(picture, frame, camera_->parameters());
  } catch (const std::system_error& error) {
    report_fault("pictures.failed", std::string("an image was not recorded: ") + error.what());
  }
}

void LeakInspector::keep_evidence(const FrameResult& result, const leak_findings::Frame& frame,
                                  const ThermalImageReader::View& picture,
                                  std::span<const float> celsius, const Detections& detections) {
  for (std::size_t leak = 0; leak < result.finding_of.size(); ++leak) {
    const Finding* const finding = findings_->find(result.finding_of[leak]);
    if (finding == nullptr || !archive_->wants(*finding, frame.time)) {
      continue;
    }
    const thermal::TemperatureView degrees = temperatures(picture, celsius, temperatures_);
    archive_->keep(finding->id, make_evidence(degrees, detections, leak,
                                              settings_->detection.detector.profile, frame.time,
                                              std::string(topics::kThermalImage.name) + " " +
                                                  std::to_string(frame.number)));
  }
}

void LeakInspector::publish(const leak_findings::Event& event, const Image& picture) {
  const Finding* const finding = findings_->find(event.finding);
  if (finding == nullptr) {
    return;
  }
  try_to_keep([&] { archive_->save(*finding); });
  auto told = std::make_unique<pipescout_msgs::msg::LeakEvent>();
  told->header.stamp = picture.header.stamp;
  told->header.frame_id = settings_->map_frame;
  told->kind = event_kind(event.kind);
  told->finding = finding_message(*finding);
  if (const Evidence* const evidence = archive_->evidence(event.finding)) {
    told->finding.thumbnail.header = picture.header;
    told->finding.thumbnail.format = "png";
    told->finding.thumbnail.data = evidence->thumbnail.png;
  }
  event_publisher_.publish(std::move(told));
  if (event.kind == EventKind::kRaised) {
    logger().warn("leak " + std::to_string(finding->id) +
                  " raised: " + std::string(to_string(finding->severity)) + ", " +
                  std::to_string(std::lround(finding->mean_delta)) + " K above the pipe");
  } else if (event.kind == EventKind::kCleared) {
    logger().info("leak " + std::to_string(finding->id) + " cleared");
  }
}

void LeakInspector::try_to_keep(const std::function<void()>& action) {
  try {
    action();
  } catch (const LeakStoreError& error) {
    report_fault("store.failed", error.what());
  } catch (const std::system_error& error) {
    report_fault("report.failed", error.what());
  }
}

void LeakInspector::tell_counts() {
  const auto tell = [this](const char* key, std::uint64_t value) {
    diagnostics().set_value(key, std::to_string(value));
  };
  tell("pictures", frame_);
  tell("pictures.with_pipe", with_pipe_);
  if (recording_) {
    tell("pictures.kept", recording_->pictures());
  }
  if (!findings_) {
    return;
  }
  const auto raised = [](const Finding& finding) {
    return finding.state == leak_findings::FindingState::kRaised;
  };
  tell("findings", findings_->findings().size());
  tell("findings.raised",
       static_cast<std::uint64_t>(std::ranges::count_if(findings_->findings(), raised)));
  tell("findings.refused", findings_->counters().findings_refused);
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::LeakInspector)
