// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/pipe_profile.hpp"

#include <gmock/gmock.h>

#include <rapidcheck.h>
#include <cmath>
#include <limits>

namespace pipescout::thermal {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<float> level(std::size_t samples, float celsius) {
  return std::vector<float>(samples, celsius);
}

/// Samples from `from` on are as warm as that.
std::vector<float>& warm(std::vector<float>& profile, std::size_t from, std::size_t samples,
                         float celsius) {
  std::fill_n(profile.begin() + static_cast<std::ptrdiff_t>(from), samples, celsius);
  return profile;
}

ProfileAnalysis analysed(const std::vector<float>& profile, const ProfileParameters& p = {},
                         const ProfileAnalysis::Conditions& conditions = {}) {
  ProfileAnalysis analysis(p);
  analysis.analyse(profile, {}, conditions);
  return analysis;
}

TEST(PipeProfile, EquationFour) {
  std::vector<float> change;
  absolute_change(std::vector<float>{1, 4, 2, 2}, 1, change);
  EXPECT_EQ(change, (std::vector<float>{3, 2, 0}));
  absolute_change(std::vector<float>{1, 4, 2, 2}, 2, change);
  EXPECT_EQ(change, (std::vector<float>{1, 2}));
  absolute_change(std::vector<float>{1}, 1, change);
  EXPECT_TRUE(change.empty());
}

TEST(PipeProfile, TheOnsetStaysWhereMoreOfALeakComesIntoView) {
  auto profile = level(140, 150);
  for (std::size_t i = 60; i < 140; ++i) {
    profile[i] = 150 + 2 * static_cast<float>(i - 59);
  }
  double least = 0;
  for (const std::size_t seen : {100U, 120U}) {
    const auto analysis = analysed({profile.begin(), profile.begin() + static_cast<int>(seen)});
    ASSERT_EQ(analysis.leaks().size(), 1U) << seen;
    const LeakStretch& leak = analysis.leaks().front();
    // 25 K above the pipe.
    EXPECT_NEAR(leak.onset_from, 72.0, 0.1) << seen;
    EXPECT_TRUE(std::isnan(leak.onset_to)) << seen;
    EXPECT_GT(leak.from, least + 3) << seen;
    least = leak.from;
  }
}

TEST(PipeProfile, ALevelPipeIsOnePart) {
  const auto analysis = analysed(level(100, 150));
  ASSERT_EQ(analysis.parts().size(), 1U);
  EXPECT_DOUBLE_EQ(analysis.parts()[0].from, 0);
  EXPECT_DOUBLE_EQ(analysis.parts()[0].to, 100);
  EXPECT_DOUBLE_EQ(analysis.parts()[0].mean, 150);
  EXPECT_EQ(analysis.parts()[0].kind, PartKind::kPipe);
  EXPECT_DOUBLE_EQ(analysis.reference_temperature(), 150);
}

TEST(PipeProfile, AStepIsAnEdgeWhereItIs) {
  auto profile = level(100, 150);
  const auto analysis = analysed(warm(profile, 40, 30, 250));
  ASSERT_EQ(analysis.parts().size(), 3U);
  EXPECT_NEAR(analysis.parts()[1].from, 40, 1e-6);
  EXPECT_NEAR(analysis.parts()[1].to, 70, 1e-6);
  EXPECT_EQ(analysis.parts()[1].kind, PartKind::kLeak);
  ASSERT_EQ(analysis.leaks().size(), 1U);
  EXPECT_NEAR(analysis.leaks()[0].from, 40, 0.5);
  EXPECT_NEAR(analysis.leaks()[0].to, 70, 0.5);
  EXPECT_NEAR(analysis.leaks()[0].mean, 250, 1e-3);
}

/// Blur moves no edge: that of the derivative over several samples neither, nor half the height.
TEST(PipeProfile, BlurMovesNoEdge) {
  auto sharp = level(120, 150);
  warm(sharp, 45, 30, 230);
  std::vector<float> blurred = sharp;
  for (std::size_t i = 4; i + 4 < sharp.size(); ++i) {
    float sum = 0;
    for (std::size_t k = i - 4; k <= i + 4; ++k) {
      sum += sharp[k];
    }
    blurred[i] = sum / 9;
  }
  const auto analysis = analysed(blurred);
  ASSERT_EQ(analysis.leaks().size(), 1U);
  EXPECT_NEAR(analysis.leaks()[0].from, 45, 0.6);
  EXPECT_NEAR(analysis.leaks()[0].to, 75, 0.6);
  // The paper's change between neighbours does not see it.
  EXPECT_EQ(analysed(blurred, ProfileParameters::torresol()).parts().size(), 1U);
}

TEST(PipeProfile, ALeakThatComesSlowlyIsFoundByCreeping) {
  auto profile = level(200, 150);
  for (std::size_t i = 0; i < 60; ++i) {
    profile[60 + i] += static_cast<float>(3 * std::min(i, 59 - i));
  }
  EXPECT_EQ(analysed(profile).leaks().size(), 1U);
  ProfileParameters p;
  p.split_creeping = false;
  EXPECT_TRUE(analysed(profile, p).leaks().empty());
}

TEST(PipeProfile, AShortPartIsAJoint) {
  auto profile = level(100, 150);
  const auto analysis = analysed(warm(profile, 40, 6, 260));
  EXPECT_TRUE(analysis.leaks().empty());
  ASSERT_EQ(analysis.parts().size(), 3U);
  EXPECT_EQ(analysis.parts()[1].kind, PartKind::kShort);
  EXPECT_EQ(analysed(profile, {}, {0.04, {}}).leaks().size(), 1U);  // 0.24 m
  EXPECT_TRUE(analysed(profile, {}, {0.02, {}}).leaks().empty());   // 0.12 m
}

TEST(PipeProfile, AJointWithinALeakDoesNotDivideIt) {
  auto profile = level(120, 150);
  warm(profile, 30, 60, 260);
  const auto analysis = analysed(warm(profile, 55, 5, 120));
  ASSERT_EQ(analysis.leaks().size(), 1U);
  EXPECT_NEAR(analysis.leaks()[0].from, 30, 0.5);
  EXPECT_NEAR(analysis.leaks()[0].to, 90, 0.5);
}

TEST(PipeProfile, AJointBesideABodyIsNoLeakThoughBothAreAsLongAsOne) {
  auto profile = level(100, 150);
  warm(profile, 40, 14, 230);
  std::vector<std::uint8_t> shaped(profile.size(), 1);
  std::fill_n(shaped.begin() + 40, 6, std::uint8_t{0});
  ProfileAnalysis analysis({});
  analysis.analyse(profile, shaped, {0.02, {}});  // of 0.28 m, 0.16 m are of the pipe
  EXPECT_TRUE(analysis.leaks().empty());
  analysis.analyse(profile, {}, {0.02, {}});
  EXPECT_EQ(analysis.leaks().size(), 1U);
}

TEST(PipeProfile, WhatIsHiddenStaysSo) {
  auto profile = level(120, 150);
  warm(profile, 50, 20, kNan);
  const auto analysis = analysed(warm(profile, 70, 30, 260));
  ASSERT_EQ(analysis.parts().size(), 4U);
  EXPECT_EQ(analysis.parts()[1].kind, PartKind::kHidden);
  EXPECT_TRUE(std::isnan(analysis.parts()[1].mean));
  ASSERT_EQ(analysis.leaks().size(), 1U);
  EXPECT_TRUE(analysis.leaks()[0].open_at_start);
  EXPECT_FALSE(analysis.leaks()[0].open_at_end);
}

TEST(PipeProfile, NothingSeenIsNothingKnown) {
  const auto hidden = analysed(level(50, kNan));
  ASSERT_EQ(hidden.parts().size(), 1U);
  EXPECT_EQ(hidden.parts()[0].kind, PartKind::kHidden);
  EXPECT_TRUE(std::isnan(hidden.reference_temperature()));
  EXPECT_TRUE(analysed({}).parts().empty());
}

TEST(PipeProfile, WhatHasNotThePipesShapeIsNoLeak) {
  auto profile = level(100, 150);
  warm(profile, 40, 30, 250);
  std::vector<std::uint8_t> shaped(100, 1);
  std::fill_n(shaped.begin() + 40, 30, std::uint8_t{0});
  ProfileAnalysis analysis{ProfileParameters{}};
  analysis.analyse(profile, shaped, {});
  EXPECT_TRUE(analysis.leaks().empty());
  EXPECT_EQ(analysis.parts()[1].kind, PartKind::kNotThisPipe);
}

TEST(PipeProfile, TheFlankOfABodyBeforeThePipeIsNoLeak) {
  auto profile = level(100, 150);
  warm(profile, 42, 26, 300);
  const float flank[] = {166, 200, 241, 276};
  std::copy(std::begin(flank), std::end(flank), profile.begin() + 38);
  std::vector<std::uint8_t> shaped(100, 1);
  std::fill_n(shaped.begin() + 41, 27, std::uint8_t{0});
  ProfileAnalysis analysis{ProfileParameters{}};
  analysis.analyse(profile, shaped, {});
  EXPECT_TRUE(analysis.leaks().empty());
}

TEST(PipeProfile, TheKnownReferenceCountsWhereThePipeIsMuchWarmer) {
  EXPECT_DOUBLE_EQ(analysed(level(50, 170), {}, {0, 150.0}).reference_temperature(), 170);
  const auto all = analysed(level(50, 250), {}, {0, 150.0});
  EXPECT_DOUBLE_EQ(all.reference_temperature(), 150);
  ASSERT_EQ(all.leaks().size(), 1U);
}

/// Any profile: parts follow each other from end to end, leaks lie in order and within, and neither
/// depends on where the scale of temperatures begins or on the direction along the pipe.
TEST(PipeProfileProperties, PartsTileAndLabelsAreInvariant) {
  EXPECT_TRUE(rc::check([] {
    const auto pieces = *rc::gen::container<std::vector<std::pair<int, int>>>(
        rc::gen::pair(rc::gen::resize(rc::kNominalSize, rc::gen::inRange(1, 40)),
                      rc::gen::element(140, 150, 160, 230, 260, 300, -1)));
    std::vector<float> profile;
    for (const auto& [samples, celsius] : pieces) {
      profile.insert(profile.end(), static_cast<std::size_t>(samples),
                     celsius < 0 ? kNan : static_cast<float>(celsius));
    }
    const auto analysis = analysed(profile);
    double at = 0;
    for (const PipePart& part : analysis.parts()) {
      RC_ASSERT(part.from == at);
      RC_ASSERT(part.to > part.from);
      at = part.to;
    }
    RC_ASSERT(at == static_cast<double>(profile.size()));
    at = 0;
    for (const LeakStretch& leak : analysis.leaks()) {
      RC_ASSERT(leak.from >= at);
      RC_ASSERT(leak.to > leak.from);
      RC_ASSERT(leak.mean >= analysis.reference_temperature() + 50);
      RC_ASSERT(leak.peak >= leak.mean - 1e-3);
      at = leak.to;
    }
    RC_ASSERT(at <= static_cast<double>(profile.size()));

    std::vector<float> shifted = profile;
    for (float& value : shifted) {
      value += 64;  // exact in float
    }
    const auto warmer = analysed(shifted);
    RC_ASSERT(warmer.leaks().size() == analysis.leaks().size());
    RC_ASSERT(warmer.parts().size() == analysis.parts().size());

    const std::vector<float> reversed(profile.rbegin(), profile.rend());
    const auto back = analysed(reversed);
    RC_ASSERT(back.leaks().size() == analysis.leaks().size());
  }));
}

}  // namespace
}  // namespace pipescout::thermal
