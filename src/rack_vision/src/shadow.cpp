// SPDX-License-Identifier: Apache-2.0
#include "shadow.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;

/// For comparisons of places that rounding may put on the wrong side of a corner of the body.
constexpr double kRounding = 1e-9;

constexpr Interval kNothing{2, -1};

void widen(Interval& hull, double t) {
  hull.from = std::min(hull.from, t);
  hull.to = std::max(hull.to, t);
}

/// Calls `use` for each root of a t^2 + 2 b t + c in (0, 1).
template <typename Use>
void for_roots(double a, double b, double c, Use use) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) {
    return;
  }
  // Without the difference of nearly equal numbers, and right for a = 0.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  if (a != 0 && q / a > 0 && q / a < 1) {
    use(q / a);
  }
  if (q != 0 && c / q > 0 && c / q < 1) {
    use(c / q);
  }
}

}  // namespace

SectionShadow::SectionShadow(const PipeSection& section, const Vector3d& eye)
    : along_(section.direction),
      start_(section.start - eye),
      length_(section.length),
      radius_start_(section.radius_start - kSkin),
      radius_end_(section.radius_end - kSkin),
      slope_((section.radius_end - section.radius_start) / section.length) {
  const double z = -along_.dot(start_);
  const Vector3d radial = -start_ - z * along_;
  const double distance = radial.norm();
  across_x_ = distance > kSkin ? Vector3d(radial / distance) : along_.unitOrthogonal();
  across_y_ = along_.cross(across_x_);
  eye_ = {distance > kSkin ? distance : 0, 0, z, radius_start_ + slope_ * z};
  has_tangents_ = std::abs(eye_.radius) < eye_.x;
  if (has_tangents_) {
    tangent_x_ = eye_.radius / eye_.x;
    tangent_y_ = std::sqrt(1 - tangent_x_ * tangent_x_);
  }
  nearest_ = eye_.x - std::max(radius_start_, radius_end_);
}

SectionShadow::Local SectionShadow::local(const Vector3d& direction) const noexcept {
  const double z = along_.dot(direction);
  return {across_x_.dot(direction), across_y_.dot(direction), z, slope_ * z};
}

bool SectionShadow::holds_eye() const noexcept {
  return eye_.z > 0 && eye_.z < length_ && eye_.x < eye_.radius;
}

bool SectionShadow::outside(const ViewPlanes& planes) const noexcept {
  return std::ranges::any_of(planes, [&](const Vector3d& inside) {
    const double along = inside.dot(along_);
    const double across = std::sqrt(std::max(0.0, inside.squaredNorm() - along * along));
    const double at_start = inside.dot(start_);
    return at_start + radius_start_ * across < 0 &&
           at_start + length_ * along + radius_end_ * across < 0;
  });
}

/// Whether the ray from the eye to the point eye + p goes through the body before p.
bool SectionShadow::hides_point(const Local& p) const noexcept {
  double from = 0;
  double to = 1;
  if (std::abs(p.z) > 1e-300) {
    const double first = -eye_.z / p.z;
    const double second = (length_ - eye_.z) / p.z;
    from = std::max(from, std::min(first, second));
    to = std::min(to, std::max(first, second));
  } else if (eye_.z <= 0 || eye_.z >= length_) {
    return false;
  }
  if (!(to > from + kRounding)) {
    return false;
  }
  // Negative within the cone: c + 2 b s + a s^2 at eye + s p.
  const double a = p.x * p.x + p.y * p.y - p.radius * p.radius;
  const double b = eye_.x * p.x - eye_.radius * p.radius;
  const double c = eye_.x * eye_.x - eye_.radius * eye_.radius;
  const auto within = [&](double s) { return c + s * (2 * b + s * a) < 0; };
  if (a > 0) {
    return within(std::clamp(-b / a, from, to));
  }
  return within(from) || within(to);
}

/// Where the ray to the segment p + t e touches the side of the body, before the segment.
void SectionShadow::widen_by_tangents(const Local& p, const Local& e,
                                      Interval& hull) const noexcept {
  for (const double y : {tangent_y_, -tangent_y_}) {
    const double at_p = tangent_x_ * p.x + y * p.y - p.radius;
    const double change = tangent_x_ * e.x + y * e.y - e.radius;
    const double t = -at_p / change;
    if (!(t > 0 && t < 1)) {
      continue;
    }
    const Local d{p.x + t * e.x, p.y + t * e.y, p.z + t * e.z, p.radius + t * e.radius};
    const double a = d.x * d.x + d.y * d.y - d.radius * d.radius;
    const double b = eye_.x * d.x - eye_.radius * d.radius;
    const double s = -b / a;  // a double root
    const double z = eye_.z + s * d.z;
    if (s > 0 && s <= 1 + kRounding && z >= -kRounding && z <= length_ + kRounding) {
      widen(hull, t);
    }
  }
}

/// Where the segment itself enters or leaves the body.
void SectionShadow::widen_by_crossing(const Local& p, const Local& e,
                                      Interval& hull) const noexcept {
  const Local start{eye_.x + p.x, p.y, eye_.z + p.z, eye_.radius + p.radius};
  const double a = e.x * e.x + e.y * e.y - e.radius * e.radius;
  const double b = start.x * e.x + start.y * e.y - start.radius * e.radius;
  const double c = start.x * start.x + start.y * start.y - start.radius * start.radius;
  for_roots(a, b, c, [&](double t) {
    const double z = start.z + t * e.z;
    if (z >= -kRounding && z <= length_ + kRounding) {
      widen(hull, t);
    }
  });
  for (const double end : {0.0, length_}) {
    const double t = (end - start.z) / e.z;
    if (t > 0 && t < 1 && c + t * (2 * b + t * a) <= kRounding) {
      widen(hull, t);
    }
  }
}

