// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/campaign.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::leak_study {
namespace {

using simulation::ThermalDecoy;
using simulation::ThermalDecoyKind;
using simulation::ThermalLeak;
using simulation::ThermalPatrolParameters;
using simulation::ThermalScene;
using statistics::Draw;

constexpr std::uint64_t kOfPlaces = 1;
constexpr std::uint64_t kOfDecoys = 2;
constexpr std::uint64_t kOfRadiometry = 4;
/// m: what is thermally quiet about a faint leak, that has neither a joint nor a post in it.
constexpr double kQuiet = 0.4;
constexpr double kBodyHalfWidth = 1;  // m

/// What of a row is taken.
class Room {
 public:
  Room(double length, double apart) : length_(length), apart_(apart) {}

  [[nodiscard]] bool has(double place, double half_length) const {
    return place - half_length >= apart_ && place + half_length <= length_ - apart_ &&
           std::ranges::none_of(taken_, [&](const Taken& other) {
             return std::abs(place - other.place) < half_length + other.half_length + apart_;
           });
  }
  void take(double place, double half_length) {
    taken_.push_back({.place = place, .half_length = half_length});
  }

 private:
  struct Taken {
    double place = 0;
    double half_length = 0;
  };
  double length_;
  double apart_;
  std::vector<Taken> taken_;
};

/// Whether there is neither a joint nor a post within a leak, nor near it.
bool is_quiet(const ThermalScene& scene, const ThermalLeak& leak) {
  const auto clear = [&leak](double place) {
    return std::abs(place - leak.place) > leak.length / 2 + kQuiet;
  };
  return std::ranges::all_of(scene.joints(),
                             [&](const auto& joint) { return clear(joint.place); }) &&
         std::ranges::all_of(scene.supports(), clear);
}

ThermalLeak draw_leak(bool faint, Draw& draw) {
  ThermalLeak leak;
  if (faint) {
    leak.length = draw.uniform(0.3, 0.5);
    leak.rise = draw.uniform(75, 90);
    leak.shoulder = 0.05;
  } else {
    leak.length = 0.4 * std::pow(10, draw.uniform(0, 1));
    leak.rise = draw.uniform(95, 250);
    leak.shoulder = leak.length * draw.uniform(0.1, 0.5);
  }
  return leak;
}

/// Calls `place_in` for random sequences and places until it says that there was room.
template <class PlaceIn>
void find_room(std::size_t sequences, double length, Draw& draw, PlaceIn place_in) {
  constexpr int kTrials = 20000;
  for (int i = 0; i < kTrials; ++i) {
    const std::size_t sequence = draw.index(sequences);
    if (place_in(sequence, draw.uniform(0, length))) {
      return;
    }
  }
  throw std::runtime_error("there is no room for so many leaks and decoys so far apart");
}

ThermalPatrolParameters draw_patrol(const CampaignSettings& settings, std::size_t number,
                                    Draw& draw) {
  ThermalPatrolParameters p;
  p.seed = draw.seed();
  p.camera = number % 2 == 1 ? simulation::ThermalCameraParameters::qvga()
                             : simulation::ThermalCameraParameters::vga();
  p.camera.netd = draw.uniform(settings.netd_least, settings.netd_most);
  p.camera.seed = draw.seed();
  constexpr std::array kRoads{simulation::RoadClass::kC, simulation::RoadClass::kD,
                              simulation::RoadClass::kE};
  p.terrain.roughness = simulation::iso_8608_density(kRoads[number % kRoads.size()]);
  p.distance = draw.uniform(9.5, 10.5);
  p.end = settings.length + 15;

  simulation::ThermalSceneParameters& scene = p.scene;
  scene.seed = draw.seed();
  scene.length = settings.length;
  scene.T_map_row = {geometry::SO3::about_z(draw.uniform(-std::numbers::pi, std::numbers::pi)),
                     {draw.uniform(-500, 500), draw.uniform(-500, 500), 0}};
  scene.tube_temperature = draw.uniform(130, 180);
  scene.tube_change = draw.uniform(0, 6);
  scene.tube_grain = draw.uniform(1, 3);
  scene.sky_temperature = draw.uniform(-45, -20);
  scene.ground_temperature = draw.uniform(0, 9);
  scene.mirror_temperature = draw.uniform(-20, -5);
  scene.mirror_image = draw.uniform(40, 85);
  // What the tube reflects is not quite what the camera is told.
  constexpr double kReflected = 0.3;  // K
  scene.object.reflected_temperature += kReflected * draw.normal();
  return p;
}

/// Makes what the camera is told wrong, by numbers of their own.
void draw_radiometry(Draw& draw, ThermalPatrolParameters& p) {
  constexpr double kLeastEmissivity = 0.02;
  constexpr double kEmissivityRatio = 5;
  constexpr double kKelvin = 10;
  constexpr double kShare = 0.3;
  const auto off = [&] { return draw.uniform(1 - kShare, 1 + kShare); };
  thermal::ObjectParameters& object = p.scene.object;
  const thermal::ObjectParameters told = thermal::ibarguren2013_object();
  object.emissivity = kLeastEmissivity * std::pow(kEmissivityRatio, draw.uniform(0, 1));
  object.reflected_temperature = told.reflected_temperature + draw.uniform(-kKelvin, kKelvin);
  object.atmospheric_temperature = told.atmospheric_temperature + draw.uniform(-kKelvin, kKelvin);
  object.relative_humidity = told.relative_humidity * off();
  object.distance = told.distance * off();
  p.distance = object.distance;
}

/// Where a leak is beside a joint or a post, or under it.
double draw_near(const ThermalScene& scene, const ThermalLeak& leak, Draw& draw) {
  const std::size_t joints = scene.joints().size();
  const std::size_t which = draw.index(joints + scene.supports().size());
  const double place =
      which < joints ? scene.joints()[which].place : scene.supports()[which - joints];
  const double reach = leak.length / 2 + kQuiet;
  return place + draw.uniform(-reach, reach);
}

}  // namespace

