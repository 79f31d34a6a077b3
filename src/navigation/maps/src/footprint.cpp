// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/footprint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "pipescout/navigation_maps/path.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLargestDistance = 100;  // m
constexpr double kLargestMargin = 10;     // m
constexpr double kSmallestArea = 1e-6;    // m^2
constexpr std::size_t kFewCorners = 32;

Point2d minus(const Point2d& a, const Point2d& b) {
  return {a.x - b.x, a.y - b.y};
}

double cross(const Point2d& a, const Point2d& b) {
  return a.x * b.y - a.y * b.x;
}

double turn(const Point2d& a, const Point2d& b, const Point2d& c) {
  return cross(minus(b, a), minus(c, a));
}

double signed_area(const std::vector<Point2d>& corners) {
  double area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    area += cross(corners[i], corners[(i + 1) % corners.size()]) / 2;
  }
  return area;
}

double distance_to_segment(const Point2d& p, const Point2d& a, const Point2d& b) {
  const Point2d edge = minus(b, a);
  const double squared = edge.x * edge.x + edge.y * edge.y;
  const Point2d to_p = minus(p, a);
  const double along =
      squared > 0 ? std::clamp((to_p.x * edge.x + to_p.y * edge.y) / squared, 0.0, 1.0) : 0.0;
  return distance(p, {a.x + along * edge.x, a.y + along * edge.y});
}

bool on_segment(const Point2d& p, const Point2d& a, const Point2d& b) {
  return turn(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

bool segments_meet(const Point2d& a, const Point2d& b, const Point2d& c, const Point2d& d) {
  const double abc = turn(a, b, c);
  const double abd = turn(a, b, d);
  const double cda = turn(c, d, a);
  const double cdb = turn(c, d, b);
  return ((abc > 0) != (abd > 0) && (cda > 0) != (cdb > 0) && abc != 0 && abd != 0 && cda != 0 &&
          cdb != 0) ||
         on_segment(c, a, b) || on_segment(d, a, b) || on_segment(a, c, d) || on_segment(b, c, d);
}

void check_simple(const std::vector<Point2d>& corners) {
  const std::size_t count = corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Point2d& a = corners[i];
    const Point2d& b = corners[(i + 1) % count];
    const Point2d& after = corners[(i + 2) % count];
    if (a == b || (count > 3 && on_segment(after, a, b)) || on_segment(a, b, after)) {
      validation::refuse("corners: edge ", i, " has no length or is driven back along");
    }
    for (std::size_t j = i + 2; j < count; ++j) {
      if ((j + 1) % count != i && segments_meet(a, b, corners[j], corners[(j + 1) % count])) {
        validation::refuse("corners: edges ", i, " and ", j, " cross or touch");
      }
    }
  }
}

bool is_inside(const std::vector<Point2d>& corners, const Point2d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point2d& a = corners[i];
    const Point2d& b = corners[(i + 1) % corners.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) {
      inside = !inside;
    }
  }
  return inside;
}

bool is_convex(const std::vector<Point2d>& corners) {
  const std::size_t count = corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (turn(corners[i], corners[(i + 1) % count], corners[(i + 2) % count]) < 0) {
      return false;
    }
  }
  return true;
}

bool is_ear(const std::vector<Point2d>& corners, std::size_t i) {
  const std::size_t count = corners.size();
  const Point2d& a = corners[(i + count - 1) % count];
  const Point2d& b = corners[i];
  const Point2d& c = corners[(i + 1) % count];
  if (turn(a, b, c) <= 0) {
    return false;
  }
  return std::none_of(corners.begin(), corners.end(), [&](const Point2d& p) {
    return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 &&
           turn(c, a, p) >= 0;
  });
}

