// SPDX-License-Identifier: Apache-2.0
#include "recording_factors.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <type_traits>

namespace pipescout::estimation {
namespace {

/// Times that differ by less are one, s; as in FixedLagSmoother.
constexpr double kSameTime = 1e-4;

template <class Measurement, class... Factors>
auto factor_of(const std::variant<Factors...>* /*which*/, const Measurement& m) {
  std::optional<AnyFactor> made;
  const auto try_one = [&]<class Factor>(std::type_identity<Factor>) {
    if constexpr (std::is_same_v<typename Factor::MeasurementType, Measurement>) {
      made.emplace(Factor(m));
    }
  };
  (try_one(std::type_identity<Factors>{}), ...);
  return made;
}

std::size_t keyframe_at(const std::vector<double>& times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), time + kSameTime);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times.begin() - 1, 0));
}

}  // namespace

PlacedMeasurement placed(const AnyMeasurement& measurement, const std::vector<double>& times) {
  return std::visit(
      [&](const auto& m) {
        PlacedMeasurement all;
        const AnyFactor* const kinds = nullptr;
        std::optional<AnyFactor> factor = factor_of(kinds, m);
        std::visit(
            [&](const auto& f) {
              using Factor = std::decay_t<decltype(f)>;
              all.report.kind = Factor::kKind;
              all.report.degrees = Factor::kRows;
            },
            *factor);
        if constexpr (requires { m.to_time; }) {
          all.from_time = m.from_time;
          all.to_time = m.to_time;
        } else {
          all.from_time = all.to_time = m.time;
        }
        all.report.time = all.to_time;
        all.report.outcome = outcome_of(check(m), Outcome::kAccepted);
        if (all.report.outcome == Outcome::kAccepted && all.from_time < times.front() - kSameTime) {
          all.report.outcome = Outcome::kLate;
        } else if (all.report.outcome == Outcome::kAccepted &&
                   all.to_time > times.back() + kSameTime) {
          all.report.outcome = Outcome::kFuture;
        }
        if (all.report.outcome == Outcome::kAccepted) {
          all.factor = std::move(factor);
          all.from = keyframe_at(times, all.from_time);
          all.to = keyframe_at(times, all.to_time);
        } else {
          all.report.weight = 0;
        }
        return all;
      },
      measurement);
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
