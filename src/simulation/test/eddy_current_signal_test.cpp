// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/eddy_current_signal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::simulation {
namespace {

using testing::HasSubstr;
using Complex = std::complex<double>;

EddyCurrentSignal still(std::vector<PipeFeature> features) {
  return {undisturbed(), std::move(features), 1};
}

TEST(WeldPulse, HasItsPeakPhaseAndMiddle) {
  const WeldPulse pulse{.peak = 2.0, .phase = 0.7, .lobe_distance = 0.04, .slenderness = 1.5};
  const auto signal = still({make_weld(10.0, pulse)});
  EXPECT_NEAR(std::abs(signal.pulses_at(10.0)), 0.0, 1e-12);
  double largest = 0.0;
  double at = 0.0;
  for (double d = 9.9; d < 10.0; d += 1e-4) {
    if (std::abs(signal.pulses_at(d)) > largest) {
      largest = std::abs(signal.pulses_at(d));
      at = d;
    }
    EXPECT_NEAR(std::abs(signal.pulses_at(d) + signal.pulses_at(20.0 - d)), 0.0, 1e-9) << d;
  }
  EXPECT_NEAR(largest, 2.0, 0.02);
  EXPECT_NEAR(at, 9.98, 0.001);
  EXPECT_NEAR(std::arg(signal.pulses_at(at)), 0.7, 1e-12);
}

TEST(WeldPulse, IsOpenedByQuadratureAndTiltedByAsymmetry) {
  const auto open = still({make_weld(0.0, {.quadrature = 0.3})});
  double aside = 0.0;
  for (double d = -0.05; d < 0.05; d += 1e-4) {
    aside = std::max(aside, std::abs(open.pulses_at(d).imag()));
  }
  EXPECT_NEAR(aside, 0.3, 0.05);
  const auto tilted = still({make_weld(0.0, {.slenderness = 3.0, .asymmetry = 0.2})});
  EXPECT_NEAR(std::abs(tilted.pulses_at(-0.02)), 1.2, 0.01);
  EXPECT_NEAR(std::abs(tilted.pulses_at(0.02)), 0.8, 0.01);
}

TEST(EddyCurrentSignal, IsNothingButPulsesWhenUndisturbed) {
  const auto features = draw_features({.length = 100.0}, 3);
  auto signal = still(features);
  for (int i = 0; i < 50000; ++i) {
    const double distance = 0.002 * i;
    Complex expected{};
    for (const auto& feature : features) {
      for (const auto& lobe : feature.lobes) {
        const double u = (distance - feature.position - lobe.offset) / lobe.deviation;
        expected += lobe.amplitude * std::exp(-u * u / 2.0);
      }
    }
    const auto sample = signal.next(distance);
    ASSERT_NEAR(std::abs(sample.value - expected), 0.0, 1e-6) << distance;
    ASSERT_EQ(sample.fault, SampleFault::kNone);
    ASSERT_DOUBLE_EQ(sample.time, i / 200.0);
  }
}

TEST(EddyCurrentSignal, HasTheSamePulseAtAnySpeedAndInBothDirections) {
  auto parameters = undisturbed();
  parameters.lift_off_loss = 0.3;
  parameters.lift_off_rotation = 0.4;
  parameters.lift_off_baseline = 1.0;
  const auto features = draw_features({.length = 30.0}, 4);
  EddyCurrentSignal slow(parameters, features, 9);
  EddyCurrentSignal fast(parameters, features, 9);
  std::vector<Complex> forward;
  for (int i = 0; i <= 30000; ++i) {
    forward.push_back(slow.next(0.001 * i).value);
  }
  for (int i = 30000; i >= 0; i -= 10) {
    ASSERT_NEAR(std::abs(fast.next(0.001 * i).value - forward[static_cast<std::size_t>(i)]), 0.0,
                1e-6);
  }
}

TEST(EddyCurrentSignal, NoiseOfEachChannelHasTheStatedRatioToThePeak) {
  for (const double pink_share : {0.0, 0.5}) {
    auto parameters = undisturbed();
    parameters.peak_snr = 12.0;
    parameters.pink_share = pink_share;
    double sum_x = 0.0;
    double sum_y = 0.0;
    double neighbours = 0.0;
    constexpr int kRuns = 40;
    constexpr int kSamples = 20000;
    for (std::uint64_t run = 0; run < kRuns; ++run) {
      EddyCurrentSignal signal(parameters, {}, run);
      double last = 0.0;
      for (int i = 0; i < kSamples; ++i) {
        const Complex value = signal.next(0.0).value;
        sum_x += value.real() * value.real();
        sum_y += value.imag() * value.imag();
        neighbours += value.real() * last;
        last = value.real();
      }
    }
    const double expected = std::pow(10.0, -12.0 / 10.0);
    EXPECT_NEAR(sum_x / (kRuns * kSamples) / expected, 1.0, 0.05) << pink_share;
    EXPECT_NEAR(sum_y / (kRuns * kSamples) / expected, 1.0, 0.05) << pink_share;
    if (pink_share == 0.0) {
      EXPECT_NEAR(neighbours / sum_x, 0.0, 0.005);
    } else {
      EXPECT_GT(neighbours / sum_x, 0.2);
    }
  }
}

/// The Allan variance of 1/f noise is the same over all times.
TEST(PinkNoise, HasTheSameAllanVarianceOverThreeDecades) {
  std::vector<double> variances;
  for (int length = 8; length <= 8192; length *= 4) {
    std::mt19937_64 engine(5);
    PinkNoise pink(engine);
    double sum = 0.0;
    double last = 0.0;
    const int means = 4000000 / length;
    for (int k = 0; k < means; ++k) {
      double mean = 0.0;
      for (int i = 0; i < length; ++i) {
        mean += pink.next(engine) / length;
      }
      sum += k > 0 ? (mean - last) * (mean - last) / 2.0 : 0.0;
      last = mean;
    }
    variances.push_back(sum / (means - 1));
  }
  const auto [smallest, largest] = std::minmax_element(variances.begin(), variances.end());
  EXPECT_LT(*largest / *smallest, 1.5);
}

TEST(EddyCurrentSignal, HumsAtTheFrequencyOfTheMains) {
  auto parameters = undisturbed();
  parameters.sample_rate = 1000.0;
  parameters.hum = 0.3;
  EddyCurrentSignal signal(parameters, {}, 2);
  Complex spectrum{};
  for (int i = 0; i < 1000; ++i) {
    const auto sample = signal.next(0.0);
    spectrum +=
        sample.value.real() * std::polar(2.0 / 1000.0, -100.0 * std::numbers::pi * sample.time);
  }
  EXPECT_NEAR(std::abs(spectrum), 0.3, 1e-6);
}

TEST(EddyCurrentSignal, SpikesAndDropoutsComeAtTheirRates) {
  EddyCurrentParameters parameters;
  parameters.spikes_per_second = 0.5;
  parameters.dropouts_per_second = 0.2;
  EddyCurrentSignal signal(parameters, {}, 11);
  constexpr int kSamples = 2000000;  // 10000 s
  int spikes = 0;
  int dropouts = 0;
  int run = 0;
  std::array<int, 6> kinds{};
  auto last = SampleFault::kNone;
  Complex last_value{};
  for (int i = 0; i < kSamples; ++i) {
    const auto sample = signal.next(0.0);
    const bool dropped = sample.fault >= SampleFault::kMissing;
    spikes += sample.fault == SampleFault::kSpike && last != SampleFault::kSpike ? 1 : 0;
    if (dropped && sample.fault != last) {
      ++dropouts;
      ++kinds[static_cast<std::size_t>(sample.fault)];
      run = 0;
    }
    run += dropped ? 1 : 0;
    ASSERT_LE(run, 40);  // two in a row at most, 20 samples each
    if (sample.fault == SampleFault::kMissing || sample.fault == SampleFault::kNotANumber) {
      ASSERT_TRUE(std::isnan(sample.value.real()) && std::isnan(sample.value.imag()));
    } else if (sample.fault == SampleFault::kZero) {
      ASSERT_EQ(sample.value, Complex{});
    } else if (sample.fault == SampleFault::kHeld && i > 0) {
      ASSERT_EQ(sample.value, last_value);
    }
    if (!dropped) {
      last_value = sample.value;
    }
    last = sample.fault;
  }
  EXPECT_NEAR(spikes, 5000, 300);
  EXPECT_NEAR(dropouts, 2000, 200);
  for (std::size_t kind = 2; kind < kinds.size(); ++kind) {
    EXPECT_NEAR(kinds[kind], 500, 100) << kind;
  }
}

TEST(EddyCurrentSignal, GainAndBaselineStayWithinTheirBounds) {
  auto parameters = undisturbed();
  parameters.amplitude_drift = 0.5;
  parameters.baseline_drift = 2.0;
  auto plain = undisturbed();
  plain.baseline_drift = 2.0;
  const auto weld = make_weld(0.0, {});
  EddyCurrentSignal drifting(parameters, {weld}, 8);
  EddyCurrentSignal steady(plain, {weld}, 8);
  double largest = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const Complex a = drifting.next(-0.02).value;
    const Complex b = steady.next(-0.02).value;
    const double gain = std::abs(a - b + drifting.pulses_at(-0.02));
    ASSERT_LE(std::abs(std::log(gain)), 0.5 + 0.05);
    largest = std::max(largest, std::abs(std::log(gain)));
    ASSERT_LE(std::abs(b), 2.0 * std::numbers::sqrt2 + 1.1);
  }
  EXPECT_GT(largest, 0.1);
  for (double d = 0.0; d < 1000.0; d += 0.1) {
    ASSERT_GE(drifting.lift_off_at(d), 0.0);
    ASSERT_LE(drifting.lift_off_at(d), 1.0);
  }
}

