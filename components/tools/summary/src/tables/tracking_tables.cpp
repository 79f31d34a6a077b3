// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <cmath>
#include <cstdio>
#include <pipescout_msgs/msg/arm_state.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <stdexcept>
#include <string>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_line.hpp"
#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/mission_tables/thinning.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "tables/makers.hpp"
#include "tables/picture_file.hpp"
#include "tables/tracking_tally.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

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

void add_section(CsvLine& line, const TrackedSection& section) {
  for (const double value : {section.u, section.v, section.length, section.angle}) {
    add_or_empty(line, value);
  }
}

class TrackingTables final : public TableMaker {
 public:
  TrackingTables(const Robot& robot, const TableOptions::Tracking& options);

 protected:
  MissionSection section(const std::string& figure_prefix) const override {
    return tally_.section(figure_prefix);
  }
  std::string counts() const override {
    return std::to_string(tally_.pictures()) + " tracks of images and " +
           std::to_string(tally_.arm_cycles()) + " cycles of the arm received";
  }
  bool has_data() const override { return tally_.pictures() > 0; }
  bool has_section() const override { return tally_.pictures() > 0 || tally_.arm_cycles() > 0; }
  std::string file_names() const override {
    return "track.csv, truth.csv, particles.csv, arm.csv, joints.csv, pictures.csv";
  }

 private:
  using Image = sensor_msgs::msg::Image;
  using JointState = sensor_msgs::msg::JointState;
  using Particles = pipescout_msgs::msg::PipeTrackParticles;
  using Track = PipeTrack;

  void on_track(const Track& message);
  void on_truth(const Track& message);
  void on_particles(const Particles& message);
  void on_arm(const ArmState& message);
  void on_joints(const JointState& message);
  void on_image(const Image& message);

  std::size_t most_pictures_;
  TrackingTally tally_;
  ThermalImageReader reader_;
  Thinning picture_thinning_;
  Time last_picture_{};  // that was kept: its particles are too
  std::size_t pictures_ = 0;
};

TrackingTables::TrackingTables(const Robot& robot, const TableOptions::Tracking& options)
    : TableMaker(robot, "tracking"),
      most_pictures_(options.picture_interval > 0 ? options.maximum_pictures : 0),
      picture_thinning_(from_seconds(options.picture_interval)) {
  record(topics::kTruePipeTrack, "truth", [this](const Track& m) { on_truth(m); });
  record(topics::kPipeTrack, "tracks", [this](const Track& m) { on_track(m); });
  record(topics::kPipeTrackParticles, "particles", [this](const Particles& m) { on_particles(m); });
  record(topics::kArmState, "states of the arm", [this](const ArmState& m) { on_arm(m); });
  record(topics::kJointStates, "joints", [this](const JointState& m) { on_joints(m); });
  record(topics::kThermalImage, "images", [this](const Image& m) { on_image(m); });
}

void TrackingTables::on_track(const Track& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(message.fault)
      .add(name_of(kTrackStates, message.state))
      .add(message.track)
      .add(message.confidence);
  add_or_empty(line, message.since_seen);
  if (message.state == PipeTrack::STATE_DETECTING) {
    line.add_empty(8);
  } else {
    add_section(line, message.estimate);
    for (std::size_t i = 0; i < 4; ++i) {
      add_or_empty(line, std::sqrt(message.covariance[5 * i]));
    }
  }
  add_or_empty(line, message.half_width);
  line.add(message.whole_width);
  add_or_empty(line, message.range);
  if (message.state == PipeTrack::STATE_DETECTING) {
    line.add_empty(12);
  } else {
    add_section(line, message.best_particle);
    add_section(line, message.robust_mean);
    add_section(line, message.weighted_mean);
  }
  line.add(message.effective_samples).add(std::uint64_t{message.regions});
  file("track.csv", track_header).write(line.text());
  tally_.add(message);
}

void TrackingTables::on_truth(const Track& message) {
  const bool in_view = message.state == PipeTrack::STATE_LOCKED;
  CsvLine line(from_message(message.header.stamp));
  line.add(message.track > 0).add(in_view);
  if (in_view) {
    add_section(line, message.estimate);
  } else {
    line.add_empty(4);
  }
  add_or_empty(line, message.half_width);
  line.add(message.whole_width);
  add_or_empty(line, message.range);
  line.add(std::uint64_t{message.width}).add(std::uint64_t{message.height});
  file("truth.csv", truth_header).write(line.text());
  tally_.add_truth(message);
}

void TrackingTables::on_particles(const Particles& message) {
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

void TrackingTables::on_arm(const ArmState& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(name_of(kArmStates, message.state)).add(message.reason);
  for (const double value : {message.error_u, message.error_v, message.error_angle}) {
    add_or_empty(line, value);
  }
  line.add(message.feed_forward);
  add_or_empty(line, message.manipulability);
  std::string limited;
  for (const std::string& limit : message.limited) {
    limited += (limited.empty() ? "" : "; ") + limit;
  }
  line.add(limited);
  file("arm.csv", arm_header).write(line.text());
  tally_.add(message);
}

void TrackingTables::on_joints(const JointState& message) {
  const std::size_t count = message.name.size();
  if (count > kMostJoints || message.position.size() != count ||
      (!message.velocity.empty() && message.velocity.size() != count)) {
    throw std::invalid_argument("more than 1000 joints, or arrays of different sizes");
  }
  for (std::size_t i = 0; i < count; ++i) {
    CsvLine line(from_message(message.header.stamp));
    line.add(message.name[i]);
    add_or_empty(line, message.position[i]);
    add_or_empty(line, message.velocity.empty() ? std::nan("") : message.velocity[i]);
    file("joints.csv", joints_header).write(line.text());
  }
}

void TrackingTables::on_image(const Image& message) {
  const Time stamp = from_message(message.header.stamp);
  if (pictures_ >= most_pictures_ || !picture_thinning_.due(stamp)) {
    return;
  }
  const std::string content = picture_file(reader_.read(message));
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "pictures/%06zu.png", pictures_);
  files().write_whole(name.data(), content);
  file("pictures.csv", pictures_header).write(CsvLine(stamp).add(name.data()).text());
  picture_thinning_.keep(stamp);
  last_picture_ = stamp;
  ++pictures_;
}

}  // namespace

std::unique_ptr<TableMaker> tracking_tables(const Robot& robot,
                                            const TableOptions::Tracking& options) {
  return std::make_unique<TrackingTables>(robot, options);
}

}  // namespace pipescout::summary
