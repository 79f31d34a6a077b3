// SPDX-License-Identifier: Apache-2.0
// What pipes, valves and vessels are in a picture, and what is read off their regions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {
namespace {

using Eigen::Vector2d;
using State = PipeShape::State;

constexpr ImageSize kImage{.width = 320, .height = 240};
constexpr double kPi = std::numbers::pi;

PipeRegion region_of(const State& state) {
  const Vector2d half = state[2] / 2 * Vector2d(std::cos(state[3]), std::sin(state[3]));
  return {.start = state.head<2>() - half, .end = state.head<2>() + half, .half_width = 6};
}

ObservationRows<4> rows_of(const PipeRegion& region, const State& predicted, double deviation = 1) {
  ObservationRows<4> rows;
  PipeShape{}.observe(region, predicted, deviation * deviation * PipeShape::Covariance::Identity(),
                      kImage, rows);
  return rows;
}

TEST(PipeInPicture, IsCutAtItsBorder) {
  const auto level = PipeShape::in_view({150, 100, 1000, 0}, kImage);
  EXPECT_TRUE(level.in_view && level.start_censored && level.end_censored);
  EXPECT_LT((level.shape - State(159.5, 100, 319, 0)).norm(), 1e-9);
  const auto left = PipeShape::in_view({0, 100, 100, 0}, kImage);
  EXPECT_TRUE(left.start_censored);
  EXPECT_FALSE(left.end_censored);
  EXPECT_LT((left.shape - State(25, 100, 50, 0)).norm(), 1e-9);
  // Along the diagonal: the upper end leaves through the upper border.
  const auto slant = PipeShape::in_view({10, 10, 100, kPi / 4}, kImage);
  EXPECT_NEAR(slant.shape[2], 50 + 10 * std::numbers::sqrt2, 1e-9);
  const auto upright = PipeShape::in_view({100, 230, 100, kPi / 2}, kImage);
  EXPECT_TRUE(upright.end_censored);
  EXPECT_NEAR(upright.shape[2], 59, 1e-9);
}

TEST(PipeInPicture, OutsideItIsTheWhole) {
  for (const State& state :
       {State(150, -3, 100, 0), State(500, 100, 100, 0.3), State(-30, 100, 10, 1.5)}) {
    const auto view = PipeShape::in_view(state, kImage);
    EXPECT_FALSE(view.in_view || view.start_censored || view.end_censored);
    EXPECT_EQ(view.shape, state);
  }
}

RC_GTEST_PROP(PipeInPicture, WhatIsInViewIsOnTheAxisAndNoLonger, ()) {
  const auto in = [](int low, int high) { return *rc::gen::inRange(low, high) / 10.0; };
  const State state(in(-4000, 8000), in(-4000, 8000), in(1, 9000), in(-15, 16));
  const auto view = PipeShape::in_view(state, kImage);
  const Vector2d u(std::cos(state[3]), std::sin(state[3]));
  const Vector2d away = view.shape.head<2>() - state.head<2>();
  RC_ASSERT(std::abs(away.x() * u.y() - away.y() * u.x()) < 1e-6);
  RC_ASSERT(view.shape[2] <= state[2] + 1e-9);
  if (view.in_view) {
    for (const double side : {-0.5, 0.5}) {
      const Vector2d end = view.shape.head<2>() + side * view.shape[2] * u;
      RC_ASSERT(end.x() > -1e-6 && end.y() > -1e-6 && end.x() < 319 + 1e-6 && end.y() < 239 + 1e-6);
    }
  }
}

RC_GTEST_PROP(PipeRegionReadings, AreLinearInTheShape, ()) {
  const auto in = [](int low, int high) { return *rc::gen::inRange(low, high) / 100.0; };
  const State truth(in(10000, 20000), in(9000, 15000), in(4000, 9000), in(-150, 151));
  const PipeRegion region = region_of(truth);
  const auto at_truth = rows_of(region, truth);
  for (const auto& row : at_truth.all()) {
    RC_ASSERT(std::abs(row.residual) < 1e-9);
  }
  const State away(in(-200, 200), in(-200, 200), in(-200, 200), in(-1, 2));
  const State predicted = truth - away;
  const auto rows = rows_of(region, predicted);
  RC_ASSERT(rows.all().size() == 4U);
  for (const auto& row : rows.all()) {
    // Second order: an angle of 0.02 over half of 90 px, and displacements of 3 px.
    RC_ASSERT(std::abs(row.residual - row.gradient.dot(away)) < 0.1);
  }
}

TEST(PipeRegionReadings, AnEndAtTheBorderSaysThatThePipeGoesAtLeastSoFar) {
  // Goes on beyond the right border, as is predicted: no reading of that end.
  const PipeRegion cut{.start = {100, 80}, .end = {319, 80}, .half_width = 6};
  EXPECT_EQ(rows_of(cut, {300, 80, 400, 0}).all().size(), 3U);
  // Predicted to end before it, at 250: it is anywhere beyond.
  const State predicted(175, 80, 150, 0);
  const auto rows = rows_of(cut, predicted);
  ASSERT_EQ(rows.all().size(), 4U);
  const auto& beyond = rows.all()[3];
  EXPECT_TRUE(beyond.bound);
  EXPECT_NEAR(beyond.residual, 69 + 400, 1e-9);
  EXPECT_NEAR(beyond.gradient.dot(beyond.slack), 800, 1e-9) << "two diagonals, of this end";
  EXPECT_NEAR(rows.all()[2].gradient.dot(beyond.slack), 0, 1e-9) << "and of no other";
  EXPECT_TRUE(rows.all()[2].doubtful) << "an end within the picture may be a post's";
}

TEST(PipeRegionReadings, OfAnEndThatIsUncertainNothingIsClaimed) {
  const PipeRegion cut{.start = {100, 80}, .end = {319, 80}, .half_width = 6};
  const auto rows = rows_of(cut, {300, 80, 400, 0}, 100);
  ASSERT_EQ(rows.all().size(), 4U);
  EXPECT_TRUE(rows.all()[3].bound);
  EXPECT_NEAR(rows.all()[3].residual, 319 + 400 - 500, 1e-9);
}

TEST(PipeRegionReadings, BeforeAPostNearTheBorderAPipeThatIsOpenDoesNotEnd) {
  // What is left of it beyond a post at 305 is too short to be found.
  const PipeRegion before{.start = {100, 80}, .end = {305, 80}, .half_width = 6};
  const auto open = rows_of(before, {300, 80, 400, 0}, 100);
  ASSERT_EQ(open.all().size(), 4U);
  EXPECT_TRUE(open.all()[3].bound);
  const auto known = rows_of(before, {200, 80, 202, 0}, 2);
  ASSERT_EQ(known.all().size(), 4U);
  EXPECT_TRUE(known.all()[3].doubtful) << "it was known to end about there";
}

TEST(PipeRegionReadings, AnEndThatIsFarOutsideIsKeptWithinReach) {
  const PipeRegion cut{.start = {100, 80}, .end = {319, 80}, .half_width = 6};
  EXPECT_EQ(rows_of(cut, {500, 80, 800, 0}).all().size(), 3U);
  const auto rows = rows_of(cut, {1000, 80, 1800, 0});
  ASSERT_EQ(rows.all().size(), 4U);
  EXPECT_TRUE(rows.all()[3].bound);
  EXPECT_NEAR(rows.all()[3].residual, 319 + 400 - 1900, 1e-9) << "back to a diagonal beyond";
}

TEST(PipeRegionReadings, WhileAPipeIsNotFoundItsOpenEndsStayBeyondTheBorder) {
  ObservationRows<4> rows;
  // From 60 on to 310 in the picture; the end to the right is uncertain, or both are known.
  const State predicted(185, 80, 250, 0);
  PipeShape::Covariance covariance = PipeShape::Covariance::Identity();
  PipeShape{}.keep_open(predicted, covariance, kImage, rows);
  EXPECT_TRUE(rows.all().empty());
  Eigen::Vector4d open(100, 0, 200, 0);  // moves the right end only
  covariance += open * open.transpose();
  PipeShape{}.keep_open(predicted, covariance, kImage, rows);
  ASSERT_EQ(rows.all().size(), 1U);
  EXPECT_TRUE(rows.all()[0].bound);
  EXPECT_NEAR(rows.all()[0].residual, 9 + 400, 1e-9) << "a diagonal beyond the right border";
  // Where it is far beyond it, or the axis is not in the picture, nothing is to be kept.
  PipeShape{}.keep_open({385, 80, 650, 0}, covariance, kImage, rows);
  EXPECT_TRUE(rows.all().empty());
  PipeShape{}.keep_open({185, -50, 250, 0}, covariance, kImage, rows);
  EXPECT_TRUE(rows.all().empty());
}

TEST(PipeRegionReadings, TheAxisOfWhatIsCutLengthwiseIsUncertain) {
  PipeRegion region{.start = {50, 4}, .end = {250, 4}, .half_width = 4};
  const double before = rows_of(region, {150, 4, 200, 0}).all()[0].variance;
  region.cut_along = true;
  EXPECT_NEAR(rows_of(region, {150, 4, 200, 0}).all()[0].variance, before + 16, 1e-9);
}

TEST(PipeRegionReadings, HeadAndTailAreTheSame) {
  PipeRegion region = region_of({150, 100, 90, 0.4});
  const State predicted(151, 99, 94, 0.42 - kPi);
  const auto forwards = rows_of(region, predicted);
  std::swap(region.start, region.end);
  const auto backwards = rows_of(region, predicted);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(forwards.all()[i].residual, backwards.all()[i].residual, 1e-9);
    EXPECT_LT(std::abs(forwards.all()[i].residual), 4);
  }
}

