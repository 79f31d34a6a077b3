// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/radiometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "camera_helpers.hpp"

namespace pipescout::thermal {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(PlanckConstants, BlackBodyIsTheFormula) {
  const PlanckConstants p = test::sc660().planck;
  EXPECT_NEAR(p.counts(30), p.r1 / (p.r2 * (std::exp(p.b / 303.15) - p.f)) - p.o, 1e-9);
  EXPECT_NEAR(p.temperature(p.counts(30)), 30, 1e-10);
  EXPECT_NEAR(p.slope(30), (p.counts(30.001) - p.counts(29.999)) / 0.002, 1e-5);
}

TEST(PlanckConstants, NoCountsAtAbsoluteZeroOrBeyondThePole) {
  PlanckConstants p = test::sc660().planck;
  EXPECT_TRUE(std::isnan(p.counts(-273.15)));
  EXPECT_TRUE(std::isnan(p.slope(-300)));
  EXPECT_NEAR(p.counts(-272), -p.o, 1e-9);
  p.f = 2;  // the pole lies at b / ln 2 kelvin
  EXPECT_TRUE(std::isnan(p.counts(p.b / std::log(2.0) - kZeroCelsius + 1)));
  EXPECT_FALSE(std::isnan(p.counts(p.b / std::log(2.0) - kZeroCelsius - 1)));
}

TEST(PlanckConstants, NoTemperatureWithoutSignal) {
  PlanckConstants p = test::sc660().planck;
  EXPECT_TRUE(std::isnan(p.temperature(-p.o)));
  EXPECT_TRUE(std::isnan(p.temperature(-p.o - 1)));
  EXPECT_TRUE(std::isnan(p.temperature(kInfinity)));
  EXPECT_TRUE(std::isnan(p.temperature(kNaN)));
  p.f = 0.5;  // half the signal of infinite heat, and more, has none either
  EXPECT_TRUE(std::isnan(p.temperature(2 * p.r1 / p.r2 - p.o)));
}

TEST(Radiometry, BlackBodyCloseByIsPlanckAlone) {
  const Radiometry radiometry(test::sc660(), {.emissivity = 1, .distance = 0});
  EXPECT_DOUBLE_EQ(radiometry.transmission(), 1);
  EXPECT_NEAR(radiometry.counts(40), test::sc660().planck.counts(40), 1e-9);
  EXPECT_NEAR(radiometry.temperature(20000), test::sc660().planck.temperature(20000), 1e-10);
}

TEST(Radiometry, AllAtOneTemperatureIsABlackBody) {
  // An object as warm as all that it reflects and is seen through looks black.
  for (const AirPath path : {AirPath::kBeforeWindow, AirPath::kWindowMidway}) {
    const Radiometry radiometry(test::sc660(path), {.emissivity = 0.3,
                                                    .reflected_temperature = 25,
                                                    .distance = 40,
                                                    .atmospheric_temperature = 25,
                                                    .relative_humidity = 0.8,
                                                    .window_temperature = 25,
                                                    .window_transmission = 0.6});
    EXPECT_NEAR(radiometry.counts(25), test::sc660().planck.counts(25), 1e-8) << to_string(path);
  }
}

TEST(Radiometry, ThoseWhoExportedTheSamePictureGotTheseTemperatures) {
  // Counts of the real iguana_sc660.jpg and what FLIR R&D Software printed for them: with the
  // emissivity that is in the file, to 0.001 K.
  const Radiometry radiometry(test::sc660(), {});
  EXPECT_NEAR(radiometry.temperature(18246), 24.615, 6e-4);
  EXPECT_NEAR(radiometry.temperature(20118), 34.703, 6e-4);
  EXPECT_NEAR(radiometry.temperature(22521), 46.375, 6e-4);
}

TEST(Radiometry, TheAirOfThatPicture) {
  EXPECT_NEAR(Radiometry(test::sc660(), {}).transmission(), 0.99394, 1e-5);
  EXPECT_NEAR(Radiometry(test::sc660(AirPath::kWindowMidway), {}).transmission(), 0.99146, 1e-5);
  EXPECT_NEAR(water_content(20, 0.5), 8.564, 1e-3);
}

TEST(Radiometry, BelowTheReflectedShareThereIsNoTemperature) {
  // With the paper's emissivity of 0.04, the reflection of 10 degC makes nearly all counts of a
  // cold tube: one that is colder than absolute zero would be needed for less.
  const Radiometry radiometry(test::sc660(), ibarguren2013_object());
  const double floor = radiometry.floor_counts();
  EXPECT_TRUE(std::isnan(radiometry.temperature(floor - 1)));
  EXPECT_TRUE(std::isnan(radiometry.temperature(floor - 1e-6)));
  EXPECT_FALSE(std::isnan(radiometry.temperature(floor + 1)));
  EXPECT_GT(floor, test::sc660().planck.counts(-20));
  EXPECT_TRUE(std::isnan(radiometry.sensitivity(floor - 1).emissivity));
  EXPECT_NEAR(radiometry.temperature(radiometry.counts(300)), 300, 1e-8);
}

TEST(Radiometry, PresetIsSection5) {
  const ObjectParameters object = ibarguren2013_object();
  EXPECT_DOUBLE_EQ(object.emissivity, 0.04);
  EXPECT_DOUBLE_EQ(object.reflected_temperature, 10);
  EXPECT_DOUBLE_EQ(object.distance, 10);
}

struct BadObject {
  ObjectParameters object;
  const char* message;
};

TEST(Radiometry, NamesWhatIsOutOfRange) {
  const BadObject bad[] = {
      {{.emissivity = 0}, "emissivity: 0 is outside (0, 1]"},
      {{.emissivity = 1.01}, "emissivity: 1.01 is outside (0, 1]"},
      {{.emissivity = kNaN}, "emissivity: nan is outside (0, 1]"},
      {{.reflected_temperature = -274}, "reflected_temperature: -274 is outside (-273.15, 2000)"},
      {{.distance = -1}, "distance: -1 is outside [0, 10000] m"},
      {{.distance = kInfinity}, "distance: inf is outside"},
      {{.atmospheric_temperature = 293.15}, "atmospheric_temperature: 293.15 is outside [-60, 80]"},
      {{.relative_humidity = 50}, "relative_humidity: 50 is outside [0, 1]"},
      {{.window_temperature = 2000}, "window_temperature: 2000 is outside"},
      {{.window_transmission = 0}, "window_transmission: 0 is outside (0, 1]"},
      {{.distance = 10000, .atmospheric_temperature = 35, .relative_humidity = 1},
       "the share that passes"},
  };
  for (const BadObject& b : bad) {
    EXPECT_THAT([&] { Radiometry(test::sc660(), b.object); },
                ThrowsMessage<std::invalid_argument>(HasSubstr(b.message)));
  }
}

TEST(Radiometry, NamesWhatIsWrongWithTheCamera) {
  const auto with = [](auto change) {
    CameraConstants camera = test::sc660();
    change(camera);
    return [camera] { Radiometry(camera, {}); };
  };
  const auto throws = [](const char* message) {
    return ThrowsMessage<std::invalid_argument>(HasSubstr(message));
  };
  EXPECT_THAT(with([](auto& c) { c.planck.r1 = 0; }), throws("planck.r1: 0 is outside (0, inf)"));
  EXPECT_THAT(with([](auto& c) { c.planck.r2 = -1; }), throws("planck.r2: -1"));
  EXPECT_THAT(with([](auto& c) { c.planck.b = 20; }), throws("planck.b: 20 is outside [100"));
  EXPECT_THAT(with([](auto& c) { c.planck.f = kNaN; }), throws("planck.f: nan"));
  EXPECT_THAT(with([](auto& c) { c.planck.o = kInfinity; }), throws("planck.o: inf"));
  EXPECT_THAT(with([](auto& c) { c.atmosphere.x = kNaN; }), throws("atmosphere.x: nan"));
  EXPECT_THAT(with([](auto& c) { c.path = static_cast<AirPath>(9); }), throws("path: 9"));
  EXPECT_EQ(to_string(static_cast<AirPath>(9)), "unknown");
}

}  // namespace
}  // namespace pipescout::thermal