/// Triangles of a counter-clockwise simple polygon by ear clipping (Meisters, "Polygons have
/// ears", 1975).
std::vector<std::vector<Point2d>> convex_parts_of(std::vector<Point2d> corners) {
  std::vector<std::vector<Point2d>> parts;
  while (!is_convex(corners)) {
    std::size_t ear = 0;
    while (ear < corners.size() && !is_ear(corners, ear)) {
      ++ear;
    }
    if (ear == corners.size()) {
      validation::refuse("corners: the polygon is too thin to be cut into triangles");
    }
    const std::size_t count = corners.size();
    parts.push_back({corners[(ear + count - 1) % count], corners[ear], corners[(ear + 1) % count]});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  parts.push_back(std::move(corners));
  return parts;
}

/// The lowest and highest cell index that [low, high] shares a point with, held within the grid
/// plus one cell around it. Cells are closed: a point on an edge belongs to both.
struct CellRange {
  int first;
  int last;
};

CellRange touched(double low, double high, int count) {
  const double first = std::ceil(low) - 1;
  const double last = std::floor(high);
  return {static_cast<int>(std::clamp(first, -1.0, static_cast<double>(count))),
          static_cast<int>(std::clamp(last, -1.0, static_cast<double>(count)))};
}

struct Transform {
  double cosine, sine, x, y;

  Point2d operator()(const Point2d& p) const {
    return {x + cosine * p.x - sine * p.y, y + sine * p.x + cosine * p.y};
  }
};

struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// The columns that a convex polygon covers in each of some rows of a grid, one after the other. A
/// convex polygon's share of a row is convex: it touches all cells from its lowest to its highest
/// x, and no other.
class Rows {
 public:
  static constexpr int kMost = 64;

  Rows(const CellRange& range, double margin)
      : first_(range.first), count_(range.last - range.first + 1), margin_(margin) {
    std::fill_n(columns_.begin(), static_cast<std::size_t>(count_), Interval{});
  }
  void add_segment(const Point2d& a, const Point2d& b) {
    const Point2d& lower = a.y <= b.y ? a : b;
    const Point2d& upper = a.y <= b.y ? b : a;
    const double height = upper.y - lower.y;
    const double slope = height > 0 ? (upper.x - lower.x) / height : 0;
    // Rows are closed: an end on an edge belongs to both.
    const double from = std::ceil(lower.y - margin_) - 1 - first_;
    const double to = std::floor(upper.y + margin_) - first_;
    const int last = static_cast<int>(std::clamp(to, -1.0, count_ - 1.0));
    for (int row = static_cast<int>(std::clamp(from, 0.0, count_ + 0.0)); row <= last; ++row) {
      const double bottom = first_ + row - margin_;
      const double top = first_ + row + 1 + margin_;
      Interval& columns = columns_[static_cast<std::size_t>(row)];
      columns.add(lower.y >= bottom ? lower.x : lower.x + (bottom - lower.y) * slope);
      columns.add(upper.y <= top ? upper.x : lower.x + (top - lower.y) * slope);
    }
  }
  [[nodiscard]] const Interval& columns(int row) const {
    return columns_[static_cast<std::size_t>(row - first_)];
  }

 private:
  int first_;
  int count_;
  double margin_;
  std::array<Interval, kMost> columns_;
};

/// Corners on their way into a grid: on the stack, but for polygons of very many.
class CornerBuffer {
 public:
  explicit CornerBuffer(std::size_t count) : count_(count) {
    if (count > few_.size()) {
      many_.resize(count);
    }
  }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] Point2d* begin() { return many_.empty() ? few_.data() : many_.data(); }
  [[nodiscard]] Point2d* end() { return begin() + count_; }

 private:
  std::size_t count_;
  std::array<Point2d, kFewCorners> few_;
  std::vector<Point2d> many_;
};

/// Whether a row of the grid has a blocked cell in the range, which may go one beyond its ends.
bool is_row_blocked(const OccupancyGrid& grid, int row, const CellRange& range,
                    bool unknown_blocks) {
  const bool outside =
      row < 0 || row >= grid.height() || range.first < 0 || range.last >= grid.width();
  if (outside && unknown_blocks) {
    return range.first <= range.last;
  }
  if (row < 0 || row >= grid.height()) {
    return false;
  }
  const CellState* const cells = grid.cells().data() + grid.index({0, row});
  const CellState* const first = cells + std::max(range.first, 0);
  const CellState* const last = cells + std::min(range.last, grid.width() - 1) + 1;
  return std::any_of(first, std::max(first, last), [&](CellState state) {
    return state == CellState::kOccupied || (unknown_blocks && state == CellState::kUnknown);
  });
}

