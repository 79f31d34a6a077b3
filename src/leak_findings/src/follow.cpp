// SPDX-License-Identifier: Apache-2.0
#include "follow.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "pipescout/statistics/normal.hpp"

namespace pipescout::leak_findings {
namespace {

constexpr double kHour = 3600.0;

/// `deviation`: of noise; `margins`: of what is alike in all frames, below and above.
Interval interval(double low, double high, double deviation,
                  const std::array<RunningMean, 2>& margins) {
  const double noise = statistics::kNormal95 * deviation;
  return {low - std::hypot(noise, margins[0].mean()), high + std::hypot(noise, margins[1].mean())};
}

/// rad: a bearing that tells nothing.
constexpr double kNothing = 1e3;

bool nearby(const PlaceEstimate& place, const Bearing& bearing, double gate) {
  const Miss off = miss(bearing, place.point(), place.relative_covariance());
  return off.offset.x() * off.offset.x() <= gate * gate * off.covariance(0, 0);
}

/// On the surface of a line with a radius, instead of inside of it. Rays that meet there are those
/// of a pipe that is warm all round, of which each image shows another side: the one that `ray`
/// shows is taken, against which the point is moved.
Eigen::Vector3d out_of(const PipeLine& line, const Eigen::Vector3d& point,
                       const Eigen::Vector3d& ray) {
  const Eigen::Vector3d along = (line.to - line.from).normalized();
  const Eigen::Vector3d from_axis = point - line.from - along * along.dot(point - line.from);
  const double inside = line.radius * line.radius - from_axis.squaredNorm();
  if (inside <= 0) {
    return point;
  }
  const Eigen::Vector3d back = (along * along.dot(ray) - ray).normalized();
  const double ahead = from_axis.dot(back);
  return point + (std::sqrt(ahead * ahead + inside) - ahead) * back;
}

double view_score(const Observation& o, const geometry::Camera& camera) {
  const double width = camera.parameters().width;
  const double height = camera.parameters().height;
  const Eigen::Vector2d from_centre = o.centre() - 0.5 * Eigen::Vector2d(width - 1, height - 1);
  const double eccentricity = from_centre.norm() / std::hypot(width, height);
  return (o.whole() ? 1.0 : 0.25) * o.pixels() * (1 - eccentricity);
}

}  // namespace

void Follow::begin_pass(double time, const LeakFindingsParameters& p) {
  frames_ = 0;
  past_ = finding.position;
  pass_ = Pass{};
  has_velocity_ = false;
  if (finding.passes.size() >= p.max_passes) {
    finding.passes.erase(finding.passes.begin());
  }
  finding.passes.push_back({});
  finding.passes.back().time = time;
  ++finding.pass_count;
}

void Follow::add(const Frame& frame, const Observation& o, const geometry::Camera& camera,
                 const LeakFindingsParameters& p) {
  if (!in_pass(frame.time, p)) {
    begin_pass(frame.time, p);
  }
  if (frames_ > 0) {
    velocity_ = (o.centre() - pixel_) / (frame.time - finding.last_time);
    has_velocity_ = true;
  }
  pixel_ = o.centre();
  next_eye.reset();
  if (finding.frames == 0) {
    finding.first_time = frame.time;
  }
  finding.last_time = frame.time;
  ++finding.frames;
  ++frames_;
  (o.whole() ? pass_.delta : pass_.partial_delta).add(o.delta);
  pass_.peak.add(o.peak_delta);
  pass_.delta_deviation.add(o.delta_deviation);
  for (std::size_t side = 0; side < 2; ++side) {
    pass_.delta_margins[side].add(o.delta_margins[side]);
    pass_.peak_delta_margins[side].add(o.peak_delta_margins[side]);
  }
  pass_.largest_peak = std::fmax(pass_.largest_peak, o.peak_delta);
  if (o.bearing) {
    add_places(o, p);
  }
  const double score = view_score(o, camera);
  if (finding.frames == 1 || score > finding.best.score) {
    finding.best = {frame.time, frame.number, o.start, o.end, o.half_width, score};
  }
  summarise(p);
  news = true;
}

void Follow::add_places(const Observation& o, const LeakFindingsParameters& p) {
  if (!pass_.place.empty()) {
    // The middle of what is seen of a leak that comes into view moves along with the camera.
    Bearing bearing = *o.bearing;
    bearing.along_deviation = o.whole() ? bearing.along_deviation : kNothing;
    pass_.place.add(bearing);
  } else if (o.range) {
    pass_.place.begin(*o.bearing, *o.range);
    pass_.line = o.line;
    pass_.anchor = pass_.place.point();
  } else {
    return;
  }
  const Bearing& b = *o.bearing;
  pass_.ray = b.ray;
  const bool turned = o.direction.dot(pass_.direction) < 0;
  pass_.direction += turned ? Eigen::Vector3d(-o.direction) : o.direction;
  const Eigen::Vector3d along = pass_.direction.normalized();
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t which = turned ? 1 - k : k;
    if (o.ends[which]) {
      add_on_pipe(pass_.ends[k], *o.ends[which], p.gate);
    }
    if (o.onsets[which]) {
      add_on_pipe(pass_.onsets[k], *o.onsets[which], p.gate);
    }
  }
  // Half of what is seen, at the range that is known by now.
  const double scale = (pass_.place.point() - b.eye).norm();
  const double middle = place_on_line(b.eye, b.ray, pass_.anchor, along);
  if (std::isfinite(middle)) {
    pass_.low = std::min(pass_.low, middle - 0.5 * scale * o.angle);
    pass_.high = std::max(pass_.high, middle + 0.5 * scale * o.angle);
  }
}