TEST(EddyCurrentSignal, SameSeedSameBits) {
  const auto features = draw_features({.length = 50.0}, 1);
  EddyCurrentSignal a({}, features, 6);
  EddyCurrentSignal b({}, features, 6);
  EddyCurrentSignal other({}, features, 7);
  int different = 0;
  for (int i = 0; i < 10000; ++i) {
    const auto x = a.next(0.001 * i);
    const auto y = b.next(0.001 * i);
    ASSERT_EQ(x.fault, y.fault);
    ASSERT_TRUE(x.value == y.value || std::isnan(x.value.real()));
    different += other.next(0.001 * i).value != x.value ? 1 : 0;
  }
  EXPECT_GT(different, 9000);
}

TEST(DrawFeatures, FollowTheirStatistics) {
  const PipeParameters parameters{.length = 100000.0, .valves_per_km = 1.0};
  const auto features = draw_features(parameters, 12);
  std::array<int, 4> counts{};
  std::vector<double> welds;
  for (const auto& feature : features) {
    ++counts[static_cast<std::size_t>(feature.kind)];
    if (feature.kind == FeatureKind::kWeld) {
      welds.push_back(feature.position);
    }
  }
  EXPECT_TRUE(std::is_sorted(features.begin(), features.end(),
                             [](const auto& a, const auto& b) { return a.position < b.position; }));
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 1; i < welds.size(); ++i) {
    const double joint = welds[i] - welds[i - 1];
    sum += joint;
    squares += (joint - 12.0) * (joint - 12.0);
  }
  const auto joints = static_cast<double>(welds.size() - 1);
  EXPECT_NEAR(sum / joints, 12.0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / joints), 0.12, 0.005);
  EXPECT_NEAR(counts[1], 83, 30);  // a sixth of 100 would be too close to a weld
  EXPECT_NEAR(counts[2], 300, 60);
  EXPECT_NEAR(counts[3], 300, 60);
  for (const auto& feature : features) {
    if (feature.kind == FeatureKind::kValve) {
      for (const double weld : welds) {
        ASSERT_GE(std::abs(weld - feature.position), 1.0);
      }
    }
  }
}

