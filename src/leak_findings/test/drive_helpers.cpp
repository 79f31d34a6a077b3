// SPDX-License-Identifier: Apache-2.0
#include "drive_helpers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::leak_findings::test {
namespace {

constexpr double kReference = 150.0;

geometry::SE3 T_map_base(double x) {
  return geometry::SE3(geometry::SO3{}, {x, 0, 0});
}

}  // namespace

const geometry::Camera& Drive::camera() {
  static const geometry::Camera all = [] {
    geometry::CameraParameters p;
    p.width = 320;
    p.height = 240;
    p.focal_length = 722;
    p.centre_u = 159.5;
    p.centre_v = 119.5;
    return geometry::Camera(p);
  }();
  return all;
}

/// To the left, and up to the pipe.
geometry::SE3 Drive::T_base_camera() {
  Eigen::Matrix3d axes;
  axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const double elevation = std::atan2(kHeight - 1, kRange);
  return geometry::SE3(
      geometry::SO3::from_matrix(axes) * geometry::SO3::exp(Eigen::Vector3d(elevation, 0, 0)),
      {0, 0, 1});
}

LeakFindingsParameters Drive::parameters() {
  LeakFindingsParameters p;
  p.T_base_camera = T_base_camera();
  p.range_source = RangeSource::kDiameter;
  p.pipe_diameter = kDiameter;
  p.mounting_attitude_deviation = 0;
  p.mounting_position_deviation = 0;
  return p;
}

double Drive::normal(double deviation) {
  return std::normal_distribution<double>(0, 1)(engine_) * deviation;
}

Frame Drive::frame(double time, double x) {
  Frame frame;
  frame.time = time;
  frame.number = number_++;
  FramePose pose;
  const geometry::SE3 truth = T_map_base(x);
  pose.T_map_base = geometry::SE3(geometry::SO3::exp(rotation_error) * truth.rotation(),
                                  truth.translation() + position_error);
  pose.covariance.diagonal().head<3>().setConstant(position_deviation * position_deviation);
  pose.covariance.diagonal().tail<3>().setConstant(rotation_deviation * rotation_deviation);
  frame.pose = pose;
  return frame;
}

thermal::Detections Drive::look(double x) {
  const geometry::SE3 T_camera_map = (T_map_base(x) * T_base_camera()).inverse();
  const auto u_of = [&](double place) {
    return camera().project(T_camera_map * on_pipe(place))->x();
  };
  const double v = camera().project(T_camera_map * on_pipe(x))->y();
  thermal::Detections d;
  d.width = 320;
  d.height = 240;
  d.threshold = 100;
  thermal::PipeSection pipe;
  pipe.start = {0, v};
  pipe.end = {319, v};
  pipe.half_width =
      0.5 * camera().parameters().focal_length * kDiameter / std::hypot(kRange, kHeight - 1);
  pipe.width = 2 * pipe.half_width * width_seen;
  pipe.cut_along = cut_along;
  pipe.visible = 1;
  pipe.reference_temperature = kReference;
  pipe.samples = 320;
  d.profile.assign(320, static_cast<float>(kReference));
  std::vector<thermal::PipePart> warm;
  for (const Spot& spot : spots) {
    const double place = spot.place + spot.follow * (x - spot.place);
    double from = u_of(place - 0.5 * spot.length) + 0.5 + normal(pixel_noise);
    double to = u_of(place + 0.5 * spot.length) + 0.5 + normal(pixel_noise);
    bool open_start = from < 0;
    bool open_end = to > 320;
    for (const Eigen::Vector2d& post : posts) {
      const double a = u_of(post.x()) + 0.5;
      const double b = u_of(post.y()) + 0.5;
      if (b > from && a < from) {
        from = b;
        open_start = true;
      }
      if (a < to && b > to) {
        to = a;
        open_end = true;
      }
    }
    from = std::max(from, 0.0);
    to = std::min(to, 320.0);
    if (to - from < 10) {
      continue;
    }
    thermal::LeakDetection leak;
    leak.delta = spot.delta + normal(delta_noise);
    leak.peak_delta = leak.delta + 5;
    leak.delta_deviation = delta_deviation;
    leak.peak_delta_deviation = delta_deviation;
    constexpr double kNotSeen = std::numeric_limits<double>::quiet_NaN();
    leak.stretch = {.from = from,
                    .to = to,
                    .onset_from = open_start ? kNotSeen : from,
                    .onset_to = open_end ? kNotSeen : to,
                    .mean = kReference + leak.delta,
                    .deviation = 1,
                    .peak = kReference + leak.peak_delta,
                    .open_at_start = open_start,
                    .open_at_end = open_end};
    leak.start = pipe.at(from - 0.5);
    leak.end = pipe.at(to - 0.5);
    leak.length = std::numeric_limits<double>::quiet_NaN();
    d.leaks.push_back(leak);
    warm.push_back({from, to, kReference + leak.delta, 1, kReference + leak.peak_delta,
                    thermal::PartKind::kLeak});
  }
  std::sort(warm.begin(), warm.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  std::sort(d.leaks.begin(), d.leaks.end(),
            [](const auto& a, const auto& b) { return a.start.x() < b.start.x(); });
  double at = 0;
  for (const thermal::PipePart& part : warm) {
    d.parts.push_back({at, part.from, kReference, 1, kReference, thermal::PartKind::kPipe});
    d.parts.push_back(part);
    at = part.to;
  }
  d.parts.push_back({at, 320, kReference, 1, kReference, thermal::PartKind::kPipe});
  pipe.parts = d.parts.size();
  d.pipes.push_back(pipe);
  return d;
}

std::vector<Told> drive(LeakFindings& findings, Drive& drive, double from, double to,
                        double start_time, double speed) {
  std::vector<Told> told;
  const int frames = static_cast<int>(std::floor((to - from) / (speed * Drive::kPeriod)));
  for (int i = 0; i <= frames; ++i) {
    const double time = start_time + i * Drive::kPeriod;
    const double x = from + i * speed * Drive::kPeriod;
    const FrameResult& result = findings.update(drive.frame(time, x), drive.look(x));
    for (const Event& event : result.events) {
      told.push_back({event, time});
    }
  }
  return told;
}

std::size_t count(const std::vector<Told>& told, EventKind kind) {
  return static_cast<std::size_t>(std::count_if(
      told.begin(), told.end(), [kind](const Told& t) { return t.event.kind == kind; }));
}

}  // namespace pipescout::leak_findings::test
