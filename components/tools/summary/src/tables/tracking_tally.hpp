// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <pipescout_msgs/msg/arm_state.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <string>

#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::summary {

/// How good a run's track was and how well the arm kept the pipe in view, for the mission's
/// summary. Bounded. Pure; not thread-safe.
class TrackingTally {
 public:
  void add(const pipescout_msgs::msg::PipeTrack& track);
  /// What really is in the picture of the same stamp, from a simulation. Its `track` is 0 where no
  /// pipe could be seen wherever the camera looked.
  void add_truth(const pipescout_msgs::msg::PipeTrack& truth);
  void add(const pipescout_msgs::msg::ArmState& state);

  [[nodiscard]] std::uint64_t pictures() const noexcept { return pictures_; }
  [[nodiscard]] std::uint64_t arm_cycles() const noexcept { return arm_cycles_; }

  /// Names of figures begin with `figure_prefix`.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  using Track = pipescout_msgs::msg::PipeTrack;
  /// Absolute errors: position, px; angle, degrees; length, px.
  struct Errors {
    std::uint64_t count = 0;
    std::array<double, 3> sum{};
    std::array<double, 3> sum_of_squares{};
    void add(const pipescout_msgs::msg::TrackedSection& estimate,
             const pipescout_msgs::msg::TrackedSection& truth);
  };
  static constexpr std::size_t kEstimates = 4;

  void compare(const Track& track, const Track& truth);

  std::uint64_t pictures_ = 0;
  std::uint64_t locked_ = 0;
  std::uint64_t lost_ = 0;  // times
  std::uint64_t last_track_ = 0;
  std::uint8_t last_state_ = 0;
  std::uint64_t arm_cycles_ = 0;
  std::map<std::uint8_t, std::uint64_t> arm_states_;
  std::uint64_t limited_ = 0;
  std::deque<Track> truths_;  // of late, to be compared with tracks of the same stamp
  std::uint64_t beside_pipe_ = 0;
  std::uint64_t whole_width_ = 0;
  double sum_of_square_offsets_ = 0;  // px^2, across: of the middle of the pipe from that of the
                                      // picture
  std::uint64_t in_view_ = 0;
  std::array<Errors, kEstimates> errors_{};
};

}  // namespace pipescout::summary
