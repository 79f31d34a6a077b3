// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::rack_study {
namespace {

struct End {
  double error = 0;  // m
  double along = 0;  // m
};

End mean(std::span<const FrameScore* const> frames) {
  End end;
  for (const FrameScore* frame : frames) {
    end.error += frame->error.y();
    end.along += frame->along;
  }
  const auto count = static_cast<double>(frames.size());
  return {end.error / count, end.along / count};
}

}  // namespace

bool is_wrong(const FrameScore& frame) noexcept {
  // Written so that NaN is wrong.
  return frame.has_pose &&
         !(frame.position_error() <= kWrongPosition && frame.rotation_error() <= kWrongRotation);
}

ImageFlightScore& ImageFlightScore::operator+=(const ImageFlightScore& other) {
  images += other.images;
  with_pose += other.with_pose;
  wrong += other.wrong;
  position_covered += other.position_covered;
  pose_covered += other.pose_covered;
  pose_covered_99 += other.pose_covered_99;
  silent_wrong += other.silent_wrong;
  position_errors.insert(position_errors.end(), other.position_errors.begin(),
                         other.position_errors.end());
  rotation_errors.insert(rotation_errors.end(), other.rotation_errors.begin(),
                         other.rotation_errors.end());
  return *this;
}

double ImageFlightScore::with_pose_percent() const noexcept {
  return images == 0 ? 100.0 : 100.0 * static_cast<double>(with_pose) / static_cast<double>(images);
}

ImageFlightScore score_flight(std::span<const FrameScore> frames) {
  const double position_95 = statistics::chi_square_quantile(0.95, 3);
  const double pose_95 = statistics::chi_square_quantile(0.95, 6);
  const double pose_99 = statistics::chi_square_quantile(0.99, 6);
  ImageFlightScore score;
  for (const FrameScore& frame : frames) {
    if (frame.outage) {
      continue;
    }
    ++score.images;
    if (!frame.has_pose) {
      continue;
    }
    ++score.with_pose;
    score.wrong += is_wrong(frame) ? 1U : 0U;
    score.position_covered += frame.position_nees <= position_95 ? 1U : 0U;
    score.pose_covered += frame.pose_nees <= pose_95 ? 1U : 0U;
    // Written so that NaN is silent.
    const bool covered = frame.pose_nees <= pose_99;
    score.pose_covered_99 += covered ? 1U : 0U;
    score.silent_wrong += is_wrong(frame) && !covered ? 1U : 0U;
    score.position_errors.push_back(frame.position_error());
    score.rotation_errors.push_back(frame.rotation_error());
  }
  return score;
}

double along_drift_percent(std::span<const FrameScore> frames) {
  constexpr std::size_t kMean = 10;
  std::vector<const FrameScore*> posed;
  for (const FrameScore& frame : frames) {
    if (frame.has_pose) {
      posed.push_back(&frame);
    }
  }
  if (posed.size() < 2 * kMean || !frames.back().has_pose) {
    return std::numeric_limits<double>::infinity();
  }
  const End first = mean(std::span(posed).first(kMean));
  const End last = mean(std::span(posed).last(kMean));
  return 100.0 * std::abs(last.error - first.error) / std::abs(last.along - first.along);
}

Recovery score_recovery(std::span<const FrameScore> frames) {
  Recovery recovery;
  std::optional<double> over;
  bool begun = false;
  for (const FrameScore& frame : frames) {
    begun = begun || frame.outage;
    if (!begun) {
      continue;
    }
    recovery.wrong = recovery.wrong || is_wrong(frame);
    if (!over) {
      recovery.declared = recovery.declared || !frame.has_pose;
    }
    if (frame.outage) {
      continue;
    }
    if (!over) {
      over = frame.time;
    }
    if (!recovery.time && frame.has_pose && !is_wrong(frame)) {
      recovery.time = frame.time - *over;
    }
  }
  return recovery;
}

StretchScore score_stretch(std::span<const FrameScore> frames, double from, double to) {
  StretchScore score;
  const double position_95 = statistics::chi_square_quantile(0.95, 3);
  for (const FrameScore& frame : frames) {
    if (frame.along < from || frame.along > to) {
      continue;
    }
    ++score.images;
    if (!frame.has_pose) {
      continue;
    }
    if (score.with_pose == 0) {
      score.first_deviation = frame.along_deviation;
    }
    ++score.with_pose;
    score.covered += frame.position_nees <= position_95 ? 1U : 0U;
    score.largest_error = std::max(score.largest_error, std::abs(frame.error.y()));
    score.last_deviation = frame.along_deviation;
  }
  return score;
}

}  // namespace pipescout::rack_study
