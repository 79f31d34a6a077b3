// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Lacks the periods.
struct Incomplete {
  static constexpr std::size_t kSize = 1;
  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return d[0];
  }
  void validate() const {}
};
static_assert(!ShapeModel<Incomplete>);

/// Its distance does not take float.
struct OnlyDouble {
  static constexpr std::size_t kSize = 1;
  static constexpr std::array<double, kSize> kPeriods{0};
  [[nodiscard]] double distance(const std::array<double, kSize>& d) const { return d[0]; }
  void validate() const {}
};
static_assert(!ShapeModel<OnlyDouble>);

TEST(Shapes, DistanceOfAPipeIsEquation14) {
  const PipeShape pipe{.lambda = 2, .beta = 0.5, .gamma = 10};
  EXPECT_DOUBLE_EQ(pipe.distance(std::array{3.0, -4.0, 2.0, 0.1}), 2 * 5 + 0.5 * 4 + 10 * 0.01);
  EXPECT_FLOAT_EQ(pipe.distance(std::array{3.0F, -4.0F, 2.0F, 0.1F}), 12.1F);
}

TEST(Shapes, DistancesOfValvesAndVessels) {
  const ValveShape valve{.lambda = 2, .beta = 0.5};
  EXPECT_DOUBLE_EQ(valve.distance(std::array{3.0, 4.0, -2.0}), 12);
  const VesselShape vessel{.lambda = 2, .beta = 0.5, .gamma = 10};
  EXPECT_DOUBLE_EQ(vessel.distance(std::array{3.0, 4.0, 2.0, -1.0, 0.1}), 10 + 0.5 * 5 + 0.1);
}

TEST(Shapes, WeightsMustBeAboveZero) {
  EXPECT_THAT([] { PipeShape{.gamma = 0}.validate(); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("gamma: 0")));
  EXPECT_THAT([] { ValveShape{.lambda = -1}.validate(); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("lambda: -1")));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([nan] { VesselShape{.beta = nan}.validate(); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("beta: nan")));
  EXPECT_NO_THROW(PipeShape{}.validate());
}

}  // namespace
}  // namespace pipescout::tracking
