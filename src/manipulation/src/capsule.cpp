// SPDX-License-Identifier: Apache-2.0
#include "capsule.hpp"

#include <algorithm>

namespace pipescout::manipulation::internal {
namespace {

constexpr double kPoint = 1e-18;  // m^2: of a line so short that it is a point

double share(double part, double whole) {
  return std::clamp(part / whole, 0.0, 1.0);
}

}  // namespace

double distance(const Capsule& a, const Capsule& b) noexcept {
  // The points a.from + s da and b.from + t db that are closest: s is best on endless lines, then
  // t for this s, and where t leaves the line, s for the end of it.
  const Eigen::Vector3d da = a.to - a.from;
  const Eigen::Vector3d db = b.to - b.from;
  const Eigen::Vector3d apart = a.from - b.from;
  const double aa = da.squaredNorm();
  const double bb = db.squaredNorm();
  const double ab = da.dot(db);
  const double along_a = da.dot(apart);
  const double along_b = db.dot(apart);
  double s = 0;
  double t = 0;
  if (aa <= kPoint) {
    t = bb <= kPoint ? 0 : share(along_b, bb);
  } else if (bb <= kPoint) {
    s = share(-along_a, aa);
  } else {
    const double cross = aa * bb - ab * ab;
    // Where they are parallel every s is as good.
    s = cross > kPoint * aa * bb ? share(ab * along_b - along_a * bb, cross) : 0;
    const double free = (ab * s + along_b) / bb;
    t = std::clamp(free, 0.0, 1.0);
    if (t != free) {
      s = share(t * ab - along_a, aa);
    }
  }
  return (apart + s * da - t * db).norm() - a.radius - b.radius;
}

}  // namespace pipescout::manipulation::internal
