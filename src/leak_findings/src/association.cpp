// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "leak_findings_implementation.hpp"

namespace pipescout::leak_findings {
namespace {

/// Shares of the picture's width that a leak moves between frames at most, before and after it is
/// known how it moves.
constexpr double kFirstStep = 0.1;
constexpr double kNextStep = 0.04;
/// s: a picture as old says nothing of where a leak is in this one.
constexpr double kPictureMemory = 1.0;
/// Nothing is looked for at a larger angle from where it is expected: the cosine.
constexpr double kLeastCosine = 0.9;

}  // namespace

/// How far an observation is from where a leak is expected: in the map when both have a place
/// there, and else in the picture.
std::optional<Match> LeakFindings::Implementation::match(const Follow& follow, const Observation& o,
                                                         const Frame& frame,
                                                         const std::optional<Eye>& eye) const {
  const bool in_pass = follow.in_pass(frame.time, p);
  const bool placed = in_pass && !follow.place().empty();
  if (o.bearing && (placed || (!in_pass && follow.finding.position))) {
    const Eigen::Vector3d point = placed ? follow.place().point() : follow.finding.position->point;
    const Eigen::Vector3d to_point = point - o.bearing->eye;
    if (to_point.dot(o.bearing->ray) < kLeastCosine * to_point.norm()) {
      return std::nullopt;
    }
    Eigen::Matrix3d covariance;
    if (placed) {
      covariance = follow.place().relative_covariance();
    } else {
      covariance = follow.finding.position->covariance +
                   pose_part(point, eye->base, eye->covariance) +
                   mounting_part(point, o.bearing->eye, p.mounting_attitude_deviation,
                                 p.mounting_position_deviation);
    }
    const Miss m = miss(*o.bearing, point, covariance);
    const double distance = m.offset.dot(m.covariance.ldlt().solve(m.offset));
    if (!(distance <= p.gate * p.gate)) {
      return std::nullopt;
    }
    // Clutter is anywhere within the gate, a leak at its place.
    const double along = m.offset.x() * m.offset.x() / m.covariance(0, 0);
    const double motion = placed && o.whole
                              ? std::log(2 * p.gate / std::sqrt(2 * std::numbers::pi)) - 0.5 * along
                              : 0.0;
    return Match{distance, std::min(motion, 0.5)};
  }
  if (!in_pass || frame.time - follow.finding.last_time > kPictureMemory) {
    return std::nullopt;
  }
  const double reach =
      (follow.has_velocity() ? kNextStep : kFirstStep) * camera.parameters().width +
      (o.whole ? 0 : 0.5 * o.pixels());
  const double share = (o.centre() - follow.pixel_at(frame.time)).norm() / reach;
  return share <= 1 ? std::optional(Match{share * share * p.gate * p.gate, 0.0}) : std::nullopt;
}

/// The nearest pairs first. What is left over, and near nothing, begins as a candidate.
void LeakFindings::Implementation::assign(const Frame& frame, const std::optional<Eye>& eye) {
  used.assign(observations.size(), 0);
  for (std::vector<Follow>* all : {&followed, &candidates}) {
    for (Follow& follow : *all) {
      follow.taken = false;
    }
  }
  // Findings before candidates: what is known explains first.
  for (std::vector<Follow>* all : {&followed, &candidates}) {
    while (true) {
      Follow* best = nullptr;
      std::size_t which = 0;
      Match nearest{std::numeric_limits<double>::infinity(), 0};
      for (std::size_t i = 0; i < observations.size(); ++i) {
        if (used[i] != 0) {
          continue;
        }
        for (Follow& follow : *all) {
          if (follow.taken) {
            continue;
          }
          const auto found = match(follow, observations[i], frame, eye);
          if (found && found->distance < nearest.distance) {
            nearest = *found;
            best = &follow;
            which = i;
          }
        }
      }
      if (best == nullptr) {
        break;
      }
      take(*best, which, nearest, frame, eye);
    }
  }
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (used[i] != 0) {
      continue;
    }
    // A second look at what has been seen, by a piece of the same pipe.
    const auto known = [&](const Follow& follow) {
      return follow.taken && (follow.pixel() - observations[i].centre()).norm() <=
                                 observations[i].half_width + 0.5 * observations[i].pixels();
    };
    const auto finding = std::find_if(followed.begin(), followed.end(), known);
    if (finding != followed.end()) {
      for (std::size_t k = observations[i].first_detection; k <= observations[i].last_detection;
           ++k) {
        result.finding_of[k] = finding->finding.id;
      }
    } else if (std::none_of(candidates.begin(), candidates.end(), known)) {
      start_candidate(i, frame, eye);
    }
  }
}

