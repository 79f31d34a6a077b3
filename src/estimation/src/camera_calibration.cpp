// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/camera_calibration.hpp"

#include <array>
#include <cmath>
#include <iomanip>
#include <locale>
#include <numbers>
#include <sstream>

namespace pipescout::estimation {

std::string camera_calibration_text(const FixedLagSmoother& smoother,
                                    const FixedLagSmootherParameters& parameters, int mounting,
                                    int clock) {
  constexpr double kLearnt = 0.7;  // of the standard deviation beforehand, and less
  constexpr double kPlusMinus = 2;
  if (!smoother.initialised()) {
    return {};
  }
  const GlobalVector now = smoother.global_covariance().diagonal().cwiseMax(0).cwiseSqrt();
  const GlobalVector before = parameters.global_deviations.tangent();
  const GlobalStates& globals = smoother.globals();
  const auto list = [] {
    std::ostringstream values;
    values.imbue(std::locale::classic());
    values << std::fixed << std::setprecision(1);
    return values;
  };
  std::ostringstream mounted = list();
  std::ostringstream open = list();
  std::ostringstream delayed = list();
  const auto is_learnt = [&](int place, double unit, const char* of, const char* what) {
    if (now[place] <= kLearnt * before[place]) {
      return true;
    }
    open << (open.view().empty() ? "" : ", ") << what << " (+-" << kPlusMinus * now[place] / unit
         << ' ' << of << ')';
    return false;
  };
  if (mounting >= 0) {
    constexpr double kDegree = std::numbers::pi / 180;
    constexpr double kCentimetre = 0.01;
    constexpr std::array<const char*, kMountingSize> kNames = {"x",       "y",       "z",
                                                               "about x", "about y", "about z"};
    for (int i = 0; i < kMountingSize; ++i) {
      const int place = kOwnStates + mounting + i;
      const double unit = i < 3 ? kCentimetre : kDegree;
      const char* const of = i < 3 ? "cm" : "degrees";
      const char* const name = kNames[static_cast<std::size_t>(i)];
      if (before[place] > 0 && is_learnt(place, unit, of, name)) {
        mounted << (mounted.view().empty() ? "" : ", ") << name << ' ' << std::showpos
                << globals.own[mounting + i] / unit << std::noshowpos << " +-"
                << kPlusMinus * now[place] / unit << ' ' << of;
      }
    }
  }
  constexpr double kMillisecond = 1e-3;
  const int delay = clock >= 0 ? kOwnStates + clock : kVisualPoseTimeOffset;
  if (before[delay] > 0 && is_learnt(delay, kMillisecond, "ms", "the delay")) {
    // The state is by how much later than its stamp the body was where it is seen.
    const double later = clock >= 0 ? globals.own[clock] : globals.visual_pose_time_offset;
    delayed << "its poses are of " << std::abs(later) / kMillisecond << " +-"
            << kPlusMinus * now[delay] / kMillisecond << " ms " << (later < 0 ? "before" : "after")
            << " their stamps";
  }
  std::string text;
  const auto add = [&](const char* what, const std::ostringstream& values) {
    if (!values.view().empty()) {
      text += (text.empty() ? "" : "; ") + std::string(what) + values.str();
    }
  };
  add("the sensor is off its stated mounting by ", mounted);
  add("", delayed);
  add("the motion so far does not determine: ", open);
  return text;
}

}  // namespace pipescout::estimation
