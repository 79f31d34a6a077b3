// SPDX-License-Identifier: Apache-2.0
// Cameras and objects over the ranges that occur, and some way beyond.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstdlib>

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {
namespace {

double draw(double from, double to) {
  const int step = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 1001));
  return from + (to - from) * step / 1000.0;
}

CameraConstants draw_camera() {
  CameraConstants camera;
  camera.planck = {.r1 = draw(1e4, 4e4),
                   .r2 = draw(0.01, 0.05),
                   .b = draw(1350, 1550),
                   .f = draw(0.5, 2),
                   .o = draw(-8000, 1000)};
  camera.path = *rc::gen::element(AirPath::kBeforeWindow, AirPath::kWindowMidway);
  return camera;
}

ObjectParameters draw_object() {
  return {.emissivity = draw(0.04, 1),
          .reflected_temperature = draw(-40, 60),
          .distance = draw(0.1, 60),
          .atmospheric_temperature = draw(-20, 40),
          .relative_humidity = draw(0.02, 1),
          .window_temperature = draw(-20, 60),
          .window_transmission = draw(0.3, 1)};
}

RC_GTEST_PROP(RadiometryProperties, ThereAndBackIsWhereItBegan, ()) {
  const Radiometry radiometry(draw_camera(), draw_object());
  const double temperature = draw(-40, 400);
  RC_ASSERT(std::abs(radiometry.temperature(radiometry.counts(temperature)) - temperature) < 1e-6);
}

RC_GTEST_PROP(RadiometryProperties, WarmerGivesMoreCounts, ()) {
  const Radiometry radiometry(draw_camera(), draw_object());
  const double temperature = draw(-60, 400);
  RC_ASSERT(radiometry.counts(temperature + 0.1) > radiometry.counts(temperature));
  RC_ASSERT(radiometry.slope(temperature) > 0);
  const double counts = std::ceil(radiometry.floor_counts()) + draw(1, 60000);
  RC_ASSERT(radiometry.temperature(counts + 1) > radiometry.temperature(counts));
}

RC_GTEST_PROP(RadiometryProperties, NothingIsKnownBelowTheFloor, ()) {
  const Radiometry radiometry(draw_camera(), draw_object());
  RC_ASSERT(std::isnan(radiometry.temperature(radiometry.floor_counts() - draw(0.5, 1000))));
}

/// The derivative of the temperature at fixed counts, by differences of the parameter.
double numeric(const CameraConstants& camera, const ObjectParameters& object, double counts,
               double ObjectParameters::*field, double step) {
  ObjectParameters low = object;
  ObjectParameters high = object;
  low.*field -= step;
  high.*field += step;
  return (Radiometry(camera, high).temperature(counts) -
          Radiometry(camera, low).temperature(counts)) /
         (2 * step);
}

void check(double analytic, double by_differences) {
  RC_ASSERT(std::abs(analytic - by_differences) <= 1e-5 + 2e-4 * std::abs(by_differences));
}

RC_GTEST_PROP(RadiometryProperties, SensitivitiesAreTheDerivatives, ()) {
  const CameraConstants camera = draw_camera();
  ObjectParameters object = draw_object();
  object.emissivity = draw(0.1, 0.99);
  object.relative_humidity = draw(0.05, 0.99);
  object.window_transmission = draw(0.3, 0.99);
  const Radiometry radiometry(camera, object);
  const double counts = radiometry.counts(draw(0, 300));
  const Sensitivity s = radiometry.sensitivity(counts);
  using O = ObjectParameters;
  check(s.emissivity, numeric(camera, object, counts, &O::emissivity, 1e-5));
  check(s.reflected_temperature, numeric(camera, object, counts, &O::reflected_temperature, 1e-3));
  check(s.distance, numeric(camera, object, counts, &O::distance, 1e-4));
  check(s.atmospheric_temperature,
        numeric(camera, object, counts, &O::atmospheric_temperature, 1e-3));
  check(s.relative_humidity, numeric(camera, object, counts, &O::relative_humidity, 1e-5));
  check(s.window_temperature, numeric(camera, object, counts, &O::window_temperature, 1e-3));
  check(s.window_transmission, numeric(camera, object, counts, &O::window_transmission, 1e-5));
  check(s.counts,
        (radiometry.temperature(counts + 0.1) - radiometry.temperature(counts - 0.1)) / 0.2);
}

}  // namespace
}  // namespace pipescout::thermal