/// Where the ray to the segment goes through the rim of an end. At the height z of that end it is
/// at s = (z - eye.z) / (p.z + t e.z) of its way to the segment; the condition that its distance
/// from the axis is the radius there, times the square of that denominator, is quadratic in t.
void SectionShadow::widen_by_rims(const Local& p, const Local& e, Interval& hull) const noexcept {
  for (const bool at_end : {false, true}) {
    const double height = (at_end ? length_ : 0) - eye_.z;
    const double radius = at_end ? radius_end_ : radius_start_;
    const double x0 = eye_.x * p.z + height * p.x;
    const double y0 = height * p.y;
    const double r0 = radius * p.z;
    const double x1 = eye_.x * e.z + height * e.x;
    const double y1 = height * e.y;
    const double r1 = radius * e.z;
    for_roots(x1 * x1 + y1 * y1 - r1 * r1, x0 * x1 + y0 * y1 - r0 * r1, x0 * x0 + y0 * y0 - r0 * r0,
              [&](double t) {
                const double s = height / (p.z + t * e.z);
                if (s > 0 && s <= 1 + kRounding) {
                  widen(hull, t);
                }
              });
  }
}

bool SectionShadow::hides(const Vector3d& a, const Vector3d& b, Interval& hidden) const noexcept {
  const Local p = local(a);
  const Local q = local(b);
  // Bounds first: beside the body, in front of it, or all beyond one of its ends.
  if (has_tangents_) {
    for (const double y : {tangent_y_, -tangent_y_}) {
      if (tangent_x_ * p.x + y * p.y - p.radius >= 0 &&
          tangent_x_ * q.x + y * q.y - q.radius >= 0) {
        return false;
      }
    }
  }
  if ((-p.x < nearest_ && -q.x < nearest_) ||
      (eye_.z <= 0 && eye_.z + p.z <= 0 && eye_.z + q.z <= 0) ||
      (eye_.z >= length_ && eye_.z + p.z >= length_ && eye_.z + q.z >= length_)) {
    return false;
  }
  Interval hull = kNothing;
  if (hides_point(p)) {
    widen(hull, 0);
  }
  if (hides_point(q)) {
    widen(hull, 1);
  }
  if (!(hull.from == 0 && hull.to == 1)) {
    const Local e{q.x - p.x, q.y - p.y, q.z - p.z, q.radius - p.radius};
    if (has_tangents_) {
      widen_by_tangents(p, e, hull);
    }
    widen_by_crossing(p, e, hull);
    widen_by_rims(p, e, hull);
  }
  hidden = hull;
  return hull.from < hull.to;
}

SupportShadow::SupportShadow(const Support& support, const Vector3d& eye)
    : low_(support.lowest_corner - eye + Vector3d::Constant(kSkin)),
      high_(support.highest_corner - eye - Vector3d::Constant(kSkin)) {
  // The side of each axis on which a face looks at the eye: 0 is none.
  std::array<int, 3> front{};
  for (int axis = 0; axis < 3; ++axis) {
    front[static_cast<std::size_t>(axis)] = high_[axis] < 0 ? 1 : (low_[axis] > 0 ? -1 : 0);
  }
  for (int i = 0; i < 3; ++i) {
    const int side = front[static_cast<std::size_t>(i)];
    if (side == 0) {
      continue;
    }
    const double face = side > 0 ? high_[i] : low_[i];
    for (int j = 0; j < 3; ++j) {
      for (const int other : {-1, 1}) {
        if (j == i || front[static_cast<std::size_t>(j)] == other) {
          continue;  // not a neighbour, or one that looks at the eye: no outline between them
        }
        const double edge = other > 0 ? high_[j] : low_[j];
        Vector3d normal = Vector3d::Zero();
        normal[i] = edge;
        normal[j] = -face;
        if (normal.dot(low_ + high_) > 0) {
          normal = -normal;
        }
        planes_[count_++] = {normal, 0};
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    const int side = front[static_cast<std::size_t>(i)];
    if (side != 0) {
      planes_[count_++] = {side * Vector3d::Unit(i), side > 0 ? high_[i] : -low_[i]};
    }
  }
}

bool SupportShadow::outside(const ViewPlanes& planes) const noexcept {
  return std::ranges::any_of(planes, [&](const Vector3d& inside) {
    return inside.cwiseProduct(low_).cwiseMax(inside.cwiseProduct(high_)).sum() < 0;
  });
}

bool SupportShadow::hides(const Vector3d& a, const Vector3d& b, Interval& hidden) const noexcept {
  hidden = {0, 1};
  for (std::size_t i = 0; i < count_; ++i) {
    const double at_a = planes_[i].normal.dot(a) - planes_[i].offset;
    const double at_b = planes_[i].normal.dot(b) - planes_[i].offset;
    if (at_a > 0 && at_b > 0) {
      return false;
    }
    if (at_a > 0) {
      hidden.from = std::max(hidden.from, at_a / (at_a - at_b));
    } else if (at_b > 0) {
      hidden.to = std::min(hidden.to, at_a / (at_a - at_b));
    }
  }
  return hidden.from < hidden.to;
}

}  // namespace pipescout::rack_vision
