// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"
#include "thermal_background.hpp"

namespace pipescout::simulation {
namespace {

using validation::check_above;
using validation::check_within;

constexpr double kGrainStep = 0.05;  // m
constexpr int kGrainReach = 9;       // steps; three deviations of the smoothing
constexpr double kGrainSpread = 3;   // steps, its standard deviation

std::string numbered(const char* list, std::size_t i, const char* field) {
  return std::string(list) + "[" + std::to_string(i) + "]." + field;
}

void check_leak(const ThermalLeak& leak, std::size_t i, double length) {
  const auto name = [i](const char* field) { return numbered("leaks", i, field); };
  check_within(name("place"), leak.place, 0, length);
  check_within(name("length"), leak.length, 0.05, 50);
  check_above(name("rise"), leak.rise, 0, 2000);
  check_within(name("shoulder"), leak.shoulder, 0, leak.length);
}

void check_decoy(const ThermalDecoy& decoy, std::size_t i) {
  const auto name = [i](const char* field) { return numbered("decoys", i, field); };
  const bool pixels = decoy.kind == ThermalDecoyKind::kHotPixels;
  check_within(name("place"), decoy.place, -1e6, 1e6);
  check_within(name("size"), decoy.size, pixels ? 1 : 0.005, 5);
  check_within(name("rise"), decoy.rise, -200, 2000);
  check_above(name("reach"), decoy.reach, 0, 1e6);
  check_within(name("follow"), decoy.follow, 0, 1);
  check_within(name("pixel.x"), decoy.pixel.x(), 0, 1);
  check_within(name("pixel.y"), decoy.pixel.y(), 0, 1);
  check_within(name("behind"), decoy.behind, 0.2, 50);
  check_above(name("height"), decoy.height, 0, 10);
  check_within(name("foot"), decoy.foot, 0, 10);
}

/// White noise, smoothed, of standard deviation 1.
std::vector<float> smooth_noise(std::size_t count, std::mt19937_64& engine) {
  std::vector<double> weights;
  double power = 0;
  for (int i = -kGrainReach; i <= kGrainReach; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (kGrainSpread * kGrainSpread)));
    power += weights.back() * weights.back();
  }
  std::vector<double> white(count + weights.size());
  std::ranges::generate(white, [&engine] { return statistics::normal(engine); });
  std::vector<float> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      sum += weights[k] * white[i + k];
    }
    result[i] = static_cast<float>(sum / std::sqrt(power));
  }
  return result;
}

}  // namespace

void ThermalSceneParameters::validate() const {
  check_within("length", length, 1, 5000);
  check_within("tube_height", tube_height, 0.5, 10);
  check_within("tube_radius", tube_radius, 0.01, 0.5);
  check_within("tube_temperature", tube_temperature, 20, 500);
  check_within("tube_change", tube_change, 0, 100);
  check_within("tube_grain", tube_grain, 0, 50);
  check_within("joint_spacing", joint_spacing, 0.5, 100);
  check_within("joint_width", joint_width, 0, 1);
  check_within("joint_least", joint_least, -200, 1000);
  check_within("joint_most", joint_most, joint_least, 1000);
  check_within("support_spacing", support_spacing, 1, 1000);
  check_within("support_width", support_width, 0, 1);
  check_within("mirror_image", mirror_image, -50, 500);
  check_within("mirror_image_offset", mirror_image_offset, -5, 5);
  check_within("sky_temperature", sky_temperature, -80, 60);
  check_within("ground_temperature", ground_temperature, -60, 80);
  check_within("ground_grain", ground_grain, 0, 20);
  check_within("mirror_temperature", mirror_temperature, -80, 80);
  check_within("mirror_change", mirror_change, 0, 50);
  object.validate();
  for (std::size_t i = 0; i < leaks.size(); ++i) {
    check_leak(leaks[i], i, length);
  }
  for (std::size_t i = 0; i < decoys.size(); ++i) {
    check_decoy(decoys[i], i);
  }
}

ThermalScene::ThermalScene(const ThermalSceneParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
  const ThermalSceneParameters& p = parameters_;
  std::mt19937_64 engine = statistics::make_engine(p.seed, 0x7e);
  for (double place = p.joint_spacing; place < p.length; place += p.joint_spacing) {
    ThermalJoint joint;
    joint.place = place;
    joint.width = p.joint_width * statistics::uniform(engine, 0.75, 1.25);
    joint.swing = 0.35 * (p.joint_most - p.joint_least) * statistics::uniform(engine);
    joint.rise =
        statistics::uniform(engine, p.joint_least + joint.swing, p.joint_most - joint.swing);
    joint.phase = statistics::uniform(engine, 0, 2 * std::numbers::pi);
    joints_.push_back(joint);
  }
  for (const ThermalDecoy& decoy : p.decoys) {
    if (decoy.kind == ThermalDecoyKind::kBrightJoint && !joints_.empty()) {
      ThermalJoint& joint = *std::ranges::min_element(joints_, {}, [&](const ThermalJoint& each) {
        return std::abs(each.place - decoy.place);
      });
      joint.width = decoy.size;
      joint.rise = decoy.rise;
      joint.swing = 0.3 * std::abs(decoy.rise);
    }
  }
  if (p.support_width > 0) {
    // Half-way between two joints, as the first is a tube's length from the beginning.
    for (double place = p.joint_spacing / 2; place < p.length; place += p.support_spacing) {
      supports_.push_back(place);
    }
  }
  grain_ = smooth_noise(static_cast<std::size_t>(p.length / kGrainStep) + 3, engine);
}

Eigen::Vector3d ThermalScene::on_tube(double place) const noexcept {
  return parameters_.T_map_row * Eigen::Vector3d(place, 0, parameters_.tube_height);
}

bool ThermalScene::faces(const Eigen::Vector3d& point) const noexcept {
  return (parameters_.T_map_row.inverse() * point).y() < internal::kMirrorBehind;
}

double ThermalScene::rise_of(const ThermalLeak& leak, double place) noexcept {
  const double outside = std::abs(place - leak.place) - leak.length / 2;
  if (leak.shoulder <= 0) {
    return outside <= 0 ? leak.rise : 0;
  }
  return leak.rise * std::clamp(0.5 - outside / leak.shoulder, 0.0, 1.0);
}

double ThermalScene::tube_temperature(double place) const noexcept {
  const ThermalSceneParameters& p = parameters_;
  const double on = std::clamp(place, 0.0, p.length);
  double rise = 0;
  for (const ThermalLeak& leak : p.leaks) {
    rise = std::max(rise, rise_of(leak, on));
  }
  const double step = on / kGrainStep;
  const auto i = static_cast<std::size_t>(step);
  const double part = step - static_cast<double>(i);
  const double grain =
      (1 - part) * static_cast<double>(grain_[i]) + part * static_cast<double>(grain_[i + 1]);
  return p.tube_temperature + p.tube_change * (2 * on / p.length - 1) + p.tube_grain * grain + rise;
}

}  // namespace pipescout::simulation
