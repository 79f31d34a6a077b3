// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/tracking_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::tracking_study {
namespace {

using tracking::PipeShape;
using tracking::PipeTrack;
using tracking::TrackState;

constexpr double kFarOff = 10;  // px, from the axis
constexpr double kLost = 1;     // s
constexpr std::uint64_t kBootstrap = 0xb0;

/// px, of the middle of what is in view from the axis of the estimate.
double off_axis(const PipeShape::State& estimate, const PipeShape::State& truth) {
  const Eigen::Vector2d away = truth.head<2>() - estimate.head<2>();
  const double angle = estimate[PipeShape::kAngle];
  return std::abs(away.y() * std::cos(angle) - away.x() * std::sin(angle));
}

bool in_image(const PipeShape::State& state, const tracking::ImageSize& image) {
  return state[PipeShape::kX] >= 0 && state[PipeShape::kX] < image.width &&
         state[PipeShape::kY] >= 0 && state[PipeShape::kY] < image.height;
}

}  // namespace

void Moments::add(double value) {
  ++count_;
  sum_ += value;
  squares_ += value * value;
}

Moments& Moments::operator+=(const Moments& other) {
  count_ += other.count_;
  sum_ += other.sum_;
  squares_ += other.squares_;
  return *this;
}

double Moments::mean() const noexcept {
  return count_ == 0 ? std::numeric_limits<double>::quiet_NaN()
                     : sum_ / static_cast<double>(count_);
}

double Moments::deviation() const noexcept {
  const double m = mean();
  return count_ == 0 ? m : std::sqrt(std::max(0.0, squares_ / static_cast<double>(count_) - m * m));
}

void EstimateErrors::add(const PipeShape::State& estimate, const PipeShape::State& truth) {
  const PipeShape::State error = estimate - truth;
  position.add(error.head<2>().norm());
  angle.add(std::abs(std::remainder(error[PipeShape::kAngle], std::numbers::pi)) * 180 /
            std::numbers::pi);
  length.add(std::abs(error[PipeShape::kLength]));
}

DeviationInterval deviation_interval(std::span<const Moments> sequences, std::uint64_t seed) {
  constexpr std::size_t kResamples = 2000;
  constexpr std::size_t kTail = kResamples / 40;
  Moments all;
  for (const Moments& sequence : sequences) {
    all += sequence;
  }
  if (all.count() == 0) {
    return {all.deviation(), all.deviation()};
  }
  statistics::Draw draw(seed, kBootstrap);
  std::vector<double> deviations;
  deviations.reserve(kResamples);
  while (deviations.size() < kResamples) {
    Moments resample;
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      resample += sequences[draw.index(sequences.size())];
    }
    deviations.push_back(resample.count() == 0 ? 0 : resample.deviation());
  }
  std::ranges::sort(deviations);
  return {deviations[kTail], deviations[kResamples - 1 - kTail]};
}

EstimateErrors& EstimateErrors::operator+=(const EstimateErrors& other) {
  position += other.position;
  angle += other.angle;
  length += other.length;
  return *this;
}

TrackingScore& TrackingScore::operator+=(const TrackingScore& other) {
  for (std::size_t i = 0; i < kEstimates; ++i) {
    errors[i] += other.errors[i];
  }
  in_gaps += other.in_gaps;
  pictures += other.pictures;
  lost_tracks += other.lost_tracks;
  return *this;
}

tracking::TrackingFrame<PipeShape> frame_of(const Recording& recording,
                                            const RecordedPicture& picture, const PipeTrack& track,
                                            bool odometry) {
  tracking::TrackingFrame<PipeShape> frame{
      .time = picture.time, .image = recording.image(), .regions = recording.of(picture)};
  if (odometry) {
    frame.motion = tracking::image_motion(recording.camera, track.estimate.head<2>(),
                                          recording.depth, picture.velocity);
  }
  return frame;
}

