// SPDX-License-Identifier: Apache-2.0
#include "first_pose_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "first_pose_profile.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAlongFlow = 0.9998;      // cosine of 1.1 degrees
constexpr double kShortestPiece = 12;      // pixels
constexpr double kTransverseShare = 0.12;  // of places across the flow that have a line by chance
constexpr double kTransverseWeight = 0.5;  // edges of one beam are not seen independently
constexpr double kContourFound = 0.5;      // share of its length
constexpr double kShortestContour = 40;    // pixels

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

Evidence EvidenceFinder::find(const geometry::SE3& T_camera_rack, int reach, double line_share) {
  renderer_.render(rack_.model, rack_.offsets, camera_, T_camera_rack, edges_);
  Evidence evidence;
  struct Contour {
    double visible = 0, found = 0;
    bool along_flow = false;
  };
  // Several sections, and pieces of one, are one contour; so are those of an
  // edge of a support.
  std::vector<std::pair<EdgeId, Contour>> contours;
  for (const VisibleEdge& edge : edges_) {
    const Vector2d whole = edge.image_end - edge.image_start;
    const double length = whole.norm();
    if (!(length >= kShortestPiece)) {
      continue;
    }
    EdgeId id = edge.id;
    id.part = id.kind == EdgeKind::kPipe ? std::uint16_t{0} : id.part;
    if (contours.empty() || contours.back().first != id) {
      auto known = std::ranges::find(contours, id, &std::pair<EdgeId, Contour>::first);
      if (known == contours.end()) {
        contours.push_back({id, {}});
      } else {
        std::swap(*known, contours.back());
      }
    }
    Contour& contour = contours.back().second;
    contour.along_flow = id.kind == EdgeKind::kPipe && rack_.along_flow[id.body];
    const Vector2d across = Vector2d(-whole.y(), whole.x()) / length;
    const int count = std::max(1, static_cast<int>(std::lround(length / kPieceLength)));
    for (int i = 0; i < count; ++i) {
      const Vector2d from = edge.image_start + whole * (static_cast<double>(i) / count);
      const Vector2d to = edge.image_start + whole * (static_cast<double>(i + 1) / count);
      if (const auto fit = image_.fit(from, to, across, reach)) {
        contour.visible += length / count;
        contour.found += length / count * clearness(*fit);
      }
    }
  }
  std::vector<std::uint16_t> pipes;
  for (const auto& [id, contour] : contours) {
    if (!(contour.visible > 0)) {
      continue;
    }
    const double share = contour.found / contour.visible;
    evidence.visible += contour.visible;
    evidence.found += contour.found;
    if (contour.along_flow) {
      evidence.along += evidence_of_contour(share, contour.visible, line_share);
      if (share > kContourFound && contour.visible > kShortestContour) {
        ++evidence.contours;
        if (std::ranges::find(pipes, id.body) == pipes.end()) {
          pipes.push_back(id.body);
        }
      }
    } else {
      evidence.transverse +=
          kTransverseWeight * evidence_of_contour(share, contour.visible, kTransverseShare);
      evidence.transverse_edges += share > kContourFound ? 1 : 0;
    }
  }
  evidence.pipes = pipes.size();
  return evidence;
}

}  // namespace pipescout::rack_vision::internal
