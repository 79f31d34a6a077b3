// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "follow.hpp"
#include "observation.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings {

/// Evidence beyond, either way, does not count: it could not be taken back soon enough.
inline constexpr double kMostLogOdds = 6.0;

/// s: a picture as old says nothing of where a leak is in this one.
inline constexpr double kPictureMemory = 1.0;
/// Share of the picture's width that a leak is from where it would be if it moved on as it did, at
/// most.
inline constexpr double kNextStep = 0.04;
/// The same, while it is not known how it moved.
inline constexpr double kFirstStep = 0.1;

[[nodiscard]] inline double logit(double p) {
  return std::log(p / (1 - p));
}

/// What an observation has to do with a leak that is followed.
struct Match {
  double distance = 0;  ///< squared, standard deviations
  double motion = 0;    ///< evidence from where it is
};

struct LeakFindings::Implementation {
  LeakFindingsParameters p;
  geometry::Camera camera;
  Observer observer;
  std::vector<Finding> findings;  // as `followed`, for the outside
  std::vector<Follow> followed;   // by id
  std::vector<Follow> candidates;
  std::vector<Observation> observations;
  std::vector<std::uint8_t> used;
  FrameResult result;
  Counters counters;
  std::uint64_t next_id = 1;
  double last_time = -std::numeric_limits<double>::infinity();
  double pose_time = -std::numeric_limits<double>::infinity();  // of the latest picture with a pose
  std::optional<thermal::SoundPipe> sound;
  double sound_time = -std::numeric_limits<double>::infinity();

  Implementation(const LeakFindingsParameters& parameters, const geometry::Camera& c)
      : p((parameters.validate(), parameters)), camera(c), observer(p, camera) {
    candidates.reserve(p.max_candidates);
  }

  void update(const Frame& frame, const thermal::Detections& detections);
  [[nodiscard]] std::optional<Eye> eye_of(const Frame& frame);
  [[nodiscard]] thermal::FrameConditions conditions(const Frame& frame) const;
  [[nodiscard]] std::optional<Match> match(const Follow& follow, const Observation& o,
                                           const Frame& frame, const std::optional<Eye>& eye) const;
  [[nodiscard]] std::optional<Match> match_in_pass(const Follow& follow,
                                                   const Observation& o) const;
  [[nodiscard]] std::optional<Match> match_other_pass(const Finding& finding, const Observation& o,
                                                      const Eye& eye) const;
  void assign(const Frame& frame, const std::optional<Eye>& eye);
  void take(Follow& follow, std::size_t observation, const Match& match, const Frame& frame);
  void start_candidate(std::size_t observation, const Frame& frame);
  [[nodiscard]] bool seen_sound(const Follow& follow, const Frame& frame,
                                const std::optional<Eye>& eye, const thermal::Detections& d) const;
  void judge(const Frame& frame);
  [[nodiscard]] bool awaits_place(const Follow& candidate, double time) const;
  [[nodiscard]] bool is_known(const Follow& candidate, double time) const;
  void raise(Follow& candidate, const Frame& frame);
  void keep_next_eye(const Frame& frame, const Eye& eye);
  [[nodiscard]] bool seen_before_its_place(const Follow& placed, const Follow& without) const;
  [[nodiscard]] bool same_leak(const Follow& a, const Follow& b, double time) const;
  void tell(Follow& follow, EventKind kind, double time);
  void learn_sound_pipe(double time, const thermal::Detections& detections);
};

}  // namespace pipescout::leak_findings