/// Whether a convex polygon, enlarged by `margin` cells or a little more, shares a point with a
/// blocked cell. `for_each_segment` gives segments of which it is the hull.
template <typename ForEachSegment>
bool hull_collides(CornerBuffer& corners, double margin, const OccupancyGrid& grid,
                   bool unknown_blocks, const ForEachSegment& for_each_segment) {
  Interval rows;
  for (const Point2d& corner : corners) {
    rows.add(corner.y);
  }
  const CellRange range = touched(rows.low - margin, rows.high + margin, grid.height());
  for (int first = range.first; first <= range.last; first += Rows::kMost) {
    const int last = std::min(range.last, first + Rows::kMost - 1);
    Rows covered({first, last}, margin);
    for_each_segment([&](const Point2d& a, const Point2d& b) { covered.add_segment(a, b); });
    for (int row = first; row <= last; ++row) {
      const Interval& columns = covered.columns(row);
      if (columns.low <= columns.high &&
          is_row_blocked(grid, row,
                         touched(columns.low - margin, columns.high + margin, grid.width()),
                         unknown_blocks)) {
        return true;
      }
    }
  }
  return false;
}

Transform into_grid(const OccupancyGrid& grid, const Pose2d& T_map_robot) {
  const Pose2d pose = grid.to_grid(T_map_robot);
  const double scale = 1 / grid.resolution();
  return {scale * std::cos(pose.heading), scale * std::sin(pose.heading), pose.x, pose.y};
}

bool part_collides(const std::vector<Point2d>& part, const Transform& transform,
                   const OccupancyGrid& grid, bool unknown_blocks) {
  CornerBuffer corners(part.size());
  std::transform(part.begin(), part.end(), corners.begin(), transform);
  return hull_collides(corners, 0, grid, unknown_blocks, [&](const auto& take) {
    const Point2d* before = corners.end() - 1;
    for (const Point2d& corner : corners) {
      take(*before, corner);
      before = &corner;
    }
  });
}

/// The convex hull as a closed line, whose first corner is its last one too (Andrew, "Another
/// efficient algorithm for convex hulls in two dimensions", 1979). Sorts the corners. Returns where
/// the hull ends; `hull` has room for twice the corners.
const Point2d* hull_of(CornerBuffer& corners, CornerBuffer& hull) {
  std::sort(corners.begin(), corners.end(), [](const Point2d& a, const Point2d& b) {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
  });
  Point2d* end = hull.begin();
  const auto add = [&](const Point2d& corner, const Point2d* first) {
    while (end - first >= 2 && turn(end[-2], end[-1], corner) <= 0) {
      --end;
    }
    *end++ = corner;
  };
  for (const Point2d& corner : corners) {
    add(corner, hull.begin());
  }
  // Back along the other side, from the highest corner on.
  const Point2d* const highest = end - 1;
  for (const Point2d* corner = corners.end() - 1; corner-- > corners.begin();) {
    add(*corner, highest);
  }
  return end;
}

bool hull_of_both_collides(const std::vector<Point2d>& part, const Transform& from,
                           const Transform& to, double margin, const OccupancyGrid& grid,
                           bool unknown_blocks) {
  CornerBuffer corners(2 * part.size());
  std::transform(part.begin(), part.end(), corners.begin(), from);
  std::transform(part.begin(), part.end(),
                 corners.begin() + static_cast<std::ptrdiff_t>(part.size()), to);
  CornerBuffer hull(2 * corners.size());
  const Point2d* const end = hull_of(corners, hull);
  return hull_collides(corners, margin, grid, unknown_blocks, [&](const auto& take) {
    for (const Point2d* corner = hull.begin() + 1; corner < end; ++corner) {
      take(corner[-1], corner[0]);
    }
  });
}

bool separated_along_an_edge_of(const std::vector<Point2d>& a, const Pose2d& T_map_a,
                                const std::vector<Point2d>& b, const Pose2d& T_map_b) {
  const Pose2d T_a_b = relative(T_map_a, T_map_b);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Point2d& from = a[i];
    const Point2d& to = a[(i + 1) % a.size()];
    if (std::all_of(b.begin(), b.end(),
                    [&](const Point2d& p) { return turn(from, to, transform(T_a_b, p)) < 0; })) {
      return true;
    }
  }
  return false;
}

}  // namespace

Footprint::Footprint(std::vector<Point2d> corners) : corners_(std::move(corners)) {
  if (signed_area(corners_) < 0) {
    std::reverse(corners_.begin(), corners_.end());
  }
  parts_ = convex_parts_of(corners_);
  inscribed_radius_ = is_inside(corners_, {}) ? std::numeric_limits<double>::infinity() : 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Point2d& next = corners_[(i + 1) % corners_.size()];
    circumscribed_radius_ = std::max(circumscribed_radius_, distance(corners_[i], {}));
    inscribed_radius_ = std::min(inscribed_radius_, distance_to_segment({}, corners_[i], next));
  }
}

