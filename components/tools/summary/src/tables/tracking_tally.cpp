// SPDX-License-Identifier: Apache-2.0
#include "tables/tracking_tally.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/runtime/conversions.hpp"

#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

using pipescout_msgs::msg::ArmState;
using pipescout_msgs::msg::PipeTrack;
using pipescout_msgs::msg::TrackedSection;

/// Of truths that wait for their track: two seconds at 50 Hz.
constexpr std::size_t kMostTruths = 100;

constexpr std::array kEstimateNames{"estimate", "best_particle", "robust_mean", "weighted_mean"};
constexpr std::array kErrorNames{"position_px", "angle_deg", "length_px"};

constexpr double kParts = 1e3;

double percent(std::uint64_t part, std::uint64_t whole) {
  return std::round(1e5 * static_cast<double>(part) / static_cast<double>(whole)) / 1e3;
}

/// px, across the pipe, from the middle of the picture to the axis of the pipe.
double offset(const PipeTrack& truth) {
  const double u = (truth.width - 1) / 2.0 - truth.estimate.u;
  const double v = (truth.height - 1) / 2.0 - truth.estimate.v;
  return u * std::sin(truth.estimate.angle) - v * std::cos(truth.estimate.angle);
}

}  // namespace

void TrackingTally::Errors::add(const TrackedSection& estimate, const TrackedSection& truth) {
  const std::array values{std::hypot(estimate.u - truth.u, estimate.v - truth.v),
                          std::abs(std::remainder(estimate.angle - truth.angle, std::numbers::pi)) *
                              180 / std::numbers::pi,
                          std::abs(estimate.length - truth.length)};
  ++count;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum[i] += values[i];
    sum_of_squares[i] += values[i] * values[i];
  }
}

void TrackingTally::add(const PipeTrack& track) {
  ++pictures_;
  locked_ += track.state == PipeTrack::STATE_LOCKED ? 1 : 0;
  lost_ += track.state == PipeTrack::STATE_LOST && last_state_ != PipeTrack::STATE_LOST ? 1 : 0;
  last_state_ = track.state;
  last_track_ = std::max(last_track_, track.track);
  const auto same = std::ranges::find_if(
      truths_, [&](const PipeTrack& truth) { return truth.header.stamp == track.header.stamp; });
  if (same != truths_.end()) {
    compare(track, *same);
    truths_.erase(truths_.begin(), std::next(same));
  }
}

void TrackingTally::add_truth(const PipeTrack& truth) {
  if (truth.track > 0) {
    ++beside_pipe_;
    whole_width_ += truth.whole_width ? 1 : 0;
    if (truth.state == PipeTrack::STATE_LOCKED) {
      ++in_view_;
      const double away = offset(truth);
      sum_of_square_offsets_ += away * away;
    }
  }
  if (truths_.size() == kMostTruths) {
    truths_.pop_front();
  }
  truths_.push_back(truth);
}

void TrackingTally::compare(const PipeTrack& track, const PipeTrack& truth) {
  const bool told =
      track.state == PipeTrack::STATE_LOCKED || track.state == PipeTrack::STATE_COASTING;
  if (!told || truth.state != PipeTrack::STATE_LOCKED || truth.track == 0) {
    return;
  }
  const std::array<const TrackedSection*, kEstimates> estimates{
      &track.estimate, &track.best_particle, &track.robust_mean, &track.weighted_mean};
  for (std::size_t i = 0; i < kEstimates; ++i) {
    errors_[i].add(*estimates[i], truth.estimate);
  }
}

void TrackingTally::add(const pipescout_msgs::msg::ArmState& state) {
  ++arm_cycles_;
  ++arm_states_[state.state];
  limited_ += state.limited.empty() ? 0 : 1;
}

MissionSection TrackingTally::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "Tracking";
  const auto set = [&](const std::string& name, double value) {
    section.figures[figure_prefix + name] = value;
  };
  set("track_pictures", static_cast<double>(pictures_));
  set("tracks", static_cast<double>(last_track_));
  set("track_lost", static_cast<double>(lost_));
  if (pictures_ > 0) {
    set("track_locked_percent", percent(locked_, pictures_));
  }
  if (beside_pipe_ > 0) {
    set("track_in_view_percent", percent(whole_width_, beside_pipe_));
  }
  if (in_view_ > 0) {
    set("track_image_error_rms_px",
        std::sqrt(sum_of_square_offsets_ / static_cast<double>(in_view_)));
  }
  if (arm_cycles_ > 0) {
    const auto of_state = [this](std::uint8_t state) {
      const auto found = arm_states_.find(state);
      return found == arm_states_.end() ? std::uint64_t{0} : found->second;
    };
    set("arm_cycles", static_cast<double>(arm_cycles_));
    set("arm_tracking_percent", percent(of_state(ArmState::STATE_TRACKING), arm_cycles_));
    set("arm_fault_cycles", static_cast<double>(of_state(ArmState::STATE_FAULT)));
    set("arm_limited_percent", percent(limited_, arm_cycles_));
  }
  if (errors_[0].count > 0) {
    section.columns = {"estimate"};
    for (const char* name : {"position [px]", "angle [deg]", "length [px]"}) {
      section.columns.push_back(std::string(name) + " mean");
      section.columns.push_back(std::string(name) + " deviation");
    }
    for (std::size_t i = 0; i < kEstimates; ++i) {
      const auto count = static_cast<double>(errors_[i].count);
      std::vector<MissionCell> row{std::string(kEstimateNames[i])};
      for (std::size_t k = 0; k < kErrorNames.size(); ++k) {
        const double mean = errors_[i].sum[k] / count;
        row.push_back(rounded_cell(mean, kParts));
        row.push_back(rounded_cell(
            std::sqrt(std::max(0.0, errors_[i].sum_of_squares[k] / count - mean * mean)), kParts));
        set("track_" + std::string(kEstimateNames[i]) + "_" + kErrorNames[k], mean);
      }
      section.rows.push_back(std::move(row));
    }
  }
  return section;
}

}  // namespace pipescout::summary
