// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <pipescout_msgs/msg/arm_state.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>

#include "pipescout/catalogue/stream_recorder.hpp"
#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/mission_tables/thinning.hpp"

namespace pipescout {

class TrackingTally;

/// Writes the track of a pipe and what the camera arm did into the mission folder: `track/pipe`,
/// `track/particles`, `arm/state`, `joint_states`, some pictures of `thermal/image_raw`, from a
/// simulation `ground_truth/pipe_track`; and how good it was into the mission's summary. Ends as
/// StreamRecorder.
///
/// Parameters: docs/components/tracking_recorder.md. They take effect when it is configured.
class TrackingRecorder final : public StreamRecorder {
 public:
  explicit TrackingRecorder(ComponentOptions options);
  ~TrackingRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  [[nodiscard]] bool has_data() const override;

 private:
  using ArmState = pipescout_msgs::msg::ArmState;
  using Image = sensor_msgs::msg::Image;
  using JointState = sensor_msgs::msg::JointState;
  using Particles = pipescout_msgs::msg::PipeTrackParticles;
  using Track = pipescout_msgs::msg::PipeTrack;

  void on_track(const Track& message);
  void on_truth(const Track& message);
  void on_particles(const Particles& message);
  void on_arm(const ArmState& message);
  void on_joints(const JointState& message);
  void on_image(const Image& message);

  Parameter<double> picture_interval_;
  Parameter<std::size_t> maximum_pictures_;

  // As configured.
  std::size_t most_pictures_ = 0;

  std::unique_ptr<TrackingTally> tally_;
  ThermalImageReader reader_;
  Thinning picture_thinning_;
  Time last_picture_{};  // that was kept: its particles are too
  std::size_t pictures_ = 0;
};

}  // namespace pipescout
