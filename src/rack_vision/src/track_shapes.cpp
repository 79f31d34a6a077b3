// SPDX-License-Identifier: Apache-2.0
// Pipes that may not be as the model has them: see ShapeMemory.
#include <algorithm>
#include <cmath>

#include "shape_contour.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Vector6d;

// px, one sigma: beyond it the surface of a pipe is not known well enough for texture on it.
constexpr double kKnownSurface = 1.0;
constexpr double kDeviations = 3;  // searched
constexpr double kShortest = 8;    // px: shorter contours say nothing
// A line gives two numbers, and the pose but for the place along the pipes has five.
constexpr std::size_t kLinesForPose = 3;
constexpr int kJudgedSamples = 5;
constexpr double kPoseReach = 3;  // px: what the pose moves contours by in a view

Vector6d as_motion(const ShapeVector& shape) {
  Vector6d result = Vector6d::Zero();
  result.head<kShapeUnknowns>() = shape;
  return result;
}

}  // namespace

std::bitset<kMaxPipes> TrackStep::shaped_pipes() const noexcept {
  std::bitset<kMaxPipes> result;
  for (const ShapedPipe& shaped : shapes_) {
    result.set(shaped.pipe);
  }
  return result;
}

double TrackStep::shape_deviation(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                                  const CameraView& seen) const {
  const auto shaped = std::ranges::find(shapes_, edge.id.body, &ShapedPipe::pipe);
  if (edge.id.kind != EdgeKind::kPipe || shaped == shapes_.end()) {
    return 0;
  }
  double largest = 0;
  for (const Eigen::Vector2d& end : {edge.image_start, edge.image_end}) {
    largest =
        std::max(largest, shaped->memory.deviation_along(distance_by_shape(
                              shaped->drawn, shaped->memory.mean(), edge.id, seen, end, normal)));
  }
  return largest;
}

void TrackStep::use_shapes(const auto& shape_of) {
  shapes_in_use_.clear();
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    shapes_in_use_.push_back(shape_of(i));
    Pipe& used = model_.pipes[shapes_[i].pipe];
    used = shaped(shapes_[i].drawn, to_shape(shapes_in_use_.back()));
    used.movable = false;
  }
}

void TrackStep::use_believed_shapes() {
  use_shapes([this](std::size_t i) { return shapes_[i].memory.mean(); });
}

void TrackStep::use_solved_shapes() {
  use_shapes([this](std::size_t i) { return solution_.shapes[i].mean; });
}

void TrackStep::begin_shapes(const TrackBelief& belief) {
  if (shapes_.empty()) {
    return;
  }
  use_believed_shapes();
  shape_beliefs_.clear();
  for (const ShapedPipe& shaped : shapes_) {
    shape_beliefs_.push_back({shaped.pipe, shaped.memory.mean(), shaped.memory.covariance()});
  }
  unshaped_.reset();
  without_texture_.reset();
  render(belief.T_rack_camera, belief.offsets);
  const CameraView seen(camera_, belief.T_rack_camera.inverse());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const double deviation = shape_deviation(edges_[i], normals_[i], seen);
    if (deviation > kKnownSurface) {
      without_texture_.set(edges_[i].id.body);
    }
    if (kDeviations * deviation > kFarFromBelieved) {
      unshaped_.set(edges_[i].id.body);
    }
  }
}

bool TrackStep::rests_on_what_is_known() const {
  if (without_texture_.none()) {
    return true;
  }
  std::vector<EdgeId> lines;
  for (std::size_t first = 0; first < samples_.size();) {
    EdgeId line = searched_[samples_[first].edge];
    const VisibleEdge* edge = rendered(line);
    int searched = 0;
    int found = 0;
    for (const std::uint32_t index = samples_[first].edge;
         first < samples_.size() && samples_[first].edge == index; ++first) {
      if (edge != nullptr && samples_[first].searched) {
        ++searched;
        found += is_found(samples_[first], *edge) ? 1 : 0;
      }
    }
    if (line.kind == EdgeKind::kPipe) {
      line.part = 0;  // sections of a pipe continue each other
    }
    const bool known = line.kind == EdgeKind::kSupport || !without_texture_[line.body];
    if (known && searched >= kJudgedSamples && 2 * found >= searched &&
        std::ranges::find(lines, line) == lines.end()) {
      lines.push_back(line);
    }
  }
  return lines.size() >= kLinesForPose;
}

void TrackStep::forget_shapes() {
  for (ShapedPipe& shaped : shapes_) {
    shaped.memory.reset();
  }
}

void TrackStep::render_only(std::size_t pipe, const StepOutcome& outcome) {
  const std::bitset<kMaxPipes> left_out = unshaped_;
  unshaped_.reset(pipe);
  render(outcome.belief.T_rack_camera, outcome.belief.offsets);
  unshaped_ = left_out;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].id.kind == EdgeKind::kPipe && edges_[i].id.body == pipe &&
        (edges_[i].image_end - edges_[i].image_start).norm() >= kShortest) {
      edges_[kept] = edges_[i];
      normals_[kept] = normals_[i];
      ++kept;
    }
  }
  edges_.resize(kept);
  normals_.resize(kept);
}

void TrackStep::learn_shapes(const ImageView& image, const StepOutcome& outcome, double share) {
  use_believed_shapes();
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    ShapedPipe& shaped = shapes_[i];
    if (shaped.memory.found()) {
      shaped.memory.learn(outcome.shapes[i], outcome.pipes[shaped.pipe], share);
    } else if (shaped.memory.is_another_view(share)) {
      take_view(image, outcome, shaped);
    }
  }
}

void TrackStep::take_view(const ImageView& image, const StepOutcome& outcome, ShapedPipe& shaped) {
  render_only(shaped.pipe, outcome);
  const geometry::SE3& T_rack_camera = outcome.belief.T_rack_camera;
  const CameraView seen(camera_, T_rack_camera.inverse());
  contours_.clear();
  std::vector<AlignmentTable> tables;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    AlignmentContour& contour = contours_.emplace_back();
    contour.start = edge.image_start;
    contour.end = edge.image_end;
    contour.normal = normals_[i];
    const auto by_shape = [&](const Eigen::Vector2d& pixel) {
      return distance_by_shape(shaped.drawn, shaped.memory.mean(), edge.id, seen, pixel,
                               contour.normal);
    };
    const ShapeVector at_start = by_shape(edge.image_start);
    const ShapeVector at_end = by_shape(edge.image_end);
    contour.start_by_motion = as_motion(at_start);
    contour.end_by_motion = as_motion(at_end);
    if (rows_.is_rolling()) {
      const EdgeMotion motion = motion_of(edge, contour.normal, T_rack_camera);
      contour.start += motion.speed(0) * edge_search_.instant(edge.image_start) * contour.normal;
      contour.end += motion.speed(1) * edge_search_.instant(edge.image_end) * contour.normal;
    }
    const double reach =
        kPoseReach + kDeviations * std::max(shaped.memory.deviation_along(at_start),
                                            shaped.memory.deviation_along(at_end));
    alignment_.tabulate(image, contour, ShapeMemory::kStep, reach, tables.emplace_back());
  }
  if (!contours_.empty()) {
    shaped.memory.take_view(contours_, tables, alignment_);
  }
}

}  // namespace pipescout::rack_vision
