// SPDX-License-Identifier: Apache-2.0
#include "follow.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace pipescout::leak_findings {
namespace {

constexpr double k95 = 1.96;  // standard deviations
constexpr double kHour = 3600.0;

Interval interval(double low, double high, double deviation) {
  return {low - k95 * deviation, high + k95 * deviation};
}

double view_score(const Observation& o, const geometry::Camera& camera) {
  const double width = camera.parameters().width;
  const double height = camera.parameters().height;
  const Eigen::Vector2d from_centre = o.centre() - 0.5 * Eigen::Vector2d(width - 1, height - 1);
  const double eccentricity = from_centre.norm() / std::hypot(width, height);
  return (o.whole ? 1.0 : 0.25) * o.pixels() * (1 - eccentricity);
}

}  // namespace

void Follow::begin_pass(double time, const LeakFindingsParameters& p) {
  frames_ = 0;
  past_ = finding.position;
  place_.clear();
  line_ = -1;
  direction_.setZero();
  has_velocity_ = false;
  delta_ = partial_delta_ = peak_ = length_ = RunningMean{};
  largest_peak_ = -std::numeric_limits<double>::infinity();
  if (finding.passes.size() >= p.max_passes) {
    finding.passes.erase(finding.passes.begin());
  }
  finding.passes.push_back({});
  finding.passes.back().time = time;
  ++finding.pass_count;
}

void Follow::add(const Frame& frame, const Observation& o, const std::optional<Eye>& eye,
                 const Observer& observer, const geometry::Camera& camera,
                 const LeakFindingsParameters& p) {
  if (!in_pass(frame.time, p)) {
    begin_pass(frame.time, p);
  }
  if (frames_ > 0) {
    velocity_ = (o.centre() - pixel_) / (frame.time - finding.last_time);
    has_velocity_ = true;
  }
  pixel_ = o.centre();
  if (finding.frames == 0) {
    finding.first_time = frame.time;
  }
  finding.last_time = frame.time;
  ++finding.frames;
  ++frames_;
  (o.whole ? delta_ : partial_delta_).add(o.delta);
  peak_.add(o.peak_delta);
  largest_peak_ = std::max(largest_peak_, o.peak_delta);
  if (o.bearing) {
    if (!place_.empty()) {
      place_.add(*o.bearing);
    } else if (o.range) {
      place_.begin(*o.bearing, *o.range);
      line_ = o.line;
    }
    ray_ = o.bearing->ray;
  }
  if (eye && !place_.empty()) {
    Eigen::Vector3d direction = observer.direction(o, *eye);
    if (direction.dot(direction_) < 0) {
      direction = -direction;
    }
    direction_ += direction;
    if (o.whole) {
      const double length = observer.length(o, *eye, place_.point());
      if (std::isfinite(length)) {
        length_.add(length);
      }
    }
  }
  const double score = view_score(o, camera);
  if (finding.frames == 1 || score > finding.best.score) {
    finding.best = {frame.time, frame.number, o.start, o.end, o.half_width, score};
  }
  summarise(p);
  news = true;
}

void Follow::summarise(const LeakFindingsParameters& p) {
  PassSummary& pass = finding.passes.back();
  pass.frames = frames_;
  const RunningMean& delta = delta_.count() > 0 ? delta_ : partial_delta_;
  pass.delta = delta.mean();
  pass.delta_deviation = std::hypot(delta.mean_deviation(), p.delta_deviation);
  pass.peak_delta = largest_peak_;
  pass.length = length_.mean();
  pass.length_deviation = std::hypot(length_.mean_deviation(), p.extent_deviation);
  finding.mean_delta = pass.delta;
  finding.mean_delta_interval = interval(pass.delta, pass.delta, pass.delta_deviation);
  finding.peak_delta = largest_peak_;
  // The largest of many is rather too large than too small.
  finding.peak_delta_interval =
      interval(peak_.mean(), largest_peak_, std::hypot(peak_.mean_deviation(), p.delta_deviation));
  if (length_.count() > 0) {
    finding.length = pass.length;
    finding.length_deviation = pass.length_deviation;
  }
  finding.severity = p.severity.of(finding.mean_delta, finding.length);
  if (!place_.empty()) {
    place_finding(pass, p);
  }
  find_growth();
}

void Follow::place_finding(PassSummary& pass, const LeakFindingsParameters& p) {
  if (p.range_source == RangeSource::kNone) {
    const Eigen::Matrix3d relative = place_.relative_covariance();
    if (std::sqrt(ray_.dot(relative * ray_)) > p.max_range_deviation) {
      return;
    }
  }
  MapPosition here;
  here.direction = direction_.normalized();
  const Eigen::Matrix3d along = here.direction * here.direction.transpose();
  here.point = place_.point();
  here.covariance = place_.covariance(p.pose_correlation_time, p.mounting_attitude_deviation,
                                      p.mounting_position_deviation) +
                    p.extent_deviation * p.extent_deviation * along;
  if (line_ >= 0) {
    // The line is known in the map, whatever the pose.
    const PipeLine& line = p.lines[static_cast<std::size_t>(line_)];
    const Eigen::Matrix3d across =
        (Eigen::Matrix3d::Identity() - along) / (p.line_deviation * p.line_deviation);
    const Eigen::Matrix3d information = here.covariance.ldlt().solve(Eigen::Matrix3d::Identity());
    const auto both = Eigen::Matrix3d(information + across).ldlt();
    here.point = both.solve(information * here.point + across * line.from);
    here.covariance = both.solve(Eigen::Matrix3d::Identity());
  }
  pass.position = here;
  finding.position = past_ ? fuse(*past_, here) : here;
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
    place_ = other.place_;
    line_ = other.line_;
    direction_ = other.direction_;
    ray_ = other.ray_;
    delta_ = other.delta_;
    partial_delta_ = other.partial_delta_;
    peak_ = other.peak_;
    largest_peak_ = other.largest_peak_;
    length_ = other.length_;
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
