// SPDX-License-Identifier: Apache-2.0
#include "arc_list.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::navigation {
namespace {

constexpr double kNoLength = 1e-9;  // m

}  // namespace

double length_of(const ArcList& arcs) {
  double length = 0;
  for (const ArcPiece& arc : arcs) {
    length += std::abs(arc.length);
  }
  return length;
}

Pose2d end_of_arcs(const Pose2d& start, const ArcList& arcs) {
  Pose2d pose = start;
  for (const ArcPiece& arc : arcs) {
    pose = drive_arc(pose, arc.curvature, arc.length);
  }
  return pose;
}

ArcList arcs_of_word(const SteeringWord& word, double radius) {
  ArcList arcs;
  for (int i = 0; i < word.count; ++i) {
    const SteeringPiece& piece = word.pieces[static_cast<std::size_t>(i)];
    if (std::abs(piece.length) > kNoLength) {
      arcs.push_back({piece.turn / radius, piece.length});
    }
  }
  return arcs;
}

ArcList reversed(const ArcList& arcs) {
  ArcList result(arcs.rbegin(), arcs.rend());
  for (ArcPiece& arc : result) {
    arc.length = -arc.length;
  }
  return result;
}

ArcList cut(const ArcList& arcs, double from, double to) {
  ArcList result;
  double driven = 0;
  for (const ArcPiece& arc : arcs) {
    const double length = std::abs(arc.length);
    const double begin = std::max(from, driven);
    const double end = std::min(to, driven + length);
    if (end - begin > kNoLength) {
      result.push_back({arc.curvature, std::copysign(end - begin, arc.length)});
    }
    driven += length;
  }
  return result;
}

void tidy(ArcList& arcs) {
  ArcList result;
  for (const ArcPiece& arc : arcs) {
    if (!result.empty() && result.back().curvature == arc.curvature &&
        (result.back().length > 0) == (arc.length > 0)) {
      result.back().length += arc.length;
    } else if (std::abs(arc.length) > kNoLength) {
      result.push_back(arc);
    }
  }
  arcs = std::move(result);
}

Path sampled(const Pose2d& start, const ArcList& arcs, double step) {
  std::vector<PathPose> poses;
  poses.reserve(static_cast<std::size_t>(length_of(arcs) / step) + 2 * arcs.size() + 1);
  Pose2d pose = start;
  double driven = 0;
  for (const ArcPiece& arc : arcs) {
    const Direction direction = arc.length > 0 ? Direction::kForward : Direction::kReverse;
    const double length = std::abs(arc.length);
    const double parts = std::ceil(length / step);
    if (!poses.empty() && poses.back().direction == direction) {
      poses.pop_back();
    }
    poses.push_back({pose, direction, arc.curvature, driven});
    // All chords are alike, each turned on from the one before.
    const double turn = arc.curvature * arc.length / parts;
    const Pose2d chord = drive_arc({}, arc.curvature, arc.length / parts);
    Point2d along = transform({0, 0, pose.heading}, chord.position());
    const double cosine = std::cos(turn);
    const double sine = std::sin(turn);
    Pose2d at = pose;
    for (double i = 1; i < parts; ++i) {
      at = {at.x + along.x, at.y + along.y, wrap_angle(at.heading + turn)};
      along = {cosine * along.x - sine * along.y, sine * along.x + cosine * along.y};
      poses.push_back({at, direction, arc.curvature, driven + length * i / parts});
    }
    pose = drive_arc(pose, arc.curvature, arc.length);
    driven += length;
    poses.push_back({pose, direction, arc.curvature, driven});
  }
  if (poses.empty()) {
    poses.push_back({.pose = start});
  }
  return Path(std::move(poses));
}

ArcList arcs_of_path(const Path& path) {
  ArcList arcs;
  for (std::size_t i = 1; i < path.poses().size(); ++i) {
    const PathPose& from = path.poses()[i - 1];
    const double length = path.poses()[i].arc_length - from.arc_length;
    arcs.push_back({from.curvature, from.direction == Direction::kForward ? length : -length});
  }
  tidy(arcs);
  return arcs;
}

}  // namespace pipescout::navigation
