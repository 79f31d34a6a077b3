// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_findings/leak_findings.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "leak_findings_implementation.hpp"
#include "pipe_strips.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::leak_findings {
namespace {

/// Below this there is nothing to follow any more.
constexpr double kLeastLogOdds = -5.0;
/// Of the way to the temperature of a frame's sound pipe.
constexpr double kSoundGain = 0.05;
/// As often as wide as the spread of the sound pipe so far, that of a frame may be.
constexpr double kWiderSpread = 2;

double probability(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

InputFault check(const FramePose& pose) {
  if (!pose.T_map_base.matrix().allFinite() || !pose.covariance.allFinite()) {
    return InputFault::kBadPose;
  }
  const double scale = pose.covariance.diagonal().cwiseAbs().maxCoeff();
  if ((pose.covariance - pose.covariance.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale ||
      !(pose.covariance.diagonal().minCoeff() >= 0)) {
    return InputFault::kBadCovariance;
  }
  const Eigen::LDLT<geometry::Matrix6d> factors(pose.covariance);
  return factors.vectorD().minCoeff() < -1e-9 * scale ? InputFault::kBadCovariance
                                                      : InputFault::kNone;
}

bool finite(const Finding& f) {
  const bool placed =
      !f.position || (f.position->point.allFinite() && f.position->covariance.allFinite() &&
                      f.position->direction.allFinite());
  return placed && std::isfinite(f.probability) && std::isfinite(f.first_time) &&
         std::isfinite(f.last_time) && !std::isinf(f.mean_delta);
}

/// Of the place on a line that is nearest to the camera, m along its axis.
double depth(const PipeLine& line, const geometry::SE3& T_map_camera) {
  const Eigen::Vector3d along = (line.to - line.from).normalized();
  const Eigen::Vector3d nearest =
      line.from + along * along.dot(T_map_camera.translation() - line.from);
  return (T_map_camera.inverse() * nearest).z();
}

}  // namespace

std::optional<Eye> LeakFindings::Implementation::eye_of(const Frame& frame) {
  if (!frame.pose) {
    result.fault = InputFault::kNoPose;
    return std::nullopt;
  }
  result.fault = check(*frame.pose);
  const geometry::SE3& T_base_camera = frame.T_base_camera.value_or(p.T_base_camera);
  if (result.fault == InputFault::kNone && !T_base_camera.matrix().allFinite()) {
    result.fault = InputFault::kBadPose;
  }
  if (result.fault != InputFault::kNone) {
    return std::nullopt;
  }
  return Eye{frame.pose->T_map_base * T_base_camera, frame.pose->T_map_base.translation(),
             frame.pose->covariance};
}

void LeakFindings::Implementation::update(const Frame& frame,
                                          const thermal::Detections& detections) {
  result.fault = InputFault::kNone;
  result.events.clear();
  result.finding_of.assign(detections.leaks.size(), 0);
  ++counters.frames;
  const auto leave_out = [this](InputFault fault) {
    result.fault = fault;
    ++counters.faults[static_cast<std::size_t>(fault)];
  };
  if (!std::isfinite(frame.time) || frame.time <= last_time) {
    return leave_out(InputFault::kBadTime);
  }
  last_time = frame.time;
  if (detections.fault != thermal::FrameFault::kNone) {
    return leave_out(InputFault::kNoDetections);
  }
  if (detections.width != camera.parameters().width ||
      detections.height != camera.parameters().height) {
    return leave_out(InputFault::kBadSize);
  }
  const std::optional<Eye> eye = eye_of(frame);
  pose_time = eye ? frame.time : pose_time;
  ++counters.faults[static_cast<std::size_t>(result.fault)];
  learn_sound_pipe(frame.time, detections);
  counters.off_lines += observer.observe(frame.time, eye, detections, observations);
  assign(frame, eye);
  if (eye) {
    keep_next_eye(frame, *eye);
  }
  const double gain = std::log((1 - p.detection_probability) / (1 - p.clutter_probability));
  const auto look = [&](Follow& follow) {
    // A leak that this pass has shown is not gone within it: what hides it now, where it is looked
    // at askance or is cut by the border, hides it in the next pictures too. Another pass tells.
    const bool shown =
        follow.finding.state == FindingState::kRaised && follow.in_pass(frame.time, p);
    if (!follow.taken && !shown && seen_sound(follow, frame, eye, detections)) {
      follow.log_odds = std::max(follow.log_odds + gain, -kMostLogOdds);
    }
    follow.finding.probability = probability(follow.log_odds);
  };
  std::for_each(followed.begin(), followed.end(), look);
  std::for_each(candidates.begin(), candidates.end(), look);
  judge(frame);
}

void LeakFindings::Implementation::keep_next_eye(const Frame& frame, const Eye& eye) {
  for (std::vector<Follow>* all : {&followed, &candidates}) {
    for (Follow& follow : *all) {
      if (follow.place().empty() && !follow.finding.position && !follow.next_eye) {
        follow.next_eye = eye;
        follow.next_eye_time = frame.time;
      }
    }
  }
}

/// Whether what was seen without a pose is a leak that was seen later, with one: that leak was
/// there in the image, as the first pose soon after tells.
bool LeakFindings::Implementation::seen_before_its_place(const Follow& placed,
                                                         const Follow& without) const {
  if (!placed.finding.position || without.finding.position || !without.next_eye ||
      without.next_eye_time - without.finding.last_time > kPictureMemory ||
      placed.finding.first_time <= without.finding.last_time) {
    return false;
  }
  const MapPosition& position = *placed.finding.position;
  const double length = std::isfinite(placed.finding.length) ? placed.finding.length : 0;
  const geometry::SE3 T_camera_map = without.next_eye->T_map_camera.inverse();
  const auto end = [&](double side) {
    return camera.project(T_camera_map *
                          (position.point + 0.5 * side * length * position.direction));
  };
  const auto one = end(-1);
  const auto other = end(1);
  if (!one || !other) {
    return false;
  }
  const Eigen::Vector2d pixel = without.pixel_at(without.next_eye_time);
  const Eigen::Vector2d along = *other - *one;
  const double squared = along.squaredNorm();
  const double share = squared > 0 ? std::clamp(along.dot(pixel - *one) / squared, 0.0, 1.0) : 0.0;
  return (*one + share * along - pixel).norm() <= kFirstStep * camera.parameters().width;
}

/// Whether two are one leak in two pieces: what was seen of them touches, and they are as far away.
/// In one pass, what is common to both does not tell them apart.
bool LeakFindings::Implementation::same_leak(const Follow& a, const Follow& b, double time) const {
  if (!a.finding.position || !b.finding.position) {
    return false;
  }
  const bool together =
      a.in_pass(time, p) && b.in_pass(time, p) && !a.place().empty() && !b.place().empty();
  Eigen::Vector3d apart = a.finding.position->point - b.finding.position->point;
  Eigen::Matrix3d covariance = a.finding.position->covariance + b.finding.position->covariance;
  double reach = p.extent_slack;
  if (together) {
    apart = a.place().point() - b.place().point();
    covariance = a.place().relative_covariance() + b.place().relative_covariance();
    const Extent one = a.extent();
    const Extent other = b.extent();
    // From the middles of what was seen of them.
    const double first = 0.5 * (one.low + one.high);
    const double second = 0.5 * (other.low + other.high) * other.along.dot(one.along) +
                          one.along.dot(other.origin - one.origin);
    apart += (first - second - one.along.dot(apart)) * one.along;
    reach += 0.5 * (one.high - one.low + other.high - other.low);
  } else {
    reach += 0.5 * ((std::isfinite(a.finding.length) ? a.finding.length : 0) +
                    (std::isfinite(b.finding.length) ? b.finding.length : 0));
  }
  const Eigen::Vector3d& direction = b.finding.position->direction;
  const double along = direction.dot(apart);
  apart -= std::clamp(along, -reach, reach) * direction;
  covariance += 1e-6 * Eigen::Matrix3d::Identity();
  return apart.dot(covariance.ldlt().solve(apart)) <= p.gate * p.gate;
}

/// A picture without a pose, between others that have one, may show a leak that is known: only its
/// place tells, which comes with the next pose.
bool LeakFindings::Implementation::awaits_place(const Follow& candidate, double time) const {
  const bool has_all = candidate.taken && pose_time == time;
  return candidate.place().empty() && !has_all && time - pose_time <= kPictureMemory &&
         time - candidate.finding.last_time <= kPictureMemory;
}

/// Whether a candidate without a place is not seen in this picture, but a finding where it would
/// be, or is a finding that was seen later.
bool LeakFindings::Implementation::is_known(const Follow& candidate, double time) const {
  const Eigen::Vector2d pixel = candidate.pixel_at(time);
  const double reach = kNextStep * camera.parameters().width;
  return candidate.place().empty() && !candidate.taken &&
         std::any_of(followed.begin(), followed.end(), [&](const Follow& follow) {
           return (follow.taken && (follow.pixel() - pixel).norm() <= reach) ||
                  seen_before_its_place(follow, candidate);
         });
}

void LeakFindings::Implementation::judge(const Frame& frame) {
  const double time = frame.time;
  const double raise_at = logit(p.raise_probability);
  for (std::size_t i = 0; i < candidates.size();) {
    Follow& candidate = candidates[i];
    const bool known = is_known(candidate, time);
    const bool raised = candidate.log_odds >= raise_at && !known && !awaits_place(candidate, time);
    if (raised) {
      raise(candidate, frame);
    }
    const bool lost = known || candidate.log_odds < kLeastLogOdds || !candidate.in_pass(time, p);
    counters.candidates_dropped += lost && !raised ? 1U : 0U;
    if (raised || lost) {
      candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
  for (std::size_t i = 0; i < followed.size(); ++i) {
    Follow& follow = followed[i];
    Finding& finding = follow.finding;
    if (finding.state == FindingState::kRaised && finding.probability < p.clear_probability) {
      finding.state = FindingState::kCleared;
      tell(follow, EventKind::kCleared, time);
    } else if (finding.state == FindingState::kCleared && follow.taken &&
               finding.probability >= p.raise_probability) {
      finding.state = FindingState::kRaised;
      tell(follow, EventKind::kRaised, time);
    } else if (finding.state == FindingState::kRaised && follow.news &&
               time - follow.event_time >= p.update_interval) {
      tell(follow, EventKind::kUpdated, time);
    }
    if (follow.taken || finding.probability != findings[i].probability) {
      findings[i] = finding;
    }
  }
}

void LeakFindings::Implementation::raise(Follow& candidate, const Frame& frame) {
  std::size_t which = followed.size();
  for (std::size_t i = 0; i < followed.size() && which == followed.size(); ++i) {
    if (same_leak(candidate, followed[i], frame.time) ||
        (followed[i].in_pass(frame.time, p) && seen_before_its_place(candidate, followed[i]))) {
      which = i;
      followed[i].absorb(candidate, p);
      followed[i].taken = true;
      followed[i].finding.probability = probability(followed[i].log_odds);
    }
  }
  if (which == followed.size()) {
    if (followed.size() >= p.max_findings) {
      ++counters.findings_refused;
      return;
    }
    candidate.finding.id = next_id++;
    candidate.log_odds = std::min(candidate.log_odds, kMostLogOdds);
    candidate.finding.state = FindingState::kRaised;
    followed.push_back(candidate);
    findings.push_back(candidate.finding);
    tell(followed.back(), EventKind::kRaised, frame.time);
  }
  for (const Observation& o : observations) {
    if ((o.centre() - candidate.pixel()).norm() < 1e-9) {
      for (std::size_t k = o.first_detection; k <= o.last_detection; ++k) {
        result.finding_of[k] = followed[which].finding.id;
      }
    }
  }
}

void LeakFindings::Implementation::tell(Follow& follow, EventKind kind, double time) {
  result.events.push_back({kind, follow.finding.id});
  follow.event_time = time;
  follow.news = false;
}

/// By the main pipe; a pipe that leaks all along does not teach, since it has the reference that
/// was given. Pictures of another drive say nothing of how warm a sound pipe is.
void LeakFindings::Implementation::learn_sound_pipe(double time,
                                                    const thermal::Detections& detections) {
  const thermal::PipeSection* const main = detections.main_pipe();
  if (main == nullptr || !std::isfinite(main->reference_temperature)) {
    return;
  }
  const thermal::PipeSection& pipe = *main;
  const thermal::SoundPipe seen{.temperature = pipe.reference_temperature,
                                .direction = (pipe.end - pipe.start).normalized(),
                                .spread = pipe.spread};
  if (sound && time - sound_time <= p.pass_gap && sound->may_be(seen.direction)) {
    sound->temperature += kSoundGain * (seen.temperature - sound->temperature);
    // Not by a leak that widens it.
    const double spread = std::min(pipe.spread, kWiderSpread * *sound->spread);
    *sound->spread += kSoundGain * (spread - *sound->spread);
    sound->direction = seen.direction;
  } else {
    sound = seen;
  }
  sound_time = time;
}

thermal::FrameConditions LeakFindings::Implementation::conditions(const Frame& frame) const {
  thermal::FrameConditions told;
  const bool in_rack = std::any_of(p.lines.begin(), p.lines.end(),
                                   [](const PipeLine& line) { return line.radius > 0; });
  if (!in_rack && std::abs(frame.time - sound_time) <= p.pass_gap) {
    told.sound = sound;
  }
  const double focal = camera.parameters().focal_length;
  if (p.range_source == RangeSource::kDistance) {
    told.metres_per_pixel = p.distance / focal;
  } else if (p.range_source == RangeSource::kLine && frame.pose &&
             check(*frame.pose) == InputFault::kNone) {
    const geometry::SE3 T_map_camera =
        frame.pose->T_map_base * frame.T_base_camera.value_or(p.T_base_camera);
    double nearest = std::numeric_limits<double>::infinity();
    for (const PipeLine& line : p.lines) {
      const double ahead = depth(line, T_map_camera);
      nearest = ahead > 0 ? std::min(nearest, ahead) : nearest;
    }
    told.metres_per_pixel = std::isfinite(nearest) ? nearest / focal : 0;
    told.strips = pipe_strips(p.lines, camera, T_map_camera);
  }
  return told;
}

LeakFindings::LeakFindings(const LeakFindingsParameters& parameters, const geometry::Camera& camera)
    : implementation_(std::make_unique<Implementation>(parameters, camera)) {}
LeakFindings::~LeakFindings() = default;
LeakFindings::LeakFindings(LeakFindings&& other) noexcept = default;
LeakFindings& LeakFindings::operator=(LeakFindings&& other) noexcept = default;

std::size_t LeakFindings::restore(std::span<const Finding> stored) {
  Implementation& i = *implementation_;
  std::size_t taken = 0;
  for (const Finding& finding : stored) {
    const bool known = std::any_of(i.followed.begin(), i.followed.end(), [&](const Follow& follow) {
      return follow.finding.id == finding.id;
    });
    if (finding.state == FindingState::kCandidate || finding.id == 0 || known || !finite(finding) ||
        i.followed.size() >= i.p.max_findings) {
      continue;
    }
    Follow& follow = i.followed.emplace_back();
    follow.finding = finding;
    follow.log_odds = std::clamp(logit(std::clamp(finding.probability, 1e-6, 1 - 1e-6)),
                                 -kMostLogOdds, kMostLogOdds);
    i.next_id = std::max(i.next_id, finding.id + 1);
    ++taken;
  }
  std::sort(i.followed.begin(), i.followed.end(),
            [](const Follow& a, const Follow& b) { return a.finding.id < b.finding.id; });
  i.findings.clear();
  for (const Follow& follow : i.followed) {
    i.findings.push_back(follow.finding);
  }
  return taken;
}

void LeakFindings::set_lines(std::span<const PipeLine> lines) {
  LeakFindingsParameters& p = implementation_->p;
  if (lines.size() != p.lines.size()) {
    validation::refuse("lines: ", lines.size(), " pipes: must be ", p.lines.size(), " as before");
  }
  LeakFindingsParameters changed = p;
  changed.lines.assign(lines.begin(), lines.end());
  changed.validate();
  p.lines.assign(lines.begin(), lines.end());
}

const FrameResult& LeakFindings::update(const Frame& frame, const thermal::Detections& detections) {
  implementation_->update(frame, detections);
  return implementation_->result;
}

std::span<const Finding> LeakFindings::findings() const noexcept {
  return implementation_->findings;
}

const Finding* LeakFindings::find(std::uint64_t id) const noexcept {
  const auto& all = implementation_->findings;
  const auto found =
      std::lower_bound(all.begin(), all.end(), id,
                       [](const Finding& f, std::uint64_t value) { return f.id < value; });
  return found != all.end() && found->id == id ? &*found : nullptr;
}

std::vector<Finding> LeakFindings::candidates() const {
  std::vector<Finding> all;
  for (const Follow& candidate : implementation_->candidates) {
    all.push_back(candidate.finding);
  }
  return all;
}

thermal::FrameConditions LeakFindings::conditions(const Frame& frame) const {
  return implementation_->conditions(frame);
}

const LeakFindings::Counters& LeakFindings::counters() const noexcept {
  return implementation_->counters;
}

}  // namespace pipescout::leak_findings