TrackingScore score_tracking(const Recording& recording, const TrackingSettings& settings,
                             std::uint64_t seed) {
  tracking::PipeTracker tracker(settings.shape, settings.tracker, seed);
  TrackingScore score;
  double off_for = 0;
  double before = recording.pictures.empty() ? 0 : recording.pictures.front().time;
  bool locked = false;
  std::uint64_t number = 0;
  for (const RecordedPicture& picture : recording.pictures) {
    const PipeTrack& track =
        tracker.update(frame_of(recording, picture, tracker.track(), settings.odometry));
    locked = locked || track.state == TrackState::kLocked;
    const double elapsed = picture.time - before;
    before = picture.time;
    const bool visible =
        picture.truth && (*picture.truth)[PipeShape::kLength] >= TrackingSettings::kLeastLength;
    if (!visible) {
      off_for = 0;
      continue;
    }
    if (locked && track.number != 0 && track.state != TrackState::kLost) {
      ++score.pictures;
      score.errors[kBestParticle].add(track.best_particle, *picture.truth);
      score.errors[kRobustMean].add(track.robust_mean, *picture.truth);
      score.errors[kWeightedMean].add(track.weighted_mean, *picture.truth);
      score.errors[kOurs].add(track.estimate, *picture.truth);
      if (picture.gap) {
        score.in_gaps.add(track.estimate, *picture.truth);
      }
    }
    if (track.number > number) {
      score.lost_tracks += number == 0 ? 0 : 1;
      number = track.number;
    }
    if (picture.gap) {
      continue;
    }
    const bool on =
        track.state == TrackState::kLocked && off_axis(track.estimate, *picture.truth) <= kFarOff;
    const double off_before = off_for;
    off_for = on ? 0 : off_for + elapsed;
    score.lost_tracks += off_for >= kLost && off_before < kLost ? 1 : 0;
  }
  return score;
}

TrackingScore score_paper_filter(const Recording& recording, const TrackingSettings& settings,
                                 std::uint64_t seed) {
  using State = PipeShape::State;
  tracking::ParticleFilter<PipeShape> filter(settings.shape, settings.tracker.filter, seed);
  TrackingScore score;
  std::vector<State> sections;
  State rate = State::Zero();
  State last = State::Zero();
  double before = 0;
  double off_for = 0;
  for (const RecordedPicture& picture : recording.pictures) {
    sections.clear();
    for (const tracking::PipeRegion& region : recording.of(picture)) {
      sections.push_back(PipeShape::state_of(region));
    }
    const double elapsed = picture.time - before;
    if (filter.started()) {
      filter.predict(elapsed, rate);
      filter.update(sections);
      const State now = filter.robust_mean();
      rate = (now - last) / elapsed;
      rate[PipeShape::kAngle] =
          std::remainder(now[PipeShape::kAngle] - last[PipeShape::kAngle], std::numbers::pi) /
          elapsed;
      last = now;
    }
    if ((!filter.started() || !in_image(last, recording.image())) && !sections.empty()) {
      rate = State::Zero();
      last = *std::ranges::max_element(
          sections, {}, [](const State& section) { return section[PipeShape::kLength]; });
      filter.start(last);
    }
    before = picture.time;
    const bool visible =
        picture.truth && (*picture.truth)[PipeShape::kLength] >= TrackingSettings::kLeastLength;
    if (!visible || !filter.started()) {
      off_for = 0;
      continue;
    }
    ++score.pictures;
    score.errors[kBestParticle].add(filter.best(), *picture.truth);
    score.errors[kRobustMean].add(filter.robust_mean(), *picture.truth);
    score.errors[kWeightedMean].add(filter.weighted_mean(), *picture.truth);
    if (!picture.gap) {
      const bool on = off_axis(filter.robust_mean(), *picture.truth) <= kFarOff;
      const double off_before = off_for;
      off_for = on ? 0 : off_for + elapsed;
      score.lost_tracks += off_for >= kLost && off_before < kLost ? 1 : 0;
    }
  }
  return score;
}

bool TableRow::covers_deviations(const EstimateErrors& errors) const {
  return errors.position.deviation() <= position_deviation &&
         errors.angle.deviation() <= angle_deviation &&
         errors.length.deviation() <= length_deviation;
}

bool TableRow::covers(const EstimateErrors& errors) const {
  return errors.position.mean() <= position_mean && errors.angle.mean() <= angle_mean &&
         errors.length.mean() <= length_mean;
}

}  // namespace pipescout::tracking_study
