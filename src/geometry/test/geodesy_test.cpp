// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/geodesy.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace pipescout::geometry {
namespace {

// WGS 84: semi-major axis and flattening (NIMA TR8350.2, table 3.1).
constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

rc::Gen<double> in(double low, double high) {
  return rc::gen::map(rc::gen::inRange(0, 1000001),
                      [=](int share) { return low + (high - low) * share / 1e6; });
}

TEST(LocalFrame, DatumIsItsOrigin) {
  const LocalFrame frame({47.1, 8.4, 512.0});
  EXPECT_LT(frame.position(frame.datum()).norm(), 1e-8);
  EXPECT_LT((frame.axes_at(frame.datum()) - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(LocalFrame, AxesAreEastNorthUp) {
  const LocalFrame frame({37.72, -122.47, 33.0});
  EXPECT_NEAR(frame.position({37.72, -122.47, 43.0}).z(), 10.0, 1e-8);
  EXPECT_GT(frame.position({37.72, -122.469, 33.0}).x(), 80.0);
  EXPECT_GT(frame.position({37.721, -122.47, 33.0}).y(), 100.0);
}

// The radii of curvature of the ellipsoid in closed form.
TEST(LocalFrame, DegreesAreAsLongAsTheEllipsoidMakesThem) {
  constexpr double kLatitude = 47.0;
  constexpr double kStep = 1e-5;
  const double sine = std::sin(kLatitude * M_PI / 180);
  const double w = 1 - kEccentricity2 * sine * sine;
  const double meridian = kSemiMajor * (1 - kEccentricity2) / std::pow(w, 1.5);
  const double normal = kSemiMajor / std::sqrt(w);
  const LocalFrame frame({kLatitude, 8.0, 0.0});
  EXPECT_NEAR(frame.position({kLatitude + kStep, 8.0, 0.0}).y(), meridian * kStep * M_PI / 180,
              1e-6);
  EXPECT_NEAR(frame.position({kLatitude, 8.0 + kStep, 0.0}).x(),
              normal * std::cos(kLatitude * M_PI / 180) * kStep * M_PI / 180, 1e-6);
}

TEST(LocalFrame, EarthCurvesAway) {
  const LocalFrame frame({0.0, 0.0, 0.0});
  const Eigen::Vector3d far = frame.position({0.0, 1.0, 0.0});
  EXPECT_NEAR(far.x(), kSemiMajor * std::sin(M_PI / 180), 1e-6);
  EXPECT_NEAR(far.z(), kSemiMajor * (std::cos(M_PI / 180) - 1), 1e-6);
  // East there points down here.
  EXPECT_NEAR(frame.axes_at({0.0, 1.0, 0.0})(2, 0), -std::sin(M_PI / 180), 1e-12);
}

TEST(LocalFrame, GeocentricPlacesOnTheAxes) {
  const LocalFrame frame({90.0, 0.0, 0.0});
  const double polar = kSemiMajor * (1 - kFlattening);
  EXPECT_LT(frame.from_geocentric({0, 0, polar}).norm(), 1e-8);
  EXPECT_NEAR(frame.from_geocentric({0, 0, polar + 5}).z(), 5.0, 1e-8);
}

RC_GTEST_PROP(LocalFrame, ThereAndBack, ()) {
  const LocalFrame frame({*in(-89, 89), *in(-180, 180), *in(-100, 3000)});
  const Eigen::Vector3d place(*in(-20000, 20000), *in(-20000, 20000), *in(-500, 500));
  RC_ASSERT((frame.position(frame.geodetic(place)) - place).norm() < 1e-7);
  const Eigen::Matrix3d axes = frame.axes_at(frame.geodetic(place));
  RC_ASSERT((axes * axes.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
}

void expect_refused(const GeodeticPosition& position, const std::string& field) {
  try {
    const LocalFrame frame(position);
    FAIL() << field << " was not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(field));
  }
}

TEST(LocalFrame, RefusesPlacesThatAreNone) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  expect_refused({91, 0, 0}, "latitude");
  expect_refused({kNaN, 0, 0}, "latitude");
  expect_refused({0, 541, 0}, "longitude");
  expect_refused({0, kNaN, 0}, "longitude");
  expect_refused({0, 0, kNaN}, "altitude");
  expect_refused({0, 0, 1e9}, "altitude");
  EXPECT_THROW((void)LocalFrame({}).geodetic({kNaN, 0, 0}), std::invalid_argument);
  EXPECT_THROW((void)LocalFrame({}).position({-91, 0, 0}), std::invalid_argument);
}

TEST(StraightDistance, IsThatOfTheLocalFrame) {
  const GeodeticPosition a{.latitude = 47.4, .longitude = 179.99, .altitude = 300};
  const GeodeticPosition b{.latitude = 47.5, .longitude = -179.98, .altitude = 420};
  EXPECT_NEAR(straight_distance(a, b), LocalFrame(a).position(b).norm(), 1e-7);
  EXPECT_EQ(straight_distance(a, a), 0);
}

}  // namespace
}  // namespace pipescout::geometry