/// Begins anew with a bearing that is elsewhere: the warmer a leak turns out to be, the further in
/// its ends lie. It is as far as what has been seen of the leak so far.
void Follow::add_on_pipe(PlaceEstimate& place, const Bearing& bearing, double gate) const {
  if (!place.empty() && nearby(place, bearing, gate)) {
    place.add(bearing);
    return;
  }
  const Eigen::Vector3d middle = pass_.place.point();
  const Eigen::Vector3d along = pass_.direction.normalized();
  const double at = place_on_line(bearing.eye, bearing.ray, middle, along);
  if (std::isfinite(at)) {
    RangePrior prior;
    prior.point = middle + at * along;
    prior.range = (prior.point - bearing.eye).norm();
    const double variance = bearing.ray.dot(pass_.place.relative_covariance() * bearing.ray);
    prior.information = bearing.ray * bearing.ray.transpose() / variance;
    place.begin(bearing, prior);
  }
}

Extent Follow::extent() const {
  Extent e;
  e.origin = pass_.anchor;
  e.along = pass_.direction.normalized();
  e.low = pass_.low;
  e.high = pass_.high;
  for (std::size_t k = 0; k < 2; ++k) {
    const PlaceEstimate& end = pass_.ends[k];
    e.known[k] = !end.empty();
    if (e.known[k]) {
      e.end[k] = e.along.dot(end.point() - e.origin);
      e.variance[k] = e.along.dot(end.relative_covariance() * e.along);
    }
  }
  return e;
}

void Follow::summarise(const LeakFindingsParameters& p) {
  PassSummary& pass = finding.passes.back();
  pass.frames = frames_;
  const RunningMean& delta = pass_.delta.count() > 0 ? pass_.delta : pass_.partial_delta;
  pass.delta = delta.mean();
  pass.delta_deviation = std::hypot(delta.mean_deviation(), pass_.delta_deviation.mean());
  pass.peak_delta = pass_.largest_peak;
  finding.mean_delta = pass.delta;
  finding.mean_delta_interval =
      interval(pass.delta, pass.delta, delta.mean_deviation(), pass_.delta_margins);
  finding.peak_delta = pass_.largest_peak;
  // The largest of many is rather too large than too small.
  finding.peak_delta_interval = interval(pass_.peak.mean(), pass_.largest_peak,
                                         pass_.peak.mean_deviation(), pass_.peak_delta_margins);
  pass.length = std::numeric_limits<double>::quiet_NaN();
  pass.length_deviation = std::numeric_limits<double>::quiet_NaN();
  if (!pass_.place.empty()) {
    place_finding(pass, p);
  }
  finding.severity = p.severity.of(finding.mean_delta, finding.length);
  find_growth();
}