void LeakFindings::Implementation::take(Follow& follow, std::size_t observation, const Match& match,
                                        const Frame& frame, const std::optional<Eye>& eye) {
  const Observation& o = observations[observation];
  follow.log_odds = std::min(
      follow.log_odds +
          std::max(std::log(p.detection_probability / p.clutter_probability) + match.motion, -4.0),
      kMostLogOdds);
  follow.add(frame, o, eye, observer, camera, p);
  follow.taken = true;
  used[observation] = 1;
  for (std::size_t k = o.first_detection; k <= o.last_detection; ++k) {
    result.finding_of[k] = follow.finding.id;
  }
}

void LeakFindings::Implementation::start_candidate(std::size_t observation, const Frame& frame,
                                                   const std::optional<Eye>& eye) {
  if (candidates.size() >= p.max_candidates) {
    const auto least =
        std::min_element(candidates.begin(), candidates.end(),
                         [](const Follow& a, const Follow& b) { return a.log_odds < b.log_odds; });
    candidates.erase(least);
    ++counters.candidates_dropped;
  }
  Follow& candidate = candidates.emplace_back();
  candidate.log_odds = logit(p.prior_probability);
  take(candidate, observation, Match{}, frame, eye);
}

/// Whether the pipe is seen, sound, all the way where the leak may be.
bool LeakFindings::Implementation::seen_sound(const Follow& follow, const Frame& frame,
                                              const std::optional<Eye>& eye,
                                              const thermal::Detections& d) const {
  const bool in_pass = follow.in_pass(frame.time, p);
  Eigen::Vector2d pixel = follow.pixel_at(frame.time);
  double slack = 2;
  if (eye && ((in_pass && !follow.place().empty()) || follow.finding.position)) {
    const bool placed = in_pass && !follow.place().empty();
    const Eigen::Vector3d point = placed ? follow.place().point() : follow.finding.position->point;
    const Eigen::Vector3d in_camera = eye->T_map_camera.inverse() * point;
    const auto projected = camera.project(in_camera);
    if (!projected || !camera.contains(*projected)) {
      return false;
    }
    pixel = *projected;
    const Eigen::Matrix3d covariance =
        placed ? follow.place().relative_covariance()
               : Eigen::Matrix3d(follow.finding.position->covariance +
                                 pose_part(point, eye->base, eye->covariance));
    slack += p.gate * std::sqrt(covariance.diagonal().maxCoeff()) *
             camera.parameters().focal_length / in_camera.z();
  } else if (!in_pass || frame.time - follow.finding.last_time > kPictureMemory ||
             !follow.has_velocity() || !camera.contains(pixel)) {
    return false;
  } else {
    slack += kNextStep * camera.parameters().width;
  }
  for (const thermal::PipeSection& pipe : d.pipes) {
    const Eigen::Vector2d direction = (pipe.end - pipe.start).normalized();
    const Eigen::Vector2d from_start = pixel - pipe.start;
    const double across = std::abs(direction.x() * from_start.y() - direction.y() * from_start.x());
    const double along = direction.dot(from_start);
    if (across > slack + pipe.half_width || along - slack < 0 || along + slack > pipe.length()) {
      continue;
    }
    const auto parts = d.parts_of(pipe);
    return std::all_of(parts.begin(), parts.end(), [&](const thermal::PipePart& part) {
      return part.to - 0.5 <= along - slack || part.from - 0.5 >= along + slack ||
             part.kind == thermal::PartKind::kPipe || part.kind == thermal::PartKind::kShort;
    });
  }
  return false;
}

}  // namespace pipescout::leak_findings
