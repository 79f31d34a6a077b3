// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_recorder/tracking_recorder.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "picture_file.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_line.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "tracking_tally.hpp"

namespace pipescout {

namespace {

using pipescout_msgs::msg::ArmState;
using pipescout_msgs::msg::PipeTrack;
using pipescout_msgs::msg::TrackedSection;

/// In one message; more than any arm or tracker has.
constexpr std::size_t kMostJoints = 1000;
constexpr std::size_t kMostParticles = 100000;

constexpr std::array kTrackStates{"detecting", "locked", "coasting", "lost"};
constexpr std::array kArmStates{"idle",    "tracking", "holding", "searching",
                                "stowing", "stowed",   "fault"};

template <class Names>
const char* name_of(const Names& names, std::uint8_t state) {
  if (state >= names.size()) {
    throw std::invalid_argument("the state is not one of STATE_*");
  }
  return names.at(state);
}

std::string track_header() {
  return "stamp,fault,state,track,confidence,since_seen,u,v,length,angle,u_standard_deviation,"
         "v_standard_deviation,length_standard_deviation,angle_standard_deviation,half_width,"
         "whole_width,range,best_particle.u,best_particle.v,best_particle.length,"
         "best_particle.angle,robust_mean.u,robust_mean.v,robust_mean.length,robust_mean.angle,"
         "weighted_mean.u,weighted_mean.v,weighted_mean.length,weighted_mean.angle,"
         "effective_samples,regions";
}

std::string truth_header() {
  return "stamp,beside_pipe,in_view,u,v,length,angle,half_width,whole_width,range,width,height";
}

std::string particles_header() {
  return "stamp,u,v,length,angle,weight";
}

std::string arm_header() {
  return "stamp,state,reason,error_u,error_v,error_angle,feed_forward,manipulability,limited";
}

std::string joints_header() {
  return "stamp,joint,position,velocity";
}

std::string pictures_header() {
  return "stamp,file";
}

/// Nothing for a value that there is not.
void add(CsvLine& line, double value) {
  if (std::isfinite(value)) {
    line.add(value);
  } else {
    line.add_empty();
  }
}

void add(CsvLine& line, const TrackedSection& section) {
  for (const double value : {section.u, section.v, section.length, section.angle}) {
    add(line, value);
  }
}

}  // namespace

TrackingRecorder::TrackingRecorder(ComponentOptions options)
    : StreamRecorder(std::move(options), "tracking"), tally_(std::make_unique<TrackingTally>()) {
  picture_interval_ = parameters().declare<double>(
      "picture_interval", 0.8,
      {.description = "s between recorded images with their particles; 0: none",
       .floating_point_range = FloatingPointRange{0.0, 1e6}});
  maximum_pictures_ =
      parameters().declare<std::size_t>("maximum_pictures", 600,
                                        {.description = "largest number of recorded images",
                                         .integer_range = IntegerRange{0, 1000000}});
}

TrackingRecorder::~TrackingRecorder() = default;

CallbackReturn TrackingRecorder::on_configure() {
  tally_ = std::make_unique<TrackingTally>();
  const double interval = picture_interval_.get();
  most_pictures_ = interval > 0 ? maximum_pictures_.get() : 0;
  picture_thinning_ = Thinning(from_seconds(interval));
  last_picture_ = {};
  pictures_ = 0;
  begin_recording();
  record(topics::kTruePipeTrack, "truth", [this](const Track& message) { on_truth(message); });
  record(topics::kPipeTrack, "track", [this](const Track& message) { on_track(message); });
  record(topics::kPipeTrackParticles, "particles",
         [this](const Particles& message) { on_particles(message); });
  record(topics::kArmState, "arm_state", [this](const ArmState& message) { on_arm(message); });
  record(topics::kJointStates, "joint_states",
         [this](const JointState& message) { on_joints(message); });
  record(topics::kThermalImage, "image", [this](const Image& message) { on_image(message); });
  return CallbackReturn::kSuccess;
}

void TrackingRecorder::on_track(const Track& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(message.fault)
      .add(name_of(kTrackStates, message.state))
      .add(message.track)
      .add(message.confidence);
  add(line, message.since_seen);
  if (message.state == PipeTrack::STATE_DETECTING) {
    line.add_empty(8);
  } else {
    add(line, message.estimate);
    for (std::size_t i = 0; i < 4; ++i) {
      add(line, std::sqrt(message.covariance[5 * i]));
    }
  }
  add(line, message.half_width);
  line.add(message.whole_width);
  add(line, message.range);
  if (message.state == PipeTrack::STATE_DETECTING) {
    line.add_empty(12);
  } else {
    add(line, message.best_particle);
    add(line, message.robust_mean);
    add(line, message.weighted_mean);
  }
  line.add(message.effective_samples).add(std::uint64_t{message.regions});
  file("track.csv", track_header).write(line.text());
  tally_->add(message);
}

void TrackingRecorder::on_truth(const Track& message) {
  const bool in_view = message.state == PipeTrack::STATE_LOCKED;
  CsvLine line(from_message(message.header.stamp));
  line.add(message.track > 0).add(in_view);
  if (in_view) {
    add(line, message.estimate);
  } else {
    line.add_empty(4);
  }
  add(line, message.half_width);
  line.add(message.whole_width);
  add(line, message.range);
  line.add(std::uint64_t{message.width}).add(std::uint64_t{message.height});
  file("truth.csv", truth_header).write(line.text());
  tally_->add_truth(message);
}

void TrackingRecorder::on_particles(const Particles& message) {
  const std::size_t count = message.u.size();
  if (count > kMostParticles || message.v.size() != count || message.length.size() != count ||
      message.angle.size() != count || message.weight.size() != count) {
    throw std::invalid_argument("more than 100000 particles, or arrays of different sizes");
  }
  const Time stamp = from_message(message.header.stamp);
  if (stamp != last_picture_ || pictures_ == 0) {
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    CsvLine line(stamp);
    for (const float value :
         {message.u[i], message.v[i], message.length[i], message.angle[i], message.weight[i]}) {
      line.add_short(static_cast<double>(value));
    }
    file("particles.csv", particles_header).write(line.text());
  }
}

void TrackingRecorder::on_arm(const ArmState& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(name_of(kArmStates, message.state)).add(message.reason);
  for (const double value : {message.error_u, message.error_v, message.error_angle}) {
    add(line, value);
  }
  line.add(message.feed_forward);
  add(line, message.manipulability);
  std::string limited;
  for (const std::string& limit : message.limited) {
    limited += (limited.empty() ? "" : "; ") + limit;
  }
  line.add(limited);
  file("arm.csv", arm_header).write(line.text());
  tally_->add(message);
}

void TrackingRecorder::on_joints(const JointState& message) {
  const std::size_t count = message.name.size();
  if (count > kMostJoints || message.position.size() != count ||
      (!message.velocity.empty() && message.velocity.size() != count)) {
    throw std::invalid_argument("more than 1000 joints, or arrays of different sizes");
  }
  for (std::size_t i = 0; i < count; ++i) {
    CsvLine line(from_message(message.header.stamp));
    line.add(message.name[i]);
    add(line, message.position[i]);
    add(line, message.velocity.empty() ? std::nan("") : message.velocity[i]);
    file("joints.csv", joints_header).write(line.text());
  }
}

void TrackingRecorder::on_image(const Image& message) {
  const Time stamp = from_message(message.header.stamp);
  if (pictures_ >= most_pictures_ || !picture_thinning_.due(stamp)) {
    return;
  }
  const std::string content = picture_file(reader_.read(message));
  if (pictures_ == 0) {
    std::filesystem::create_directory(data_folder() / "pictures");
  }
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "pictures/%06zu.png", pictures_);
  replace_file(data_folder() / name.data(), content, Survives::kKill);
  file("pictures.csv", pictures_header).write(CsvLine(stamp).add(name.data()).text());
  picture_thinning_.keep(stamp);
  last_picture_ = stamp;
  ++pictures_;
}

bool TrackingRecorder::has_data() const {
  return tally_->pictures() > 0;
}

std::string TrackingRecorder::counts() const {
  return std::to_string(tally_->pictures()) + " tracks of images and " +
         std::to_string(tally_->arm_cycles()) + " cycles of the arm received";
}

MissionSection TrackingRecorder::section(const std::string& figure_prefix) const {
  MissionSection section = tally_->section(figure_prefix);
  section.notes.push_back("Data: " + data_folder_name() +
                          "/track.csv, truth.csv, particles.csv, arm.csv, joints.csv, "
                          "pictures.csv.");
  return section;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::TrackingRecorder)
