// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/visible_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "image_window.hpp"
#include "shadow.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Pixels: shorter pieces, and gaps between pieces, are not worth an edge of their own.
constexpr double kNegligible = 0.05;

constexpr std::uint16_t kSupportEdges = 12;

void check(const RackModel& model, PipeOffsets offsets, const geometry::SE3& T_camera_rack) {
  if (!offsets.empty() && offsets.size() != model.pipes.size()) {
    throw std::invalid_argument("there are " + std::to_string(offsets.size()) + " offsets for " +
                                std::to_string(model.pipes.size()) + " pipes");
  }
  if (!std::ranges::all_of(offsets, [](double offset) { return std::isfinite(offset); })) {
    throw std::invalid_argument("an offset of a pipe is not finite");
  }
  if (!T_camera_rack.translation().allFinite() ||
      !T_camera_rack.rotation().quaternion().coeffs().allFinite()) {
    throw std::invalid_argument("the pose of the camera is not finite");
  }
  if (model.supports.size() > kMaxSupports) {
    throw std::invalid_argument("the rack has more than " + std::to_string(kMaxSupports) +
                                " supports");
  }
}

/// Whether a face beside an edge of the support looks at the eye.
bool faces_eye(const Support& support, std::uint16_t part, const Vector3d& eye) {
  const int axis = part / 4;
  for (int next = 1; next <= 2; ++next) {
    const int across = (axis + next) % 3;
    if ((part & next) != 0 ? eye[across] > support.highest_corner[across]
                           : eye[across] < support.lowest_corner[across]) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool contour_lines(const PipeSection& section, const Vector3d& eye,
                   ContourLine (&lines)[2]) noexcept {
  const Vector3d from_start = eye - section.start;
  const double along = section.direction.dot(from_start);
  const Vector3d radial = from_start - along * section.direction;
  const double distance = radial.norm();  // l of equation (11)
  const double slope = (section.radius_end - section.radius_start) / section.length;
  const double radius = section.radius_start + slope * along;
  // Within rounding of the surface the lines are anywhere.
  if (!(distance > 0) || !(std::abs(radius) < distance * (1 - 1e-12))) {
    return false;
  }
  const Vector3d to_eye = radial / distance;
  const Vector3d aside = section.direction.cross(to_eye);
  const double cosine = radius / distance;
  const double sine = std::sqrt(1 - cosine * cosine);
  const double norm = std::sqrt(1 + slope * slope);
  const Vector3d end = section.start + section.length * section.direction;
  for (const int side : {0, 1}) {
    const Vector3d outward = cosine * to_eye + (side == 0 ? -sine : sine) * aside;
    lines[side] = {section.start + section.radius_start * outward,
                   end + section.radius_end * outward,
                   (outward - slope * section.direction) / norm};
  }
  return true;
}

SupportEdge support_edge(const Support& support, std::uint16_t part) {
  if (part >= kSupportEdges) {
    throw std::invalid_argument("part is " + std::to_string(part) +
                                "; an edge of a support must be 0 to 11");
  }
  const int axis = part / 4;
  Vector3d corner = support.lowest_corner;
  for (int next = 1; next <= 2; ++next) {
    if ((part & next) != 0) {
      corner[(axis + next) % 3] = support.highest_corner[(axis + next) % 3];
    }
  }
  SupportEdge edge{corner, corner};
  edge.end[axis] = support.highest_corner[axis];
  return edge;
}

/// What one call works with. The vectors have their largest sizes from the beginning.
struct EdgeRenderer::Work {
  struct Section {
    PipeSection section;
    std::uint16_t pipe;
    std::uint16_t part;
  };
  struct SectionBody {
    SectionShadow shadow;
    std::size_t section;
  };
  struct SupportBody {
    SupportShadow shadow;
    std::size_t support;
  };
  std::vector<PipeSection> of_one_pipe;
  std::vector<Section> sections;
  std::vector<SectionBody> section_bodies;
  std::vector<SupportBody> support_bodies;
  std::vector<Interval> hidden;

  Work() {
    of_one_pipe.reserve(kMaxSections);
    sections.reserve(kMaxSections);
    section_bodies.reserve(kMaxSections);
    support_bodies.reserve(kMaxSupports);
    hidden.reserve(kMaxSections + kMaxSupports + 16);
  }

  void collect_sections(const RackModel& model, PipeOffsets offsets) {
    sections.clear();
    for (std::size_t pipe = 0; pipe < model.pipes.size(); ++pipe) {
      of_one_pipe.clear();
      append_sections(model.pipes[pipe], offsets.empty() ? 0 : offsets[pipe], of_one_pipe);
      if (sections.size() + of_one_pipe.size() > kMaxSections) {
        throw std::invalid_argument("the rack has more than " + std::to_string(kMaxSections) +
                                    " sections");
      }
      for (std::size_t part = 0; part < of_one_pipe.size(); ++part) {
        sections.push_back({of_one_pipe[part], static_cast<std::uint16_t>(pipe),
                            static_cast<std::uint16_t>(part)});
      }
    }
  }

  /// The bodies that can hide something in the image; false: the eye is within one.
  bool collect_bodies(const RackModel& model, const ImageWindow& window) {
    section_bodies.clear();
    support_bodies.clear();
    for (std::size_t i = 0; i < sections.size(); ++i) {
      const SectionShadow shadow(sections[i].section, window.eye());
      if (shadow.holds_eye()) {
        return false;
      }
      if (!shadow.outside(window.planes())) {
        section_bodies.push_back({shadow, i});
      }
    }
    for (std::size_t i = 0; i < model.supports.size(); ++i) {
      const SupportShadow shadow(model.supports[i], window.eye());
      if (shadow.holds_eye()) {
        return false;
      }
      if (!shadow.outside(window.planes())) {
        support_bodies.push_back({shadow, i});
      }
    }
    return true;
  }

  /// `own`: index of the section or of the support that the edge belongs to; convex, it never hides
  /// its own outline.
  void append_pieces(const EdgeId& id, std::size_t own, Vector3d start, Vector3d end,
                     const ImageWindow& window, std::vector<VisibleEdge>& edges) {
    start -= window.eye();
    end -= window.eye();
    if (!window.clip(start, end)) {
      return;
    }
    hidden.clear();
    const auto hides = [&](const auto& body, bool is_own) {
      Interval part;
      if (!is_own && body.shadow.hides(start, end, part)) {
        hidden.push_back(part);
        return part.from <= 0 && part.to >= 1;
      }
      return false;
    };
    const bool is_pipe = id.kind == EdgeKind::kPipe;
    if (std::ranges::any_of(
            section_bodies,
            [&](const SectionBody& body) { return hides(body, is_pipe && body.section == own); }) ||
        std::ranges::any_of(support_bodies, [&](const SupportBody& body) {
          return hides(body, !is_pipe && body.support == own);
        })) {
      return;  // as a whole
    }
    window.append_outside(start, end, hidden);
    std::ranges::sort(hidden, {}, &Interval::from);
    append_between_hidden(id, start, end, window, edges);
  }

  void append_between_hidden(const EdgeId& id, const Vector3d& start, const Vector3d& end,
                             const ImageWindow& window, std::vector<VisibleEdge>& edges) const {
    const auto at = [&](double part) { return Vector3d(start + part * (end - start)); };
    double open = 0;
    Vector2d open_pixel = window.pixel(start);
    const auto close = [&](double part) {
      const Vector2d pixel = window.pixel(at(part));
      if ((pixel - open_pixel).norm() >= kNegligible) {
        edges.push_back({id, window.eye() + at(open), window.eye() + at(part), open_pixel, pixel});
      }
    };
    for (std::size_t i = 0; i < hidden.size();) {
      // Hidden parts that overlap are one.
      Interval run = hidden[i];
      for (++i; i < hidden.size() && hidden[i].from <= run.to; ++i) {
        run.to = std::max(run.to, hidden[i].to);
      }
      const Vector2d run_end = window.pixel(at(run.to));
      if (run.from > 0 && run.to < 1 &&
          (run_end - window.pixel(at(run.from))).norm() < kNegligible) {
        continue;
      }
      close(run.from);
      open = run.to;
      open_pixel = run_end;
    }
    close(1);
  }
};

EdgeRenderer::EdgeRenderer() : work_(std::make_unique<Work>()) {}
EdgeRenderer::~EdgeRenderer() = default;
EdgeRenderer::EdgeRenderer(EdgeRenderer&&) noexcept = default;
EdgeRenderer& EdgeRenderer::operator=(EdgeRenderer&&) noexcept = default;

void EdgeRenderer::render(const RackModel& model, PipeOffsets offsets,
                          const geometry::Camera& camera, const geometry::SE3& T_camera_rack,
                          std::vector<VisibleEdge>& edges) {
  check(model, offsets, T_camera_rack);
  edges.clear();
  Work& work = *work_;
  work.collect_sections(model, offsets);
  const ImageWindow window(camera, T_camera_rack);
  if (!work.collect_bodies(model, window)) {
    return;
  }
  // A contour line lies on its body: what is not in view has none in view.
  for (const Work::SectionBody& body : work.section_bodies) {
    const Work::Section& section = work.sections[body.section];
    ContourLine lines[2];
    if (!contour_lines(section.section, window.eye(), lines)) {
      continue;
    }
    for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}}) {
      const EdgeId id{EdgeKind::kPipe, section.pipe, section.part, side};
      work.append_pieces(id, body.section, lines[side].start, lines[side].end, window, edges);
    }
  }
  for (const Work::SupportBody& body : work.support_bodies) {
    const Support& support = model.supports[body.support];
    for (std::uint16_t part = 0; part < kSupportEdges; ++part) {
      if (faces_eye(support, part, window.eye())) {
        const EdgeId id{EdgeKind::kSupport, static_cast<std::uint16_t>(body.support), part, 0};
        const SupportEdge edge = support_edge(support, part);
        work.append_pieces(id, body.support, edge.start, edge.end, window, edges);
      }
    }
  }
}

}  // namespace pipescout::rack_vision