Footprint Footprint::rectangle(double front, double rear, double width) {
  validation::check_within("front", front, -kLargestDistance, kLargestDistance);
  validation::check_within("rear", rear, -kLargestDistance, kLargestDistance);
  validation::check_above("front + rear", front + rear, 0, kLargestDistance);
  validation::check_above("width", width, 0, kLargestDistance);
  return polygon(
      {{-rear, -width / 2}, {front, -width / 2}, {front, width / 2}, {-rear, width / 2}});
}

Footprint Footprint::polygon(std::vector<Point2d> corners) {
  if (corners.size() < 3) {
    validation::refuse("corners: ", corners.size(), " given; a polygon has at least 3");
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::string name = "corners[" + std::to_string(i) + "]";
    validation::check_within(name, corners[i].x, -kLargestDistance, kLargestDistance);
    validation::check_within(name, corners[i].y, -kLargestDistance, kLargestDistance);
  }
  if (std::abs(signed_area(corners)) < kSmallestArea) {
    validation::refuse("corners: the polygon has an area of ", std::abs(signed_area(corners)),
                       " m^2; it must be at least ", kSmallestArea);
  }
  check_simple(corners);
  return Footprint(std::move(corners));
}

Footprint Footprint::inflated(double margin) const {
  validation::check_within("margin", margin, 0, kLargestMargin);
  const std::size_t count = corners_.size();
  std::vector<Point2d> moved(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Point2d in = minus(corners_[i], corners_[(i + count - 1) % count]);
    const Point2d out = minus(corners_[(i + 1) % count], corners_[i]);
    const double in_length = std::hypot(in.x, in.y);
    const double out_length = std::hypot(out.x, out.y);
    const Point2d in_normal{in.y / in_length, -in.x / in_length};
    const Point2d out_normal{out.y / out_length, -out.x / out_length};
    const double cosine = in_normal.x * out_normal.x + in_normal.y * out_normal.y;
    const double scale = margin / (1 + cosine);
    moved[i] = {corners_[i].x + scale * (in_normal.x + out_normal.x),
                corners_[i].y + scale * (in_normal.y + out_normal.y)};
  }
  return polygon(std::move(moved));
}

bool collides(const Footprint& footprint, const OccupancyGrid& grid, const Pose2d& T_map_robot,
              UnknownCells unknown) {
  if (!is_finite(T_map_robot)) {
    return true;
  }
  const Transform transform = into_grid(grid, T_map_robot);
  const bool unknown_blocks = unknown == UnknownCells::kBlocked;
  return std::any_of(footprint.convex_parts().begin(), footprint.convex_parts().end(),
                     [&](const std::vector<Point2d>& part) {
                       return part_collides(part, transform, grid, unknown_blocks);
                     });
}

bool may_collide_along(const Footprint& footprint, const OccupancyGrid& grid,
                       const Pose2d& T_map_robot, double curvature, double length,
                       UnknownCells unknown) {
  const Pose2d end = drive_arc(T_map_robot, curvature, length);
  if (!is_finite(T_map_robot) || !is_finite(end)) {
    return true;
  }
  // Each point moves on an arc whose radius is at most this; the arc is within its height of the
  // chord, and the chord within the hull.
  const double turn = std::abs(curvature * length);
  const double height = turn > 0 ? (1 / std::abs(curvature) + footprint.circumscribed_radius()) *
                                       (1 - std::cos(std::min(turn, std::numbers::pi) / 2))
                                 : 0;
  const Transform from = into_grid(grid, T_map_robot);
  const Transform to = into_grid(grid, end);
  const bool unknown_blocks = unknown == UnknownCells::kBlocked;
  return turn > std::numbers::pi ||
         std::any_of(footprint.convex_parts().begin(), footprint.convex_parts().end(),
                     [&](const std::vector<Point2d>& part) {
                       return hull_of_both_collides(part, from, to, height / grid.resolution(),
                                                    grid, unknown_blocks);
                     });
}

bool overlap(const Footprint& a, const Pose2d& T_map_a, const Footprint& b, const Pose2d& T_map_b) {
  for (const auto& part_a : a.convex_parts()) {
    for (const auto& part_b : b.convex_parts()) {
      if (!separated_along_an_edge_of(part_a, T_map_a, part_b, T_map_b) &&
          !separated_along_an_edge_of(part_b, T_map_b, part_a, T_map_a)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace pipescout::navigation
