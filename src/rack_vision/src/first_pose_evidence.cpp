// SPDX-License-Identifier: Apache-2.0
#include "first_pose_evidence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAlongFlow = 0.9998;    // cosine of 1.1 degrees
constexpr double kShortestOverlap = 6;   // pixels
constexpr double kShortestContour = 40;  // pixels
constexpr double kCell = 6;              // pixels of edge that are covered or not
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kMostCells = 160;  // the diagonal of most images

/// The part of a segment beside an edge, if it is near enough.
struct Overlap {
  double from, to;      // pixels along the edge
  double squared_off;   // mean, relative to the tolerance
  Vector2d start, end;  // of the segment's part
};

std::optional<Overlap> overlap(const VisibleEdge& edge, const Vector2d& along, double edge_length,
                               const SegmentPlane& plane, double tolerance) {
  const Vector2d across(-along.y(), along.x());
  // A line 8 degrees off is no piece of the edge however close it is.
  if (std::abs(across.dot(plane.direction)) > 0.14) {
    return std::nullopt;
  }
  Vector2d a = plane.segment.start - edge.image_start;
  Vector2d b = plane.segment.end - edge.image_start;
  if (a.dot(along) > b.dot(along)) {
    std::swap(a, b);
  }
  const double from = a.dot(along);
  const double to = b.dot(along);
  const double low = std::max(0.0, from);
  const double high = std::min(edge_length, to);
  if (high - low < kShortestOverlap) {
    return std::nullopt;
  }
  const Vector2d start = a + (low - from) / (to - from) * (b - a);
  const Vector2d end = a + (high - from) / (to - from) * (b - a);
  const double off_start = start.dot(across) / tolerance;
  const double off_end = end.dot(across) / tolerance;
  if (std::abs(off_start) > 1 || std::abs(off_end) > 1) {
    return std::nullopt;
  }
  return Overlap{low, high, 0.5 * (off_start * off_start + off_end * off_end),
                 start + edge.image_start, end + edge.image_start};
}

}  // namespace

RackOutline::RackOutline(const RackModel& rack, PipeOffsets pipe_offsets)
    : model(rack), offsets(pipe_offsets) {
  start = std::numeric_limits<double>::max();
  end = std::numeric_limits<double>::lowest();
  for (std::size_t i = 0; i < model.pipes.size(); ++i) {
    const Pipe& pipe = model.pipes[i];
    append_sections(pipe, offsets.empty() ? 0 : offsets[i], sections.emplace_back());
    along_flow.push_back(std::abs(pipe.direction.y()) > kAlongFlow);
    if (along_flow.back()) {
      const double other = pipe.start.y() + pipe.length() * pipe.direction.y();
      start = std::min({start, pipe.start.y(), other});
      end = std::max({end, pipe.start.y(), other});
    }
  }
}

Evidence EvidenceFinder::find(const geometry::SE3& T_camera_rack, double tolerance) {
  renderer_.render(rack_.model, rack_.offsets, camera_, T_camera_rack, edges_);
  struct Beside {
    std::size_t edge, plane;
    Overlap part;
  };
  std::vector<Beside> all;
  std::vector<std::size_t> nearest(planes_.size(), kNone);  // of each segment, in `all`
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const Vector2d vector = edges_[i].image_end - edges_[i].image_start;
    const double length = vector.norm();
    if (!(length >= kShortestOverlap)) {
      continue;
    }
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      const auto part = overlap(edges_[i], vector / length, length, planes_[k], tolerance);
      if (part) {
        if (nearest[k] == kNone || part->squared_off < all[nearest[k]].part.squared_off) {
          nearest[k] = all.size();
        }
        all.push_back({i, k, *part});
      }
    }
  }
  Evidence evidence;
  std::vector<bool> matched(planes_.size(), false);
  std::array<double, kMostCells> cells{};
  std::vector<EdgeId> found;
  std::vector<EdgeId> visible;
  auto next = all.begin();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    const double length = (edge.image_end - edge.image_start).norm();
    const bool along_flow = edge.id.kind == EdgeKind::kPipe && rack_.along_flow[edge.id.body];
    const std::size_t count =
        std::clamp<std::size_t>(static_cast<std::size_t>(length / kCell), 1, kMostCells);
    const double cell = length / static_cast<double>(count);
    std::fill_n(cells.begin(), count, 0.0);
    bool any = false;
    for (; next != all.end() && next->edge == i; ++next) {
      // A segment counts for one contour, the nearest, but for all the pieces of that.
      const EdgeId& owner = edges_[all[nearest[next->plane]].edge].id;
      if (owner.kind != edge.id.kind || owner.body != edge.id.body || owner.side != edge.id.side) {
        continue;
      }
      any = true;
      matched[next->plane] = true;
      const Overlap& part = next->part;
      evidence.matches.push_back({edge.id, along_flow, part.start, part.end});
      const auto first = static_cast<std::size_t>(std::lround(part.from / cell));
      const auto last = std::min(count, static_cast<std::size_t>(std::lround(part.to / cell)));
      for (std::size_t k = first; k < last; ++k) {
        cells[k] = std::max(cells[k], 1 - part.squared_off);
      }
    }
    double covered = 0;
    for (std::size_t k = 0; k < count; ++k) {
      covered += cell * cells[k];
    }
    const EdgeId contour{edge.id.kind, edge.id.body, 0, edge.id.side};
    if (along_flow && length >= kShortestContour &&
        std::ranges::find(visible, contour) == visible.end()) {
      visible.push_back(contour);
    }
    (along_flow ? evidence.predicted : evidence.transverse_predicted) += length;
    (along_flow ? evidence.covered : evidence.transverse_covered) += covered;
    if (along_flow && any) {
      found.push_back(edge.id);
    }
  }
  evidence.visible_contours = visible.size();
  evidence.on_pipes = length_on_pipes(T_camera_rack, matched);
  // Several sections, and pieces of one, are one contour.
  std::size_t last_pipe = kNone;
  std::array<bool, 2> sides{};
  for (const EdgeId& id : found) {
    if (id.body != last_pipe) {
      sides = {};
      last_pipe = id.body;
      ++evidence.pipes;
    }
    evidence.contours += sides[id.side] ? 0 : 1;
    sides[id.side] = true;
  }
  return evidence;
}

