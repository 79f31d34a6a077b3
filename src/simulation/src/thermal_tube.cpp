// SPDX-License-Identifier: Apache-2.0
#include "thermal_tube.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace pipescout::simulation::internal {
namespace {

constexpr double kStep = 0.005;      // m, of the table along the tube
constexpr double kLowest = -100;     // degC, of the table of counts
constexpr double kHighest = 3000;    // degC
constexpr double kDegreeStep = 0.5;  // K
/// How fast what a joint reflects changes: periods over a radian of the angle of view.
constexpr double kJointPeriods = 2.5;
/// m: spots that pass come and go over such a length at their ends, at most.
constexpr double kSpotShoulder = 0.05;

}  // namespace

ThermalTube::ThermalTube(const ThermalScene& scene, const ThermalRadiation& radiation)
    : scene_(scene), lowest_(kLowest) {
  const auto degrees = static_cast<std::size_t>((kHighest - kLowest) / kDegreeStep) + 2;
  of_degrees_.resize(degrees);
  for (std::size_t i = 0; i < degrees; ++i) {
    const double counts = radiation.object(kLowest + kDegreeStep * static_cast<double>(i));
    if (!std::isfinite(counts)) {
      throw std::invalid_argument("constants: the camera has no counts from -100 to 3000 degC");
    }
    of_degrees_[i] = static_cast<float>(counts);
  }
  const double length = scene.parameters().length;
  const auto steps = static_cast<std::size_t>(std::ceil(length / kStep)) + 1;
  integral_.resize(steps + 1);
  for (std::size_t i = 0; i < steps; ++i) {
    const double middle = (static_cast<double>(i) + 0.5) * kStep;
    integral_[i + 1] =
        integral_[i] + kStep * static_cast<double>(counts(scene.tube_temperature(middle)));
  }
}

float ThermalTube::counts(double temperature) const noexcept {
  const double last = static_cast<double>(of_degrees_.size()) - 1.001;
  const double step = std::clamp((temperature - lowest_) / kDegreeStep, 0.0, last);
  const auto i = static_cast<std::size_t>(step);
  const auto part = static_cast<float>(step - static_cast<double>(i));
  return of_degrees_[i] + part * (of_degrees_[i + 1] - of_degrees_[i]);
}

double ThermalTube::integral(double place) const noexcept {
  const double last = static_cast<double>(integral_.size()) - 1.001;
  const double step = std::clamp(place / kStep, 0.0, last);
  const auto i = static_cast<std::size_t>(step);
  const double part = step - static_cast<double>(i);
  return integral_[i] + part * (integral_[i + 1] - integral_[i]);
}

void ThermalTube::put(const Spot& spot, double least, double step, double blur,
                      std::span<BandSample> samples) noexcept {
  const double margin = blur / 2;
  const auto index = [&](double place) {
    return std::clamp((place - least) / step, 0.0, static_cast<double>(samples.size()));
  };
  const auto first = static_cast<std::size_t>(index(spot.from - margin));
  const auto last = static_cast<std::size_t>(std::ceil(index(spot.to + margin)));
  for (std::size_t i = first; i < last; ++i) {
    const double place = least + step * static_cast<double>(i);
    const auto share =
        spot.strength * static_cast<float>(box_share(place, blur, spot.from, spot.to));
    samples[i].counts += share * (spot.counts - samples[i].counts);
  }
}

ThermalTube::Spot ThermalTube::joint_spot(const ThermalJoint& joint, double camera_place,
                                          double distance) const noexcept {
  const double angle = std::atan2(camera_place - joint.place, distance);
  const double rise =
      joint.rise +
      joint.swing * std::sin(2 * std::numbers::pi * kJointPeriods * angle + joint.phase);
  return {.from = joint.place - joint.width / 2,
          .to = joint.place + joint.width / 2,
          .counts = counts(scene_.tube_temperature(joint.place) + rise)};
}

ThermalTube::Spot ThermalTube::passing_spot(const ThermalDecoy& decoy,
                                            double camera_place) const noexcept {
  const double way = camera_place - decoy.place;
  const double middle = decoy.place + decoy.follow * way;
  Spot spot{.from = middle - decoy.size / 2, .to = middle + decoy.size / 2};
  const double gone = 2 * std::abs(way) / decoy.reach;  // 1 where it is seen no longer
  if (gone >= 1 || middle < 0 || middle > scene_.parameters().length) {
    spot.strength = 0;
  } else if (decoy.kind == ThermalDecoyKind::kPassingReflection) {
    // It comes and goes as the mirror turns away.
    spot.strength = static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * gone));
  }
  spot.counts = counts(scene_.tube_temperature(middle) + decoy.rise);
  return spot;
}

void ThermalTube::sample(double least, double most, double blur, double camera_place,
                         double distance, std::span<BandSample> samples) const noexcept {
  const ThermalSceneParameters& p = scene_.parameters();
  const double step = (most - least) / static_cast<double>(samples.size() - 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double place = least + step * static_cast<double>(i);
    const double from = std::max(0.0, place - blur / 2);
    const double to = std::min(p.length, place + blur / 2);
    const double seen = to - from;
    samples[i].cover = seen > 0 ? static_cast<float>(seen / blur) : 0.0F;
    samples[i].counts =
        seen > 0 ? static_cast<float>((integral(to) - integral(from)) / seen) : 0.0F;
  }
  const double shoulder_blur = std::hypot(blur, kSpotShoulder);
  for (const ThermalDecoy& decoy : p.decoys) {
    if (decoy.kind == ThermalDecoyKind::kPassingReflection ||
        decoy.kind == ThermalDecoyKind::kSunGlint) {
      const Spot spot = passing_spot(decoy, camera_place);
      if (spot.strength > 0) {
        put(spot, least, step, shoulder_blur, samples);
      }
    }
  }
  const std::vector<ThermalJoint>& joints = scene_.joints();
  const auto first = std::ranges::lower_bound(joints, least - 1, {}, &ThermalJoint::place);
  for (auto joint = first; joint != joints.end() && joint->place < most + 1; ++joint) {
    put(joint_spot(*joint, camera_place, distance), least, step, blur, samples);
  }
}

}  // namespace pipescout::simulation::internal
