// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/parameter_doubts.hpp"

#include <cmath>
#include <exception>
#include <locale>
#include <sstream>

namespace pipescout::thermal {
namespace {

class Doubts {
 public:
  void outside(const char* field, double value, bool in_range, const char* range,
               const char* question = "") {
    if (!in_range) {
      add(field, value, std::string("outside ") + range + question, true);
    }
  }
  void unless(bool sensible, const char* field, double value, const char* reason) {
    if (!sensible) {
      add(field, value, reason, false);
    }
  }
  void add(std::string field, double value, std::string reason, bool fatal) {
    found_.push_back({std::move(field), value, std::move(reason), fatal});
  }
  [[nodiscard]] bool fatal() const {
    for (const Doubt& doubt : found_) {
      if (doubt.fatal) {
        return true;
      }
    }
    return false;
  }
  std::vector<Doubt> take() { return std::move(found_); }

 private:
  std::vector<Doubt> found_;
};

bool near(double value, double target, double tolerance) {
  return std::abs(value - target) <= tolerance;
}

bool is_default(const ObjectParameters& o) {
  return near(o.emissivity, 0.95, 1e-3) && near(o.distance, 1, 1e-3) &&
         near(o.reflected_temperature, 20, 0.01) && near(o.atmospheric_temperature, 20, 0.01) &&
         near(o.relative_humidity, 0.5, 1e-3);
}

void of_planck(const PlanckConstants& p, Doubts& found) {
  found.outside("planck.r1", p.r1, p.r1 > 0 && std::isfinite(p.r1), "(0, inf)");
  found.outside("planck.r2", p.r2, p.r2 > 0 && std::isfinite(p.r2), "(0, inf)");
  found.outside("planck.b", p.b, p.b >= 100 && p.b <= 10000, "[100, 10000] K");
  found.outside("planck.f", p.f, p.f >= 0.1 && p.f <= 10, "[0.1, 10]");
  found.outside("planck.o", p.o, std::isfinite(p.o), "(-inf, inf)");
  if (found.fatal()) {
    return;
  }
  found.unless(p.b >= 1200 && p.b <= 1700, "planck.b", p.b,
               "outside [1200, 1700] K, where cameras of 7 to 14 micrometres have it");
  found.unless(p.f >= 0.5 && p.f <= 2, "planck.f", p.f, "outside [0.5, 2]");
  const double at_20 = p.counts(20);
  if (!(at_20 >= 0 && at_20 <= 65535)) {
    found.add("planck.o", p.o, "a black body of 20 degC would not give counts of 16 bits", false);
  }
  found.unless(p.slope(20) >= 1, "planck.r1", p.r1, "at 20 degC a kelvin gives less than a count");
}

void of_object(const ObjectParameters& o, Doubts& found) {
  found.outside("emissivity", o.emissivity, o.emissivity > 0 && o.emissivity <= 1, "(0, 1]",
                o.emissivity > 1 && o.emissivity <= 100 ? ": a percentage?" : "");
  found.outside("reflected_temperature", o.reflected_temperature,
                o.reflected_temperature > -kZeroCelsius && o.reflected_temperature < 2000,
                "(-273.15, 2000) degC");
  found.outside("distance", o.distance, o.distance >= 0 && o.distance <= 10000, "[0, 10000] m");
  found.outside("atmospheric_temperature", o.atmospheric_temperature,
                o.atmospheric_temperature >= -60 && o.atmospheric_temperature <= 80,
                "[-60, 80] degC", o.atmospheric_temperature > 200 ? ": kelvin?" : "");
  found.outside("relative_humidity", o.relative_humidity,
                o.relative_humidity >= 0 && o.relative_humidity <= 1, "[0, 1]",
                o.relative_humidity > 1 && o.relative_humidity <= 100 ? ": a percentage?" : "");
  found.outside("window_temperature", o.window_temperature,
                o.window_temperature > -kZeroCelsius && o.window_temperature < 2000,
                "(-273.15, 2000) degC");
  found.outside("window_transmission", o.window_transmission,
                o.window_transmission > 0 && o.window_transmission <= 1, "(0, 1]",
                o.window_transmission > 1 && o.window_transmission <= 100 ? ": a percentage?" : "");
  if (found.fatal()) {
    return;
  }
  found.unless(o.emissivity >= 0.8, "emissivity", o.emissivity,
               "below 0.8: reflections make more than a fifth of the signal");
  found.unless(o.distance > 0, "distance", o.distance, "an object that touches the lens");
  found.unless(o.distance <= 1000, "distance", o.distance, "above 1 km");
  found.unless(o.reflected_temperature >= -80 && o.reflected_temperature <= 300,
               "reflected_temperature", o.reflected_temperature, "outside [-80, 300] degC");
  found.unless(o.atmospheric_temperature >= -40 && o.atmospheric_temperature <= 60,
               "atmospheric_temperature", o.atmospheric_temperature, "outside [-40, 60] degC");
  found.unless(o.window_transmission >= 0.5, "window_transmission", o.window_transmission,
               "a window with a transmission below one half");
  if (is_default(o)) {
    found.add("emissivity", o.emissivity,
              "with 1 m, 20 degC and humidity 0.5 unchanged factory defaults", false);
  }
}

}  // namespace

std::string to_string(const Doubt& doubt) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << doubt.field << ' ' << doubt.value << ": " << doubt.reason;
  return text.str();
}

std::vector<Doubt> doubts(const CameraConstants& camera, const ObjectParameters& object) {
  Doubts found;
  of_planck(camera.planck, found);
  of_object(object, found);
  if (!found.fatal()) {
    try {
      const double passes = Radiometry(camera, object).transmission() / object.window_transmission;
      found.unless(passes >= 0.5, "distance", object.distance,
                   "air with a transmission below one half");
    } catch (const std::exception& error) {
      found.add("distance", object.distance, error.what(), true);
    }
  }
  return found.take();
}

}  // namespace pipescout::thermal
