// SPDX-License-Identifier: Apache-2.0
#include "capsule.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

namespace pipescout::manipulation::internal {
namespace {

using Eigen::Vector3d;

Vector3d any_point() {
  const auto coordinate = [] { return *rc::gen::inRange(-20, 21) * 0.1; };
  const double x = coordinate();
  const double y = coordinate();
  return {x, y, coordinate()};
}

/// By trying points of both lines.
double searched(const Capsule& a, const Capsule& b) {
  constexpr int kSteps = 400;
  double least = 1e9;
  for (int i = 0; i <= kSteps; ++i) {
    const Vector3d p = a.from + (a.to - a.from) * (i / double{kSteps});
    // The closest point of the other line is known.
    const Vector3d along = b.to - b.from;
    const double square = along.squaredNorm();
    const double t = square > 0 ? std::clamp((p - b.from).dot(along) / square, 0.0, 1.0) : 0;
    least = std::min(least, (p - b.from - t * along).norm());
  }
  return least - a.radius - b.radius;
}

RC_GTEST_PROP(Capsule, DistanceIsTheLeastBetweenAnyPoints, ()) {
  // Points lie on a grid of 0.1 m, so that lines are often parallel, meet, or are points.
  const Capsule a{.from = any_point(), .to = any_point(), .radius = 0.1};
  const Capsule b{.from = any_point(), .to = any_point(), .radius = 0.05};
  const double found = distance(a, b);
  const double tried = searched(a, b);
  RC_ASSERT(found <= tried + 1e-9);
  RC_ASSERT(found >= tried - (a.to - a.from).norm() / 400);
  RC_ASSERT(std::abs(found - distance(b, a)) < 1e-9);
}

TEST(Capsule, SpheresOverlap) {
  const Capsule a{.radius = 0.5};
  const Capsule b{.from = {0.6, 0, 0}, .to = {0.6, 0, 0}, .radius = 0.3};
  EXPECT_NEAR(distance(a, b), -0.2, 1e-12);
}

}  // namespace
}  // namespace pipescout::manipulation::internal
