// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "weld_signal.hpp"

namespace pipescout::odometry {
namespace {

using test::Complex;
using test::Crawl;
using test::welds_at;

template <typename Integer>
Integer draw(Integer from, Integer to) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<Integer>(from, to));
}

std::vector<double> draw_welds() {
  std::vector<double> welds;
  double at = 0.0;
  for (int i = draw(1, 6); i > 0; --i) {
    at += 1e-4 * draw(10000, 60000);
    welds.push_back(at);
  }
  return welds;
}

RC_GTEST_PROP(WeldDetectorProperties, GainRotationAndLevelChangeNothingElse, ()) {
  const auto welds = draw_welds();
  const double gain = std::ldexp(1.0, draw(-10, 10));
  const Complex turned = std::polar(gain, 0.01 * draw(0, 628));
  const Complex level(0.1 * draw(-100, 100), 0.1 * draw(-100, 100));
  const auto seed = static_cast<std::uint64_t>(draw(0, 1000));
  WeldDetector plain({});
  WeldDetector other({});
  Crawl a(plain, welds_at(welds), 0.05, seed);
  Crawl b(
      other, [&](double d) { return welds_at(welds, 0.04, turned)(d) + gain * level; }, 0.05 * gain,
      seed);
  a.go_to(welds.back() + 3.0);
  b.go_to(welds.back() + 3.0);
  RC_ASSERT(a.events().size() == welds.size());
  RC_ASSERT(b.events().size() == welds.size());
  for (std::size_t i = 0; i < welds.size(); ++i) {
    RC_ASSERT(std::abs(a.events()[i].distance - welds[i]) < 0.004);
    RC_ASSERT(std::abs(b.events()[i].distance - welds[i]) < 0.004);
    RC_ASSERT(std::abs(b.events()[i].amplitude / gain - a.events()[i].amplitude) < 0.1);
  }
}

RC_GTEST_PROP(WeldDetectorProperties, SameSamplesSameBits, ()) {
  const auto welds = draw_welds();
  const auto seed = static_cast<std::uint64_t>(draw(0, 1000));
  WeldDetector first({});
  WeldDetector second({});
  Crawl a(first, welds_at(welds), 0.2, seed);
  Crawl b(second, welds_at(welds), 0.2, seed);
  a.go_to(welds.back() + 3.0);
  b.go_to(welds.back() + 3.0);
  RC_ASSERT(a.distances() == b.distances());
}

RC_GTEST_PROP(WeldDetectorProperties, SurvivesAnySamples, ()) {
  const WeldDetectorParameters parameters{
      .channels = 2, .warm_up = 0.5, .report_again = draw(0, 2) == 1, .turn_distance = 0.1};
  WeldDetector detector(parameters);
  double at = 0.0;
  for (int i = 0; i < 3000; ++i) {
    switch (draw(0, 40)) {
      case 0:
        at = *rc::gen::element(std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300, 0.0, 1e6);
        break;
      case 1:
        at += 0.1 * draw(-300, 300);
        break;
      case 2:
        detector.finish();
        break;
      default:
        at = (std::isfinite(at) ? at : 0.0) + 0.001 * draw(-20, 30);
    }
    const auto value = [&] {
      return draw(0, 30) == 0
                 ? *rc::gen::element(std::numeric_limits<double>::infinity(), 1e99, -1e99, 0.0)
                 : 0.01 * draw(-100, 100);
    };
    const std::array<Impedance, 2> values = {Impedance{value(), value()},
                                             Impedance{value(), value()}};
    for (const auto& event : detector.update(at, values)) {
      RC_ASSERT(std::isfinite(event.distance));
      RC_ASSERT(event.standard_deviation > 0.0);
      RC_ASSERT(event.confidence >= 0.0 && event.confidence <= 1.0);
      RC_ASSERT(event.match >= 0.0 && event.match <= 1.0);
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
