// SPDX-License-Identifier: Apache-2.0
#include "offset_memory.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kSigma = 0.02;
constexpr std::size_t kPipe = 2;
constexpr int kRow = 2;

using Support = std::array<PipeSupport, kMaxPipes>;

Support all_found() {
  Support support{};
  support.fill({.searched = 40, .found = 38});
  return support;
}

Support missing(int found) {
  Support support = all_found();
  support[kPipe].found = found;
  return support;
}

/// What an image says after which the offset of one pipe is `mean` within `sigma`.
OffsetBelief image(const OffsetBelief& before, double mean, double sigma) {
  OffsetBelief after = before;
  after.mean[kPipe] = mean;
  after.covariance(kRow, kRow) = sigma * sigma;
  return after;
}

TEST(OffsetMemory, LearnsTheShareOfAnImageThatIsNew) {
  OffsetMemory all(test::drawn_rack(), kSigma);
  OffsetMemory half = all;
  all.learn(image(all.belief(), 0.012, 0.005), all_found(), 1);
  half.learn(image(half.belief(), 0.012, 0.005), all_found(), 0.5);
  EXPECT_NEAR(all.belief().mean[kPipe], 0.012, 1e-12);
  EXPECT_NEAR(all.belief().covariance(kRow, kRow), 2.5e-5, 1e-12);
  EXPECT_LT(half.belief().mean[kPipe], 0.012);
  EXPECT_GT(half.belief().covariance(kRow, kRow), 2.5e-5);
  EXPECT_EQ(all.belief().covariance(0, 0), 0) << "the first pipe is the frame";
}

TEST(OffsetMemory, LearnsNothingOfAPipeThatIsNotFound) {
  OffsetMemory memory(test::drawn_rack(), kSigma);
  memory.learn(image(memory.belief(), 0.012, 0.005), missing(5), 1);
  EXPECT_EQ(memory.belief().mean[kPipe], 0);
  EXPECT_EQ(memory.belief().covariance(kRow, kRow), kSigma * kSigma);
}

TEST(OffsetMemory, DoubtsAPipeThatTenImagesDoNotFind) {
  OffsetMemory memory(test::drawn_rack(), kSigma);
  memory.learn(image(memory.belief(), 0.012, 0.005), all_found(), 1);
  const double known = memory.belief().covariance(kRow, kRow);
  for (int i = 1; i < 10; ++i) {
    memory.learn(memory.belief(), missing(5), 0);
    EXPECT_EQ(memory.belief().covariance(kRow, kRow), known) << i;
  }
  memory.learn(memory.belief(), missing(5), 0);
  EXPECT_DOUBLE_EQ(memory.belief().covariance(kRow, kRow), kSigma * kSigma);
  EXPECT_NEAR(memory.belief().mean[kPipe], 0.012, 1e-12) << "it may only be hard to see";
}

TEST(OffsetMemory, InDoubtKeepsThePlacesButNotHowWellTheyWereKnown) {
  OffsetMemory memory(test::drawn_rack(), kSigma);
  OffsetBelief after = image(memory.belief(), 0.012, 0.005);
  after.covariance(kRow, 1) = after.covariance(1, kRow) = 1e-5;
  memory.learn(after, all_found(), 1);
  ASSERT_GT(memory.belief().covariance(kRow, 1), 0);
  memory.doubt();
  EXPECT_NEAR(memory.belief().mean[kPipe], 0.012, 1e-12);
  EXPECT_DOUBLE_EQ(memory.belief().covariance(kRow, kRow), kSigma * kSigma);
  EXPECT_EQ(memory.belief().covariance(kRow, 1), 0);
  EXPECT_EQ(memory.belief().covariance(0, 0), 0) << "the first pipe is the frame";
}

}  // namespace
}  // namespace pipescout::rack_vision
