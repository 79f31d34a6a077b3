// SPDX-License-Identifier: Apache-2.0
// Real impedance-plane signals: ten passes of a probe in a laboratory (files var_peq_NN.csv of the
// data set eddy_current_passes: time s, X V, Y V). The folder of the data sets comes from the
// environment variable PIPESCOUT_SHARED_DATA; without it these tests say that they are skipped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"

namespace pipescout::odometry {
namespace {

struct Pass {
  std::string name;
  std::vector<Impedance> values;  // every 1/256 s
  std::size_t crossing = 0;       // between the two lobes: half way between the extremes
};

std::vector<Pass> read_passes(const std::filesystem::path& folder) {
  std::vector<Pass> passes;
  for (int number = 1; number <= 10; ++number) {
    char name[32];
    std::snprintf(name, sizeof name, "var_peq_%02d.csv", number);
    std::ifstream file(folder / name);
    Pass pass{.name = name, .values = {}};
    for (std::string line; std::getline(file, line);) {
      double time = 0.0;
      Impedance value;
      if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &time, &value.x, &value.y) == 3) {
        pass.values.push_back(value);
      }
    }
    if (pass.values.size() < 1000) {
      return {};
    }
    // Along the direction in which the lobes are farthest apart.
    double farthest = -1.0;
    for (std::size_t i = 0; i < pass.values.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(i + 256, pass.values.size()); ++j) {
        const double apart =
            std::hypot(pass.values[i].x - pass.values[j].x, pass.values[i].y - pass.values[j].y);
        if (apart > farthest) {
          farthest = apart;
          pass.crossing = (i + j) / 2;
        }
      }
    }
    passes.push_back(std::move(pass));
  }
  return passes;
}

class EddyCurrentPasses : public testing::Test {
 protected:
  void SetUp() override {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread.
    const char* const shared = std::getenv("PIPESCOUT_SHARED_DATA");
    if (shared != nullptr) {
      passes_ = read_passes(std::filesystem::path(shared) / "eddy_current_passes");
    }
    if (passes_.empty()) {
      GTEST_SKIP() << "no eddy_current_passes below PIPESCOUT_SHARED_DATA: REAL SIGNALS NOT TESTED";
    }
  }

  std::vector<Pass> passes_;
};

/// The speed is not known; this one makes the pulses as wide as those of welds.
constexpr double kMetresPerSample = 0.1 / 256.0;
constexpr WeldDetectorParameters kLaboratory = {.cell = 0.0015,
                                                .smallest_width = 0.01,
                                                .largest_width = 0.07,
                                                .warm_up = 0.5,
                                                .noise_floor = 0.002,  // the resolution is 0.001 V
                                                .frozen_after = 0};

TEST_F(EddyCurrentPasses, EachHasOnePulseWhereItsLobesMeet) {
  for (const auto& pass : passes_) {
    WeldDetector detector(kLaboratory);
    std::vector<WeldEvent> events;
    double at = 0.0;
    const auto feed = [&](const Impedance& value) {
      const auto found = detector.update(at, {&value, 1});
      events.insert(events.end(), found.begin(), found.end());
      at += kMetresPerSample;
    };
    // Plain pipe before and after: the level of the first and of the last samples, with noise of
    // three steps of the driver.
    std::mt19937_64 engine(1);
    std::normal_distribution<double> noise(0.0, 0.003);
    const auto quiet = [&](const Impedance& level) {
      for (int i = 0; i < 4000; ++i) {
        feed({level.x + noise(engine), level.y + noise(engine)});
      }
    };
    quiet(pass.values.front());
    const double start = at;
    for (const auto& value : pass.values) {
      feed(value);
    }
    quiet(pass.values.back());
    const auto rest = detector.finish();
    events.insert(events.end(), rest.begin(), rest.end());

    const auto& counts = detector.counts();
    ASSERT_EQ(events.size(), 1U) << pass.name << ": " << counts.too_narrow << " too narrow, "
                                 << counts.too_wide << " too wide, " << counts.wrong_shape
                                 << " of wrong shape, " << counts.crowded << " crowded";
    const double expected = start + kMetresPerSample * static_cast<double>(pass.crossing);
    EXPECT_NEAR(events[0].distance, expected, 0.15 * events[0].width) << pass.name;
    EXPECT_GT(events[0].confidence, 0.6) << pass.name;
    std::printf("%s: width %.1f mm, match %.3f, phase %4.0f deg, off by %.1f %% of the width\n",
                pass.name.c_str(), 1e3 * events[0].width, events[0].match,
                events[0].phase * 180.0 / 3.14159265,
                100.0 * (events[0].distance - expected) / events[0].width);
  }
}

}  // namespace
}  // namespace pipescout::odometry