void Follow::place_finding(PassSummary& pass, const LeakFindingsParameters& p) {
  if (p.range_source == RangeSource::kNone) {
    const double variance = pass_.ray.dot(pass_.place.relative_covariance() * pass_.ray);
    if (std::sqrt(variance) > p.max_range_deviation) {
      return;
    }
  }
  const Extent extent = this->extent();
  MapPosition here;
  here.direction = extent.along;
  const Eigen::Matrix3d along = here.direction * here.direction.transpose();
  const double blur = p.extent_deviation * p.extent_deviation;
  if (extent.known[0] && extent.known[1]) {
    here.point = 0.5 * (pass_.ends[0].point() + pass_.ends[1].point());
    here.covariance =
        0.5 * (pass_.ends[0].relative_covariance() + pass_.ends[1].relative_covariance()) +
        blur * along;
    pass.length = extent.end[1] - extent.end[0];
    pass.length_deviation = std::sqrt(extent.variance[0] + extent.variance[1] + 2 * blur);
    finding.length = pass.length;
    finding.length_deviation = pass.length_deviation;
  } else {
    // Its middle is beyond what has been seen of it.
    const double hidden = p.hidden_length_deviation * p.hidden_length_deviation;
    const double middle = 0.5 * ((extent.known[0] ? extent.end[0] : extent.low) +
                                 (extent.known[1] ? extent.end[1] : extent.high));
    const Eigen::Vector3d seen = pass_.place.point();
    here.point = seen + (middle - here.direction.dot(seen - extent.origin)) * here.direction;
    here.covariance = pass_.place.relative_covariance() + (blur + hidden) * along;
  }
  here.covariance +=
      pass_.place.common_covariance(here.point, p.pose_correlation_time,
                                    p.mounting_attitude_deviation, p.mounting_position_deviation);
  if (pass_.line >= 0) {
    // The line is known in the map, whatever the pose.
    const PipeLine& line = p.lines[static_cast<std::size_t>(pass_.line)];
    const Eigen::Vector3d u = (line.to - line.from).normalized();
    Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
    Eigen::Vector3d on_line = line.from;
    if (line.radius > 0) {
      // Of its surface it is known how far from the axis, and not where around it.
      const Eigen::Vector3d outwards = (across * (here.point - line.from)).normalized();
      across = outwards * outwards.transpose();
      on_line += line.radius * outwards;
    }
    across /= p.line_deviation * p.line_deviation;
    const Eigen::Matrix3d information = here.covariance.ldlt().solve(Eigen::Matrix3d::Identity());
    const auto both = Eigen::Matrix3d(information + across).ldlt();
    here.point = both.solve(information * here.point + across * on_line);
    here.covariance = both.solve(Eigen::Matrix3d::Identity());
  }
  pass.position = here;
  finding.position = past_ ? fuse(*past_, here) : here;
  if (pass_.line >= 0) {
    const PipeLine& line = p.lines[static_cast<std::size_t>(pass_.line)];
    pass.position->point = out_of(line, pass.position->point, pass_.ray);
    finding.position->point = out_of(line, finding.position->point, pass_.ray);
  }
}

/// Least squares over the passes, each by how well it knows.
void Follow::find_growth() {
  const auto slope = [this](double PassSummary::*value, double PassSummary::*deviation) {
    double weights = 0;
    double times = 0;
    double values = 0;
    const double origin = finding.passes.front().time;
    for (const PassSummary& pass : finding.passes) {
      if (std::isfinite(pass.*value)) {
        const double w = 1 / std::max(1e-12, pass.*deviation * pass.*deviation);
        weights += w;
        times += w * (pass.time - origin);
        values += w * pass.*value;
      }
    }
    double spread = 0;
    double both = 0;
    for (const PassSummary& pass : finding.passes) {
      if (std::isfinite(pass.*value)) {
        const double w = 1 / std::max(1e-12, pass.*deviation * pass.*deviation);
        const double t = pass.time - origin - times / weights;
        spread += w * t * t;
        both += w * t * (pass.*value - values / weights);
      }
    }
    return spread > 0 ? kHour * both / spread : std::numeric_limits<double>::quiet_NaN();
  };
  if (finding.passes.size() > 1) {
    finding.delta_growth = slope(&PassSummary::delta, &PassSummary::delta_deviation);
    finding.length_growth = slope(&PassSummary::length, &PassSummary::length_deviation);
  }
}

void Follow::absorb(const Follow& other, const LeakFindingsParameters& p) {
  if (!in_pass(other.finding.last_time, p)) {
    // The other's pass becomes this one's.
    begin_pass(other.finding.first_time, p);
    frames_ = other.frames_;
    pass_ = other.pass_;
  } else if (pass_.place.empty()) {
    frames_ += other.frames_;
    pass_ = other.pass_;
  }
  pixel_ = other.pixel_;
  velocity_ = other.velocity_;
  has_velocity_ = other.has_velocity_;
  finding.last_time = std::max(finding.last_time, other.finding.last_time);
  finding.frames += other.finding.frames;
  if (other.finding.best.score > finding.best.score) {
    finding.best = other.finding.best;
  }
  log_odds = std::max(log_odds, other.log_odds);
  summarise(p);
  news = true;
}

}  // namespace pipescout::leak_findings