std::string refusal(const auto& parameters) {
  try {
    parameters.validate();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(EddyCurrentParameters, RefuseWhatIsOutOfRange) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(EddyCurrentParameters{}), "accepted");
  EXPECT_EQ(refusal(undisturbed()), "accepted");
  EXPECT_EQ(refusal(EddyCurrentParameters{.sample_rate = 0.0}),
            "sample_rate: 0 is outside [1, 1e+06]");
  EXPECT_EQ(refusal(EddyCurrentParameters{.weld_peak = -1.0}), "weld_peak: -1 is outside (0, inf)");
  EXPECT_THAT(refusal(EddyCurrentParameters{.peak_snr = kNaN}), HasSubstr("peak_snr: nan"));
  EXPECT_THAT(refusal(EddyCurrentParameters{.pink_share = 1.1}), HasSubstr("pink_share: 1.1"));
  EXPECT_THAT(refusal(EddyCurrentParameters{.hum = -0.1}), HasSubstr("hum: -0.1"));
  EXPECT_THAT(refusal(EddyCurrentParameters{.spikes_per_second = 201.0}),
              HasSubstr("spikes_per_second: 201 is outside [0, 200]"));
  EXPECT_EQ(refusal(PipeParameters{}), "accepted");
  EXPECT_THAT(refusal(PipeParameters{.length = 0.0}), HasSubstr("length: 0"));
  EXPECT_THAT(refusal(PipeParameters{.joint_length = 0.1}), HasSubstr("joint_length: 0.1"));
  EXPECT_THAT(refusal(PipeParameters{.largest_lobe_distance = 0.01}),
              HasSubstr("largest_lobe_distance: 0.01 is outside [0.03, 1]"));
}

TEST(EddyCurrentSignal, RefusesFeaturesThatAreNotFinite) {
  auto weld = make_weld(1.0, {});
  weld.position = std::numeric_limits<double>::infinity();
  EXPECT_THROW(still({weld}), std::invalid_argument);
  weld = make_weld(1.0, {});
  weld.lobes[0].deviation = 0.0;
  EXPECT_THROW(still({weld}), std::invalid_argument);
}

TEST(FeatureKind, HasNames) {
  EXPECT_STREQ(to_string(FeatureKind::kWeld), "weld");
  EXPECT_STREQ(to_string(FeatureKind::kDent), "dent");
  EXPECT_STREQ(to_string(static_cast<FeatureKind>(9)), "unknown");
}

TEST(DrawFeatures, PutsWeldsWhereTheyAre) {
  const std::vector<double> welds{0.0, 11.9, 24.2, 36.0};
  const auto features = draw_features({.length = 40.0}, welds, 3);
  std::vector<double> drawn;
  for (const auto& feature : features) {
    if (feature.kind == FeatureKind::kWeld) {
      drawn.push_back(feature.position);
    }
  }
  EXPECT_EQ(drawn, welds);
  EXPECT_THROW(draw_features({}, std::vector<double>{1.0, 1.0}, 3), std::invalid_argument);
  EXPECT_THROW(draw_features({}, std::vector<double>{NAN}, 3), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
