// SPDX-License-Identifier: Apache-2.0
#include "recording_factors.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include "pipescout/validation/number_text.hpp"

namespace pipescout::estimation {
namespace {

template <class Guess>
void require_guesses(const std::string& name, const std::vector<Guess>& guesses,
                     std::size_t keyframes) {
  if (!guesses.empty() && guesses.size() != keyframes) {
    throw std::invalid_argument(name + ": " + std::to_string(guesses.size()) +
                                " is neither 0 nor the number of keyframes");
  }
  if (!std::ranges::all_of(guesses, &Guess::is_finite)) {
    throw std::invalid_argument(name + ": one is not finite");
  }
}

std::size_t keyframe_at(const std::vector<double>& times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), time + kSameTime);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times.begin() - 1, 0));
}

}  // namespace

void require_sound(const Recording& recording) {
  if (recording.times.empty()) {
    throw std::invalid_argument("recording.times: there are none");
  }
  for (std::size_t k = 0; k < recording.times.size(); ++k) {
    if (!std::isfinite(recording.times[k]) ||
        (k > 0 && !(recording.times[k] > recording.times[k - 1] + kSameTime))) {
      throw std::invalid_argument(
          "recording.times: " + validation::number_text(recording.times[k]) +
          " is not finite or not more than 1e-4 s after the last");
    }
  }
  require_guesses("recording.guesses", recording.guesses, recording.times.size());
  require_guesses("recording.imu_scale_guesses", recording.imu_scale_guesses,
                  recording.times.size());
}

PlacedMeasurement placed(const AnyFactor& factor, const std::vector<double>& times) {
  PlacedMeasurement all;
  all.report.kind = factor.kind();
  all.report.degrees = factor.rows();
  all.from_time = factor.from_time();
  all.to_time = factor.to_time();
  all.report.time = all.to_time;
  all.report.outcome = outcome_of(factor.fault(), Outcome::kAccepted);
  if (all.report.outcome == Outcome::kAccepted && all.from_time < times.front() - kSameTime) {
    all.report.outcome = Outcome::kLate;
  } else if (all.report.outcome == Outcome::kAccepted && all.to_time > times.back() + kSameTime) {
    all.report.outcome = Outcome::kFuture;
  }
  if (all.report.outcome == Outcome::kAccepted) {
    all.factor = factor;
    all.from = keyframe_at(times, all.from_time);
    all.to = keyframe_at(times, all.to_time);
  } else {
    all.report.weight = 0;
  }
  return all;
}

ImuTimeline timeline_of(const std::vector<ImuSample>& samples, std::size_t& refused) {
  constexpr double kOverlap = 1e-9;
  // More than any sensor measures; sums over it could overflow.
  constexpr double kMostRate = 1e4;
  constexpr double kMostForce = 1e6;
  ImuTimeline timeline(std::max<std::size_t>(samples.size(), 1));
  refused = 0;
  for (ImuSample sample : samples) {
    const double overlap = timeline.empty() ? 0 : std::max(timeline.end() - sample.time, 0.0);
    if (!(std::isfinite(sample.time) && std::isfinite(sample.duration) &&
          sample.angular_rate.allFinite() && sample.specific_force.allFinite() &&
          sample.angular_rate.cwiseAbs().maxCoeff() <= kMostRate &&
          sample.specific_force.cwiseAbs().maxCoeff() <= kMostForce &&
          sample.duration > overlap + kOverlap)) {
      ++refused;
      continue;
    }
    sample.time += overlap;
    sample.duration -= overlap;
    timeline.push(sample);
  }
  return timeline;
}

}  // namespace pipescout::estimation