double EvidenceFinder::length_on_pipes(const geometry::SE3& T_camera_rack,
                                       const std::vector<bool>& matched) const {
  constexpr double kMargin = 6;     // pixels: shading ends next to a contour
  constexpr double kTolerance = 2;  // pixels
  const CameraView view(camera_, T_camera_rack);
  const Eigen::Matrix3d to_rack = view.R_camera_rack.transpose() * camera_.inverse_matrix();
  const Vector3d flow = view.R_camera_rack * Vector3d::UnitY();
  std::vector<std::size_t> loose;
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    if (!matched[i] && points_along(planes_[i], camera_.matrix(), flow, kTolerance)) {
      loose.push_back(i);
    }
  }
  double length = 0;
  for (std::size_t pipe = 0; pipe < rack_.sections.size(); ++pipe) {
    for (const PipeSection& section : rack_.sections[pipe]) {
      ContourLine contours[2];
      ImageLine left;
      ImageLine right;
      if (!rack_.along_flow[pipe] || !contour_lines(section, view.centre, contours) ||
          !image_line(view, contours[0], left) || !image_line(view, contours[1], right)) {
        continue;
      }
      for (const std::size_t i : loose) {
        const Vector2d middle = 0.5 * (planes_[i].segment.start + planes_[i].segment.end);
        const Vector3d ray = to_rack * middle.homogeneous();
        // Where the ray meets the level of the axis.
        const double y =
            view.centre.y() + ray.y() * (section.start.z() - view.centre.z()) / ray.z();
        const double along = (y - section.start.y()) * section.direction.y();
        if (left.line.dot(middle.homogeneous()) < -kMargin &&
            right.line.dot(middle.homogeneous()) < -kMargin && along > 0 &&
            along < section.length) {
          length += planes_[i].length;
        }
      }
    }
  }
  return length;
}

bool EvidenceFinder::line_of(const EdgeId& id, const CameraView& view, ImageLine& line) const {
  if (id.kind == EdgeKind::kSupport) {
    ContourLine edge;
    return support_line(support_edge(rack_.model.supports[id.body], id.part), view.centre, edge) &&
           image_line(view, edge, line);
  }
  ContourLine lines[2];
  return contour_lines(rack_.sections[id.body][id.part], view.centre, lines) &&
         image_line(view, lines[id.side], line);
}

bool EvidenceFinder::tells_place(const EdgeMatch& match) const {
  if (!match.along_flow) {
    return true;
  }
  const PipeSection& section = rack_.sections[match.id.body][match.id.part];
  return section.radius_start != section.radius_end;
}

std::optional<EvidenceFinder::Fit> EvidenceFinder::fit(const geometry::SE3& T_camera_rack,
                                                       std::span<const EdgeMatch> matches,
                                                       bool place_is_seen, const Along& along,
                                                       double sigma) const {
  constexpr int kSteps = 5;
  Fit fit{.T_camera_rack = T_camera_rack, .information = geometry::Matrix6d::Zero()};
  for (int step = 0; step < kSteps; ++step) {
    const CameraView view(camera_, fit.T_camera_rack);
    // Wide at first, while the pose is off by more than the noise.
    const double scale = sigma * (step < 2 ? 10.0 : 3.0);
    geometry::Vector6d gradient = geometry::Vector6d::Zero();
    fit.information.setZero();
    double squares = 0;
    double weights = 0;
    for (const EdgeMatch& match : matches) {
      ImageLine line;
      if ((!place_is_seen && tells_place(match)) || !line_of(match.id, view, line)) {
        continue;
      }
      for (const Vector2d& pixel : {match.start, match.end}) {
        const double residual = line.line.dot(pixel.homogeneous());
        const geometry::Vector6d row = line.derivative.transpose() * pixel.homogeneous();
        const double weight = 1 / (1 + residual * residual / (scale * scale));
        fit.information += weight / (sigma * sigma) * row * row.transpose();
        gradient -= weight * residual / (sigma * sigma) * row;
        squares += weight * residual * residual / (sigma * sigma);
        weights += weight;
      }
    }
    const double known = 1 / (along.standard_deviation * along.standard_deviation);
    fit.information(1, 1) += known;
    gradient(1) += known * (along.value - view.centre.y());
    const Eigen::LDLT<geometry::Matrix6d> factors(fit.information);
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) {
      return std::nullopt;
    }
    const geometry::Vector6d motion = factors.solve(gradient);
    // Farther is no refinement of what was proposed.
    if (!motion.allFinite() || motion.tail<3>().norm() > 0.5 || std::abs(motion(0)) > 3 ||
        std::abs(motion(2)) > 3) {
      return std::nullopt;
    }
    fit.T_camera_rack = moved(fit.T_camera_rack, motion);
    fit.rms = sigma * std::sqrt(squares / std::max(1.0, weights));
    fit.inflation = std::max(1.0, squares / std::max(1.0, weights - 5));
  }
  return fit;
}

}  // namespace pipescout::rack_vision::internal
