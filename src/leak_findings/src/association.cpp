// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "leak_findings_implementation.hpp"

namespace pipescout::leak_findings {
namespace {

/// Detections that count before something is raised: what mirrors or shines stays as long as a
/// leak, and then only where it is tells them apart.
constexpr double kMostPersistence = 3.25;
/// Evidence of a frame below which something is no longer where it was.
constexpr double kJump = -3.0;
/// Cosine of the angle in the image between a pipe and a section of it, at least.
constexpr double kSamePipe = 0.9;
/// Nothing is looked for at a larger angle from where it is expected: the cosine.
constexpr double kLeastCosine = 0.9;

}  // namespace

/// How far an observation is from where a leak is expected: in the map when both have a place
/// there, and else in the picture.
std::optional<Match> LeakFindings::Implementation::match(const Follow& follow, const Observation& o,
                                                         const Frame& frame,
                                                         const std::optional<Eye>& eye) const {
  const bool in_pass = follow.in_pass(frame.time, p);
  if (o.bearing && in_pass && !follow.place().empty()) {
    return match_in_pass(follow, o);
  }
  if (o.bearing && !in_pass && follow.finding.position) {
    return match_other_pass(follow.finding, o, *eye);
  }
  if (!in_pass || frame.time - follow.finding.last_time > kPictureMemory) {
    return std::nullopt;
  }
  const double reach =
      (follow.has_velocity() ? kNextStep : kFirstStep) * camera.parameters().width +
      (o.whole() ? 0 : 0.5 * o.pixels());
  const double share = (o.centre() - follow.pixel_at(frame.time)).norm() / reach;
  return share <= 1 ? std::optional(Match{share * share * p.gate * p.gate, 0.0}) : std::nullopt;
}

/// By an end that was seen before, and else by what is seen of the leak being in one piece with
/// what was.
std::optional<Match> LeakFindings::Implementation::match_in_pass(const Follow& follow,
                                                                 const Observation& o) const {
  const Bearing& b = *o.bearing;
  const Eigen::Vector3d point = follow.place().point();
  const Extent extent = follow.extent();
  const double middle = place_on_line(b.eye, b.ray, extent.origin, extent.along);
  // What was seen of a long leak first may have gone out of view.
  const Eigen::Vector3d expected =
      std::isfinite(middle)
          ? extent.origin + std::clamp(middle, extent.low, extent.high) * extent.along
          : point;
  const Eigen::Vector3d to_expected = expected - b.eye;
  const double range = to_expected.norm();
  if (to_expected.dot(b.ray) < kLeastCosine * range) {
    return std::nullopt;
  }
  const Miss m = miss(b, point, follow.place().relative_covariance());
  const double across = m.offset.y() * m.offset.y() / m.covariance(1, 1);
  const bool turned = o.direction.dot(extent.along) < 0;
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = 0;
  const auto squared_miss = [](const std::optional<Bearing>& seen, const PlaceEstimate& known) {
    if (!seen || known.empty()) {
      return std::numeric_limits<double>::infinity();
    }
    const Miss off = miss(*seen, known.point(), known.relative_covariance());
    return off.offset.x() * off.offset.x() / off.covariance(0, 0);
  };
  for (std::size_t k = 0; k < 2; ++k) {
    // Half-way up, an end moves inwards while more of a leak with soft shoulders comes into view;
    // where the rise begins, it moves with what is next to the leak.
    const std::size_t which = turned ? 1 - k : k;
    const double squared = std::min(squared_miss(o.ends[which], follow.end(k)),
                                    squared_miss(o.onsets[which], follow.onset(k)));
    if (std::isfinite(squared)) {
      nearest = std::min(nearest, squared);
      farthest = std::max(farthest, squared);
    }
  }
  const double half = 0.5 * range * o.angle;
  const double overlap = std::min(middle + half, extent.high) - std::max(middle - half, extent.low);
  double motion = 0;
  if (std::isfinite(nearest)) {
    // What a leak that stays where it is would show, against something that moves anyhow. What
    // moves along with the camera seems to be at another range than the pipe: that adds up here.
    // Both ends have to stay: what fades in as it moves keeps one of them.
    motion = 0.5 * (1 - farthest);
    // Of a leak that is known, more may come into view and change where its ends seem to be.
    if (follow.finding.id != 0 && overlap > std::min(half, 0.5 * (extent.high - extent.low))) {
      nearest = std::min(nearest, 1.0);
    }
  } else if (overlap >= -p.extent_slack) {
    nearest = 0;
  }
  const double distance = across + nearest;
  return distance <= p.gate * p.gate ? std::optional(Match{distance, motion}) : std::nullopt;
}

/// By its middle, which lengths that differ, or are not seen, may move.
std::optional<Match> LeakFindings::Implementation::match_other_pass(const Finding& finding,
                                                                    const Observation& o,
                                                                    const Eye& eye) const {
  const Bearing& b = *o.bearing;
  const MapPosition& known = *finding.position;
  const Eigen::Vector3d to_point = known.point - b.eye;
  const double range = to_point.norm();
  if (to_point.dot(b.ray) < kLeastCosine * range) {
    return std::nullopt;
  }
  const Eigen::Matrix3d covariance =
      known.covariance + pose_part(known.point, eye.base, eye.covariance) +
      mounting_part(known.point, b.eye, p.mounting_attitude_deviation,
                    p.mounting_position_deviation);
  Miss m = miss(b, known.point, covariance);
  const double seen = range * o.angle;
  const double length = std::isfinite(finding.length) ? finding.length : seen;
  const double slack = 0.5 * (o.whole() ? std::abs(length - seen) : length + seen);
  m.offset.x() = std::max(0.0, std::abs(m.offset.x()) - slack);
  const double distance = m.offset.x() * m.offset.x() / m.covariance(0, 0) +
                          m.offset.y() * m.offset.y() / m.covariance(1, 1);
  return distance <= p.gate * p.gate ? std::optional(Match{distance, 0.0}) : std::nullopt;
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
      take(*best, which, nearest, frame);
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
      start_candidate(i, frame);
    }
  }
}