void CampaignSettings::validate() const {
  validation::check_within("sequences", static_cast<double>(sequences), 1, 10000);
  const auto count = static_cast<double>(sequences);
  validation::check_within("faint_leaks", static_cast<double>(faint_leaks), 0, count);
  validation::check_within("near_leaks", static_cast<double>(near_leaks), 0, count);
  validation::check_within("other_leaks", static_cast<double>(other_leaks), 0, 10 * count);
  validation::check_within("decoys", static_cast<double>(decoys), 0, 10 * count);
  validation::check_within("netd_least", netd_least, 0, netd_most);
  validation::check_within("netd_most", netd_most, netd_least, 5);
  validation::check_within("length", length, 20, 5000);
  validation::check_within("apart", apart, 0, length / 4);
}

ThermalDecoy draw_decoy(ThermalDecoyKind kind, double place, std::uint64_t seed) {
  Draw draw(seed, kOfDecoys);
  ThermalDecoy decoy{.kind = kind, .place = place};
  switch (kind) {
    case ThermalDecoyKind::kBrightJoint:
      decoy.size = draw.uniform(0.13, 0.18);
      decoy.rise = draw.uniform(60, 150);
      break;
    case ThermalDecoyKind::kPassingReflection:
      decoy.size = draw.uniform(0.2, 0.6);
      decoy.rise = draw.uniform(80, 200);
      decoy.follow = draw.uniform(0.35, 1);
      decoy.reach = draw.uniform(2, 8);
      break;
    case ThermalDecoyKind::kHotPixels:
      decoy.size = 1 + static_cast<double>(draw.index(3));
      decoy.rise = draw.uniform(80, 300);
      decoy.reach = draw.uniform(5, 30);
      // Where the tube is.
      decoy.pixel = {draw.uniform(0.1, 0.9), draw.uniform(0.46, 0.52)};
      break;
    case ThermalDecoyKind::kWarmSupport:
      decoy.size = draw.uniform(0.14, 0.3);
      decoy.rise = draw.uniform(40, 150);
      break;
    case ThermalDecoyKind::kSunGlint:
      decoy.size = draw.uniform(0.1, 0.5);
      decoy.rise = 600;
      decoy.follow = 1;
      decoy.reach = draw.uniform(0.2, 1.1);
      break;
    case ThermalDecoyKind::kHotBody:
      decoy.size = draw.uniform(0.5, 2 * kBodyHalfWidth);
      decoy.rise = draw.uniform(0, 150);
      decoy.behind = draw.uniform(0.5, 6);
      decoy.height = draw.uniform(0.5, 2.5);
      decoy.foot = draw.uniform(0, 3.5);
      break;
  }
  return decoy;
}

std::vector<SequencePlan> plan_campaign(const CampaignSettings& settings, std::uint64_t seed) {
  settings.validate();
  Draw draw(seed, kOfPlaces);
  Draw radiometry(seed, kOfRadiometry);
  std::vector<SequencePlan> plans(settings.sequences);
  std::vector<Room> rooms(settings.sequences, Room(settings.length, settings.apart));
  std::vector<ThermalScene> scenes;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    constexpr std::size_t kGreyEvery = 5;
    plans[i].patrol = draw_patrol(settings, i + 1, draw);
    plans[i].grey = i % kGreyEvery == kGreyEvery - 1;
    if (settings.drawn_radiometry) {
      draw_radiometry(radiometry, plans[i].patrol);
      plans[i].grey = false;
    }
    plans[i].automatic_gain = settings.automatic_gain;
    scenes.emplace_back(plans[i].patrol.scene);
  }
  for (std::size_t i = 0; i < settings.faint_leaks + settings.other_leaks; ++i) {
    const bool faint = i < settings.faint_leaks;
    ThermalLeak leak = draw_leak(faint, draw);
    find_room(plans.size(), settings.length, draw, [&](std::size_t sequence, double place) {
      leak.place = place;
      if (!rooms[sequence].has(place, leak.length / 2) ||
          (faint && !is_quiet(scenes[sequence], leak))) {
        return false;
      }
      rooms[sequence].take(place, leak.length / 2);
      plans[sequence].patrol.scene.leaks.push_back(leak);
      plans[sequence].faint_leaks += faint ? 1 : 0;
      return true;
    });
  }
  for (std::size_t i = 0; i < settings.near_leaks; ++i) {
    ThermalLeak leak = draw_leak(true, draw);
    find_room(plans.size(), settings.length, draw, [&](std::size_t sequence, double) {
      leak.place = draw_near(scenes[sequence], leak, draw);
      if (!rooms[sequence].has(leak.place, leak.length / 2)) {
        return false;
      }
      rooms[sequence].take(leak.place, leak.length / 2);
      plans[sequence].patrol.scene.leaks.push_back(leak);
      ++plans[sequence].near_leaks;
      return true;
    });
  }
  for (std::size_t i = 0; i < settings.decoys; ++i) {
    const auto kind = static_cast<ThermalDecoyKind>(i % simulation::kThermalDecoyKinds);
    const std::uint64_t own = draw.seed();
    find_room(plans.size(), settings.length, draw, [&](std::size_t sequence, double place) {
      if (!rooms[sequence].has(place, kBodyHalfWidth)) {
        return false;
      }
      rooms[sequence].take(place, kBodyHalfWidth);
      plans[sequence].patrol.scene.decoys.push_back(draw_decoy(kind, place, own));
      return true;
    });
  }
  return plans;
}

}  // namespace pipescout::leak_study
