// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/parameter_doubts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "camera_helpers.hpp"

namespace pipescout::thermal {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const ObjectParameters kSensible{.emissivity = 0.92, .distance = 8, .relative_humidity = 0.4};

auto is(const char* field, bool fatal, const char* reason) {
  return ::testing::AllOf(Field(&Doubt::field, field), Field(&Doubt::fatal, fatal),
                          Field(&Doubt::reason, HasSubstr(reason)));
}

template <class Change>
std::vector<Doubt> changed(Change change) {
  CameraConstants camera = test::sc660();
  ObjectParameters object = kSensible;
  change(camera, object);
  return doubts(camera, object);
}

TEST(ParameterDoubts, NoneAboutWhatIsSensible) {
  EXPECT_THAT(doubts(test::sc660(), kSensible), IsEmpty());
}

TEST(ParameterDoubts, AboutEachParameter) {
  EXPECT_THAT(changed([](auto&, auto& o) { o.emissivity = 0.7; }),
              ElementsAre(is("emissivity", false, "below 0.8")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.relative_humidity = 50; }),
              ElementsAre(is("relative_humidity", true, "outside [0, 1]: a percentage?")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.emissivity = 95; }),
              ElementsAre(is("emissivity", true, "a percentage?")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.distance = 0; }),
              ElementsAre(is("distance", false, "touches")));
  EXPECT_THAT(changed([](auto&, auto& o) {
                o.distance = 2000;
                o.relative_humidity = 0.1;
              }),
              ::testing::Contains(is("distance", false, "above 1 km")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.atmospheric_temperature = 293; }),
              ElementsAre(is("atmospheric_temperature", true, "kelvin?")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.atmospheric_temperature = 70; }),
              ElementsAre(is("atmospheric_temperature", false, "outside [-40, 60]")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.reflected_temperature = 500; }),
              ElementsAre(is("reflected_temperature", false, "outside [-80, 300]")));
  EXPECT_THAT(changed([](auto&, auto& o) { o.window_transmission = 0.3; }),
              ElementsAre(is("window_transmission", false, "below one half")));
  EXPECT_THAT(changed([](auto&, auto& o) {
                o.window_temperature = std::numeric_limits<double>::quiet_NaN();
              }),
              ElementsAre(is("window_temperature", true, "outside")));
}

TEST(ParameterDoubts, AboutAirThatTheFitDoesNotReach) {
  EXPECT_THAT(changed([](auto&, auto& o) {
                o.distance = 10000;
                o.atmospheric_temperature = 35;
                o.relative_humidity = 1;
              }),
              ::testing::Contains(is("distance", true, "the share that passes")));
}

TEST(ParameterDoubts, AboutPlanckConstantsOutOfOrder) {
  EXPECT_THAT(changed([](auto& c, auto&) { c.planck.r1 = 0; }),
              ElementsAre(is("planck.r1", true, "outside (0, inf)")));
  EXPECT_THAT(changed([](auto& c, auto&) { c.planck.b = 900; }),
              ::testing::Contains(is("planck.b", false, "1200")));
  EXPECT_THAT(changed([](auto& c, auto&) { c.planck.f = 3; }),
              ::testing::Contains(is("planck.f", false, "[0.5, 2]")));
  EXPECT_THAT(changed([](auto& c, auto&) { std::swap(c.planck.r1, c.planck.r2); }),
              ElementsAre(is("planck.r1", false, "less than a count")));
}

TEST(ParameterDoubts, AboutDefaultsThatNobodyHasSet) {
  EXPECT_THAT(doubts(test::sc660(), {}),
              ElementsAre(is("emissivity", false, "unchanged factory defaults")));
}

TEST(ParameterDoubts, ThePapersEmissivityIsOne) {
  EXPECT_THAT(doubts(test::sc660(), ibarguren2013_object()),
              ElementsAre(is("emissivity", false, "reflections")));
}

TEST(ParameterDoubts, ReadAsOneLine) {
  EXPECT_EQ(to_string(Doubt{"relative_humidity", 50, "outside [0, 1]: a percentage?", true}),
            "relative_humidity 50: outside [0, 1]: a percentage?");
}

}  // namespace
}  // namespace pipescout::thermal
