// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_tracker/thermal_tracker.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "body_tracker.hpp"
#include "expected_section.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/tracked_section.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"
#include "track_messages.hpp"

namespace pipescout {

namespace {

using thermal::Detections;
using thermal::FrameFault;
using tracking::PipeShape;
using tracking::TrackFault;
using tracking::TrackState;

constexpr std::size_t kOdometryHistory = 2000;
/// s over which odometry is interpolated, and moved on beyond its last message.
constexpr double kOdometryReach = 0.2;
/// s between two pictures: over longer times the mean velocity of the camera says little.
constexpr double kLongestInterval = 0.5;

/// degC of each pixel, row by row. `celsius`: of each value; of temperatures it is not used.
void take_degrees(const ThermalImageReader::View& picture, std::span<const float> celsius,
                  std::vector<float>& degrees) {
  degrees.clear();
  std::visit(
      [&](const auto& image) {
        for (int y = 0; y < image.height; ++y) {
          for (int x = 0; x < image.width; ++x) {
            if constexpr (std::is_same_v<std::decay_t<decltype(image)>, thermal::TemperatureView>) {
              degrees.push_back(image(x, y));
            } else {
              degrees.push_back(celsius[image(x, y)]);
            }
          }
        }
      },
      picture);
}

}  // namespace

ThermalTracker::ThermalTracker(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters()) {}

ThermalTracker::~ThermalTracker() = default;

CallbackReturn ThermalTracker::on_configure() {
  settings_ = declared_.read(*this);
  detector_.emplace(settings_->detection.detector);
  tracker_.emplace(settings_->shape, settings_->tracker, settings_->seed);
  body_ = make_body_tracker(*settings_);
  odometry_.emplace(kOdometryHistory, kOdometryReach);
  camera_.reset();
  calibration_.reset();
  last_pose_.reset();
  half_width_ = 0;
  width_ = 0;
  pictures_ = 0;
  locked_ = 0;

  track_publisher_ =
      create_publisher(topics::kPipeTrack, {.events = {.matched = awaited_.on_matched()}});
  particles_publisher_ = create_publisher(topics::kPipeTrackParticles);
  odometry_subscription_ = create_subscription(
      topics::kOdometryFiltered, [this](const Odometry& message) { on_odometry(message); });
  image_silence_.start("image", settings_->silent_after);
  counts_timer_ = create_timer(std::chrono::seconds(1), [this] { tell_counts(); });
  awaited_.watch({track_publisher_.untyped()}, [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

void ThermalTracker::subscribe() {
  camera_info_subscription_ = create_subscription(
      topics::kThermalCameraInfo, [this](const CameraInfo& message) { on_camera_info(message); });
  image_subscription_ = create_subscription(topics::kThermalImage,
                                            [this](const Image& message) { on_image(message); });
}

CallbackReturn ThermalTracker::on_cleanup() {
  awaited_.stop();
  image_silence_.stop();
  counts_timer_.reset();
  image_subscription_ = {};
  camera_info_subscription_ = {};
  odometry_subscription_ = {};
  track_publisher_ = {};
  particles_publisher_ = {};
  body_.reset();
  tracker_.reset();
  detector_.reset();
  odometry_.reset();
  return CallbackReturn::kSuccess;
}

void ThermalTracker::on_camera_info(const CameraInfo& message) {
  if (calibration_ && same_calibration(*calibration_, message)) {
    return;
  }
  try {
    camera_.emplace(from_message(message));
    calibration_ = message;
  } catch (const std::invalid_argument& error) {
    report_fault("camera_info.refused", std::string("calibration refused: ") + error.what());
  }
}

void ThermalTracker::on_odometry(const Odometry& message) {
  take_odometry(
      *odometry_, message,
      {settings_->stamp_limits, settings_->map_frame, /*needs_covariance=*/true}, now(),
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
}

ThermalTracker::Circumstances ThermalTracker::circumstances(Time stamp, const Image& message) {
  Circumstances known;
  const auto last = std::exchange(last_pose_, std::nullopt);
  if (!camera_) {
    report_fault("camera_info.missing",
                 "images without a calibration on thermal/camera_info: the motion of the camera is "
                 "not used");
    return known;
  }
  const geometry::CameraParameters& camera = camera_->parameters();
  if (static_cast<std::int64_t>(message.width) != camera.width ||
      static_cast<std::int64_t>(message.height) != camera.height) {
    report_fault("camera_info.other_size", "a picture of " + std::to_string(message.width) + " x " +
                                               std::to_string(message.height) +
                                               " does not match the calibration of the camera");
    return known;
  }
  const auto T_map_base = odometry_->at(stamp);
  const auto covariance = odometry_->covariance_at(stamp);
  std::string missing;
  const auto T_base_camera = settings_->mount.T_base_camera(stamp, &missing);
  if (!T_map_base || !covariance) {
    // Before the first one, odometry has not begun, or there is none.
    if (odometry_subscription_.statistics().received > 0) {
      report_fault("odometry.missing", "no pose of the robot for an image");
    }
    return known;
  }
  if (!T_base_camera) {
    report_fault("tf.missing",
                 "where the camera was on the robot is not known of a picture: " + missing);
    return known;
  }
  known.T_map_camera = *T_map_base * *T_base_camera;
  last_pose_ = CameraPose{stamp, *known.T_map_camera};
  if (const auto expected = expected_section(settings_->lines, settings_->line_deviation, *camera_,
                                             {.T_map_base = *T_map_base, .covariance = *covariance},
                                             *T_base_camera)) {
    known.hint = expected->hint;
    known.depth = expected->depth;
  }
  const double since = last ? to_seconds(stamp - last->time) : 0.0;
  if (since > 0 && since <= kLongestInterval) {
    known.motion =
        tracking::image_motion(*camera_, followed_place(), depth(known),
                               (last->T_map_camera.inverse() * *known.T_map_camera).log() / since);
  }
  return known;
}

Eigen::Vector2d ThermalTracker::followed_place() const {
  const geometry::CameraParameters& camera = camera_->parameters();
  const Eigen::Vector2d centre(camera.centre_u, camera.centre_v);
  if (body_) {
    return body_->middle().value_or(centre);
  }
  const tracking::PipeTrack& track = tracker_->track();
  return track.number > 0 ? Eigen::Vector2d(track.estimate.head<2>()) : centre;
}

double ThermalTracker::depth(const Circumstances& known) const {
  if (known.depth) {
    return *known.depth;
  }
  const double diameter = settings_->detection.detector.pipe_diameter;
  if (diameter > 0 && width_ > 0 && camera_) {
    return camera_->parameters().focal_length * diameter / width_;
  }
  return settings_->distance;
}

void ThermalTracker::take_regions(const Detections& detections) {
  regions_.clear();
  for (const thermal::PipeSection& pipe : detections.pipes) {
    regions_.push_back({.start = pipe.start,
                        .end = pipe.end,
                        .half_width = pipe.half_width,
                        .cut_along = pipe.cut_along});
  }
}

void ThermalTracker::on_image(const Image& message) {
  image_silence_.heard();
  const Time stamp = from_message(message.header.stamp);
  if (const auto fault = settings_->stamp_limits.find_fault("image", stamp, now())) {
    report_fault(fault->counter, fault->text);
    return;
  }
  ThermalImageReader::View picture;
  std::span<const float> celsius;
  try {
    picture = reader_.read(message);
    celsius = settings_->detection.celsius_of(picture);
  } catch (const UndescribedPicture& error) {
    report_fault(error.counter(), error.what());
    return;
  } catch (const std::invalid_argument& error) {
    report_fault("image.refused", std::string("picture refused: ") + error.what());
    return;
  }
  ++pictures_;
  if (body_) {
    track_body(message, stamp, picture, celsius);
    return;
  }
  const Detections& detections = detect(*detector_, picture, celsius);
  if (detections.fault != FrameFault::kNone) {
    report_fault("image." + std::string(to_string(detections.fault)),
                 "detection failed in an image of " + std::to_string(message.width) + " x " +
                     std::to_string(message.height) + ": " +
                     std::string(to_string(detections.fault)));
  }
  take_regions(detections);
  const Circumstances known = circumstances(stamp, message);
  const TrackState before = tracker_->track().state;
  const bool follows = before == TrackState::kLocked || before == TrackState::kCoasting;
  if (!settings_->lines.empty() && known.T_map_camera && !known.hint && !follows) {
    regions_.clear();  // none is of a pipe of the lines
  }
  const tracking::PipeTrack& track = tracker_->update(
      {.time = to_seconds(stamp.time_since_epoch()),
       .image = {static_cast<int>(message.width), static_cast<int>(message.height)},
       .regions = regions_,
       .motion = known.motion,
       .hint = known.hint});
  if (track.fault != TrackFault::kNone) {
    report_fault("track." + std::string(to_string(track.fault)),
                 "the track cannot use all of an image: " + std::string(to_string(track.fault)));
  }
  if (track.region) {
    const thermal::PipeSection& pipe = detections.pipes.at(*track.region);
    half_width_ = pipe.half_width;
    if (!pipe.cut_along) {
      width_ = pipe.best_width();
    }
  }
  locked_ += track.state == TrackState::kLocked ? 1 : 0;
  publish(message, track, detections, known);
}

void ThermalTracker::track_body(const Image& message, Time stamp,
                                const ThermalImageReader::View& picture,
                                std::span<const float> celsius) {
  if (settings_->detection.levels && std::holds_alternative<thermal::GreyView>(picture)) {
    report_fault("image.grey_without_range",
                 "images of grey levels without degrees, and parameter 'shape' needs degrees");
    return;
  }
  take_degrees(picture, celsius, degrees_);
  const Circumstances known = circumstances(stamp, message);
  body_->update({.time = to_seconds(stamp.time_since_epoch()),
                 .image = {static_cast<int>(message.width), static_cast<int>(message.height)},
                 .celsius = degrees_,
                 .motion = known.motion});
  if (body_->fault() != TrackFault::kNone) {
    report_fault("track." + std::string(to_string(body_->fault())),
                 "the track cannot use all of an image: " + std::string(to_string(body_->fault())));
  }
  locked_ += body_->state() == TrackState::kLocked ? 1 : 0;
  publish_body(message, known);
}

void ThermalTracker::publish_body(const Image& picture, const Circumstances& known) {
  auto told = std::make_unique<PipeTrack>(body_->message());
  told->header = picture.header;
  told->width = picture.width;
  told->height = picture.height;
  if (body_->fault() == TrackFault::kBadImageSize || body_->fault() == TrackFault::kTimeWentBack) {
    told->fault = std::string(to_string(body_->fault()));
  }
  told->range = std::numeric_limits<double>::quiet_NaN();
  if (const auto middle = body_->middle(); middle && camera_) {
    if (const auto ray = camera_->ray(*middle)) {
      told->range = depth(known) * ray->norm();
    }
  }
  track_publisher_.publish(std::move(told));
  if (particles_publisher_.subscription_count() > 0) {
    auto particles = std::make_unique<Particles>(body_->particles(settings_->published_particles));
    particles->header = picture.header;
    particles_publisher_.publish(std::move(particles));
  }
}

void ThermalTracker::publish(const Image& picture, const tracking::PipeTrack& track,
                             const Detections& detections, const Circumstances& known) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  auto told = std::make_unique<PipeTrack>(track_message(track));
  told->header = picture.header;
  told->width = picture.width;
  told->height = picture.height;
  if (detections.fault != FrameFault::kNone) {
    told->fault = std::string(to_string(detections.fault));
  } else if (track.fault == TrackFault::kBadImageSize || track.fault == TrackFault::kTimeWentBack) {
    told->fault = std::string(to_string(track.fault));
  }
  const bool of_use = track.number > 0 && track.in_view;
  told->half_width = of_use && half_width_ > 0 ? half_width_ : kNaN;
  told->whole_width =
      of_use && whole_width_in_view(track.estimate, half_width_, picture.width, picture.height);
  told->range = kNaN;
  if (of_use && camera_) {
    if (const auto ray = camera_->ray(track.estimate.head<2>())) {
      told->range = depth(known) * ray->norm();
    }
  }
  track_publisher_.publish(std::move(told));

  if (particles_publisher_.subscription_count() > 0) {
    auto particles = std::make_unique<Particles>(
        particles_message<PipeShape>(tracker_->filter(), regions_, settings_->published_particles));
    particles->header = picture.header;
    particles_publisher_.publish(std::move(particles));
  }
}

void ThermalTracker::tell_counts() {
  diagnostics().set_value("pictures", std::to_string(pictures_));
  diagnostics().set_value("pictures.locked", std::to_string(locked_));
  const tracking::PipeTrack& pipe = tracker_->track();
  const std::uint64_t number = body_ ? body_->message().track : pipe.number;
  const double confidence = body_ ? body_->message().confidence : pipe.confidence;
  diagnostics().set_value("track", std::to_string(number));
  diagnostics().set_value("track.state",
                          std::string(to_string(body_ ? body_->state() : pipe.state)));
  diagnostics().set_value("track.confidence", validation::number_text(confidence));
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::ThermalTracker)