TEST(Shapes, ScaleWithThePicture) {
  // Twice as many pixels: the middle of the first pixel moves from 0 to 0.5.
  EXPECT_LT((PipeShape::scaled({0, 10, 30, 0.4}, 2) - State(0.5, 20.5, 60, 0.4)).norm(), 1e-12);
  EXPECT_LT((ValveShape::scaled({0, 10, 30}, 2) - Eigen::Vector3d(0.5, 20.5, 60)).norm(), 1e-12);
  VesselShape::State vessel;
  vessel << 0, 10, 30, 20, 0.4;
  VesselShape::State scaled;
  scaled << 0.5, 20.5, 60, 40, 0.4;
  EXPECT_LT((VesselShape::scaled(vessel, 2) - scaled).norm(), 1e-12);
}

TEST(Shapes, ValvesAndVesselsAreInViewWithTheirMiddle) {
  EXPECT_TRUE(ValveShape::in_view({10, 10, 30}, kImage).in_view);
  EXPECT_FALSE(ValveShape::in_view({-1, 10, 30}, kImage).in_view);
  VesselShape::State vessel;
  vessel << 319.5, 10, 30, 20, 0.4;
  EXPECT_FALSE(VesselShape::in_view(vessel, kImage).in_view);
}

}  // namespace
}  // namespace pipescout::tracking