void LeakFindings::Implementation::take(Follow& follow, std::size_t observation, const Match& match,
                                        const Frame& frame) {
  const Observation& o = observations[observation];
  const double gain = std::log(p.detection_probability / p.clutter_probability);
  if (follow.finding.id == 0) {
    const double persistence = std::min(gain, kMostPersistence * gain - follow.persistence);
    follow.persistence += persistence;
    follow.log_odds += persistence + match.motion;
    if (match.motion < kJump) {
      // An end has jumped, as those of a long leak do while it comes into view: from here on anew.
      follow.persistence = 0;
      follow.log_odds = std::min(follow.log_odds, logit(p.prior_probability));
      follow.log_odds = std::max(follow.log_odds, 2 * logit(p.prior_probability));
    }
  } else {
    follow.log_odds = std::min(follow.log_odds + gain, kMostLogOdds);
  }
  follow.add(frame, o, camera, p);
  follow.taken = true;
  used[observation] = 1;
  for (std::size_t k = o.first_detection; k <= o.last_detection; ++k) {
    result.finding_of[k] = follow.finding.id;
  }
}

void LeakFindings::Implementation::start_candidate(std::size_t observation, const Frame& frame) {
  if (candidates.size() >= p.max_candidates) {
    const auto least =
        std::min_element(candidates.begin(), candidates.end(),
                         [](const Follow& a, const Follow& b) { return a.log_odds < b.log_odds; });
    candidates.erase(least);
    ++counters.candidates_dropped;
  }
  Follow& candidate = candidates.emplace_back();
  candidate.log_odds = logit(p.prior_probability);
  take(candidate, observation, Match{}, frame);
}

/// Whether the pipe is seen, sound, all the way where the leak may be.
bool LeakFindings::Implementation::seen_sound(const Follow& follow, const Frame& frame,
                                              const std::optional<Eye>& eye,
                                              const thermal::Detections& d) const {
  const bool in_pass = follow.in_pass(frame.time, p);
  Eigen::Vector2d pixel = follow.pixel_at(frame.time);
  std::optional<Eigen::Vector2d> along_pipe;  // unit, in the image
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
    if (follow.finding.position) {
      constexpr double kAhead = 0.1;  // m
      const auto ahead = camera.project(eye->T_map_camera.inverse() *
                                        (point + kAhead * follow.finding.position->direction));
      if (ahead && *ahead != pixel) {
        along_pipe = (*ahead - pixel).normalized();
      }
    }
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
    if (along_pipe && std::abs(direction.dot(*along_pipe)) < kSamePipe) {
      continue;  // another one that crosses it, and may hide it
    }
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
