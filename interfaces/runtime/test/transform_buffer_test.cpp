// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transform_buffer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using geometry_msgs::msg::TransformStamped;
using ::testing::HasSubstr;

constexpr double kStart = 100;  // s

Time at(double seconds) {
  return Time(from_seconds(seconds));
}

/// Turned by `yaw` about z, at x.
TransformStamped transform(const std::string& parent, const std::string& child, double seconds,
                           double x = 0, double yaw = 0) {
  TransformStamped result;
  result.header.stamp = to_message(at(seconds));
  result.header.frame_id = parent;
  result.child_frame_id = child;
  result.transform.translation.x = x;
  result.transform.rotation.z = std::sin(yaw / 2);
  result.transform.rotation.w = std::cos(yaw / 2);
  return result;
}

Gid authority(std::uint8_t number) {
  Gid gid;
  gid.bytes[0] = number;
  return gid;
}

double yaw(const TransformStamped& transform) {
  return 2 * std::atan2(transform.transform.rotation.z, transform.transform.rotation.w);
}

class TransformBufferTest : public ::testing::Test {
 protected:
  void take(const TransformStamped& transform, bool is_static = false,
            const Gid& publisher = authority(1)) {
    const auto refusal = buffer_.insert(transform, is_static, publisher);
    ASSERT_FALSE(refusal) << refusal->text;
  }
  TransformRefusal refused(const TransformStamped& transform, bool is_static = false,
                           const Gid& publisher = authority(2)) {
    const auto refusal = buffer_.insert(transform, is_static, publisher);
    EXPECT_TRUE(refusal);
    return refusal.value_or(TransformRefusal{});
  }
  TransformFailure failed(const TransformResult& result) {
    EXPECT_FALSE(result);
    return result ? TransformFailure{} : result.failure();
  }
  TransformBuffer buffer_;
};

TEST_F(TransformBufferTest, InterpolatesBetweenTwoTransforms) {
  take(transform("base", "arm", kStart, 1, 0.2));
  take(transform("base", "arm", kStart + 1, 3, 1.2));
  const TransformResult result = buffer_.lookup("base", "arm", at(kStart + 0.25));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->header.frame_id, "base");
  EXPECT_EQ(result->child_frame_id, "arm");
  EXPECT_EQ(from_message(result->header.stamp), at(kStart + 0.25));
  EXPECT_NEAR(result->transform.translation.x, 1.5, 1e-12);
  EXPECT_NEAR(yaw(*result), 0.45, 1e-12);
  EXPECT_EQ(result.gap(), from_seconds(1));
  EXPECT_EQ(buffer_.lookup("base", "arm", at(kStart + 1)).gap(), Duration::zero());
}

TEST_F(TransformBufferTest, TurnsOnTheShortestArcWhicheverSignTheQuaternionHas) {
  TransformStamped second = transform("base", "arm", kStart + 1, 0, 0.4);
  second.transform.rotation.z *= -1;
  second.transform.rotation.w *= -1;
  take(transform("base", "arm", kStart));
  take(second);
  const TransformResult result = buffer_.lookup("base", "arm", at(kStart + 0.5));
  ASSERT_TRUE(result);
  EXPECT_NEAR(std::abs(std::remainder(yaw(*result), 2 * std::numbers::pi)), 0.2, 1e-12);
}

// geometry2#46: a part of the chain on tf, a part on tf_static.
TEST_F(TransformBufferTest, ComposesWhatMovesAndWhatIsStatic) {
  take(transform("base_link", "pan_link", kStart, 1, std::numbers::pi / 2));
  take(transform("pan_link", "camera", 0, 0.5), true);
  const TransformResult result = buffer_.lookup("base_link", "camera", at(kStart));
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->transform.translation.x, 1, 1e-12);
  EXPECT_NEAR(result->transform.translation.y, 0.5, 1e-12);
  const TransformResult back = buffer_.lookup("camera", "base_link", at(kStart));
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->transform.translation.x, -0.5, 1e-12);
  EXPECT_NEAR(back->transform.translation.y, 1, 1e-12);
}

TEST_F(TransformBufferTest, BranchesMeetWhereTheyPart) {
  take(transform("map", "base", kStart, 100), false);
  take(transform("base", "left", kStart, -1));
  take(transform("base", "right", kStart, 2));
  // map is above both and not needed, so its transform need not be known at that time.
  take(transform("base", "left", kStart + 1, -1));
  take(transform("base", "right", kStart + 1, 2));
  const TransformResult result = buffer_.lookup("left", "right", at(kStart + 1));
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->transform.translation.x, 3, 1e-12);
}

TEST_F(TransformBufferTest, AFrameIsWhereItIsAlsoInItself) {
  take(transform("base", "arm", kStart, 1));
  const TransformResult result = buffer_.lookup("arm", "arm", at(kStart + 77));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->transform, geometry_msgs::msg::Transform({}, {0, 0, 0, 1}));
}

TEST_F(TransformBufferTest, TheLatestIsTheLatestThatAllOfTheChainHave) {
  take(transform("map", "base", kStart, 1));
  take(transform("map", "base", kStart + 2, 3));
  take(transform("base", "arm", kStart, 0));
  take(transform("base", "arm", kStart + 1, 0));
  take(transform("arm", "camera", 0), true);
  const TransformResult result = buffer_.lookup("map", "camera");
  ASSERT_TRUE(result);
  EXPECT_EQ(from_message(result->header.stamp), at(kStart + 1));
  EXPECT_NEAR(result->transform.translation.x, 2, 1e-12);
  EXPECT_EQ(from_message(buffer_.lookup("arm", "camera")->header.stamp), kLatestTransform);
}

TEST_F(TransformBufferTest, WhatWasSeenThenIsNowOverAFixedFrame) {
  take(transform("odom", "base", kStart, 1));
  take(transform("odom", "base", kStart + 1, 4));
  const TransformResult result = buffer_.lookup("base", at(kStart + 1), "base", at(kStart), "odom");
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->transform.translation.x, -3, 1e-12);
  EXPECT_EQ(from_message(result->header.stamp), at(kStart + 1));
  EXPECT_EQ(failed(buffer_.lookup("base", at(kStart + 1), "base", at(kStart), "map")).error,
            TransformError::kUnknownFrame);
}

TEST_F(TransformBufferTest, AFrameThatNobodySentIsNamed) {
  take(transform("base", "arm", kStart));
  const TransformFailure failure = failed(buffer_.lookup("base", "camera", at(kStart)));
  EXPECT_EQ(failure.error, TransformError::kUnknownFrame);
  EXPECT_EQ(
      failure.text,
      "no transform from 'camera' to 'base': frame 'camera' is not known; nobody has sent it");
  EXPECT_EQ(failed(buffer_.lookup("", "arm")).error, TransformError::kUnknownFrame);
}

TEST_F(TransformBufferTest, TheRootsOfTwoTreesAreNamed) {
  take(transform("map", "base", kStart));
  take(transform("base", "pan", kStart));
  take(transform("mast", "camera", 0), true);
  const TransformFailure failure = failed(buffer_.lookup("pan", "camera", at(kStart)));
  EXPECT_EQ(failure.error, TransformError::kDisconnected);
  EXPECT_THAT(failure.text, HasSubstr("below 'map' and 'mast'"));
}

TEST_F(TransformBufferTest, WhatIsAskedForAndWhatIsThereIsSaid) {
  take(transform("base", "arm", kStart));
  take(transform("base", "arm", kStart + 1));
  take(transform("arm", "camera", 0), true);
  const TransformFailure future = failed(buffer_.lookup("base", "camera", at(kStart + 1.5)));
  EXPECT_EQ(future.error, TransformError::kFuture);
  EXPECT_THAT(future.text, HasSubstr("asked for 101.500000000 s, but 'arm' in 'base' is known from "
                                     "100.000000000 to 101.000000000 s"));
  EXPECT_EQ(failed(buffer_.lookup("base", "camera", at(kStart - 0.5))).error,
            TransformError::kPast);
  TransformFailure reason;
  EXPECT_FALSE(buffer_.can_transform("base", "camera", at(kStart + 1.5), &reason));
  EXPECT_EQ(reason.text, future.text);
  EXPECT_TRUE(buffer_.can_transform("base", "camera", at(kStart + 0.5)));
}

TEST_F(TransformBufferTest, KeepsTheHistoryAndNoMore) {
  for (int i = 0; i <= 200; ++i) {
    take(transform("base", "arm", kStart + 0.1 * i));
  }
  EXPECT_TRUE(buffer_.lookup("base", "arm", at(kStart + 10)));
  EXPECT_EQ(failed(buffer_.lookup("base", "arm", at(kStart + 9.95))).error, TransformError::kPast);
  buffer_.extend_history(from_seconds(20));
  buffer_.extend_history(from_seconds(1));
  take(transform("base", "arm", kStart + 29));
  EXPECT_TRUE(buffer_.lookup("base", "arm", at(kStart + 10)));
}

TEST_F(TransformBufferTest, MemoryIsBounded) {
  TransformBuffer small({.samples_per_frame = 10, .frames = 3});
  for (int i = 0; i < 100; ++i) {
    ASSERT_FALSE(small.insert(transform("base", "arm", kStart + 0.001 * i), false));
  }
  EXPECT_EQ(small.frames().front().oldest, at(kStart + 0.090));
  EXPECT_FALSE(small.insert(transform("arm", "camera", kStart), false));
  const auto refusal = small.insert(transform("camera", "lens", kStart), false);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->fault, TransformFault::kTooManyFrames);
}

TEST_F(TransformBufferTest, WhatComesOutOfOrderTakesItsPlace) {
  take(transform("base", "arm", kStart, 0));
  take(transform("base", "arm", kStart + 2, 2));
  take(transform("base", "arm", kStart + 1, 5));
  EXPECT_NEAR(buffer_.lookup("base", "arm", at(kStart + 1))->transform.translation.x, 5, 1e-12);
  take(transform("base", "arm", kStart - 1, 7));
  EXPECT_NEAR(buffer_.lookup("base", "arm", at(kStart - 1))->transform.translation.x, 7, 1e-12);
  // Of two for one time the first holds, as in tf2.
  take(transform("base", "arm", kStart + 1, 9));
  EXPECT_NEAR(buffer_.lookup("base", "arm", at(kStart + 1))->transform.translation.x, 5, 1e-12);
}

TEST_F(TransformBufferTest, WhatIsNoTransformIsRefusedAndNamed) {
  TransformStamped bad = transform("base", "arm", kStart);
  bad.transform.rotation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(bad).fault, TransformFault::kNotFinite);
  bad = transform("base", "arm", kStart, std::numeric_limits<double>::infinity());
  EXPECT_EQ(refused(bad).fault, TransformFault::kNotFinite);
  bad = transform("base", "arm", kStart);
  bad.transform.rotation.w = 0;
  const TransformRefusal refusal = refused(bad);
  EXPECT_EQ(refusal.fault, TransformFault::kNotNormalised);
  EXPECT_THAT(refusal.text, HasSubstr("'arm' in 'base'"));
  EXPECT_EQ(refused(transform("arm", "/arm", kStart)).fault, TransformFault::kSameFrame);
  EXPECT_EQ(refused(transform("", "arm", kStart)).fault, TransformFault::kNoFrame);
  EXPECT_EQ(refused(transform("base", "/", kStart)).fault, TransformFault::kNoFrame);
  EXPECT_TRUE(buffer_.frames().empty());
}

TEST_F(TransformBufferTest, ALeadingSlashIsNoPartOfAName) {
  take(transform("/base", "/arm", kStart));
  EXPECT_TRUE(buffer_.lookup("base", "/arm"));
}

TEST_F(TransformBufferTest, ALoopIsRefusedAndItsChainNamed) {
  take(transform("a", "b", kStart));
  take(transform("b", "c", kStart));
  const TransformRefusal refusal = refused(transform("c", "a", kStart));
  EXPECT_EQ(refusal.fault, TransformFault::kLoop);
  EXPECT_EQ(refusal.text, "loop of transforms: 'a' in 'c' in 'b' in 'a'");
  EXPECT_TRUE(buffer_.lookup("a", "c"));
}

TEST_F(TransformBufferTest, OfTwoParentsTheFirstStaysWhileItsPublisherSpeaks) {
  take(transform("odom", "base", kStart));
  const TransformRefusal refusal = refused(transform("map", "base", kStart + 0.5));
  EXPECT_EQ(refusal.fault, TransformFault::kTwoParents);
  EXPECT_THAT(refusal.text, HasSubstr("'base' has two parents: 'odom', which stays, and 'map'"));
  EXPECT_EQ(refusal.told_by, authority(1));
  EXPECT_FALSE(buffer_.can_transform("map", "base"));
  // The other one has been silent for more than a second: the child was moved over.
  take(transform("map", "base", kStart + 1.5, 8));
  EXPECT_NEAR(buffer_.lookup("map", "base")->transform.translation.x, 8, 1e-12);
  EXPECT_EQ(failed(buffer_.lookup("odom", "base")).error, TransformError::kDisconnected);
}

TEST_F(TransformBufferTest, AStaticParentIsCorrectedByAStaticOneOnly) {
  take(transform("pan", "camera", 0), true);
  EXPECT_EQ(refused(transform("tilt", "camera", kStart)).fault, TransformFault::kTwoParents);
  EXPECT_EQ(refused(transform("pan", "camera", kStart)).fault, TransformFault::kTwoKinds);
  take(transform("tilt", "camera", 0, 2), true);
  EXPECT_NEAR(buffer_.lookup("tilt", "camera", at(kStart))->transform.translation.x, 2, 1e-12);
  take(transform("base", "tilt", kStart));
  EXPECT_EQ(refused(transform("base", "tilt", 0), true).fault, TransformFault::kTwoKinds);
}

TEST_F(TransformBufferTest, AClockThatWasSetBackBeginsAnew) {
  take(transform("odom", "base", kStart, 1));
  take(transform("odom", "base", 1, 2));
  const TransformResult result = buffer_.lookup("odom", "base");
  ASSERT_TRUE(result);
  EXPECT_EQ(from_message(result->header.stamp), at(1));
  EXPECT_EQ(failed(buffer_.lookup("odom", "base", at(kStart))).error, TransformError::kFuture);
  take(transform("map", "base", kStart));
  take(transform("odom", "base", 1));  // the world that begins again has the parent of before
  EXPECT_TRUE(buffer_.can_transform("odom", "base"));
}

TEST_F(TransformBufferTest, ClearingForgetsWhatMoves) {
  take(transform("odom", "base", kStart));
  take(transform("base", "mast", 0), true);
  take(transform("mast", "camera", 0, 3), true);
  buffer_.clear_moving();
  EXPECT_EQ(failed(buffer_.lookup("odom", "base")).error, TransformError::kUnknownFrame);
  EXPECT_NEAR(buffer_.lookup("base", "camera")->transform.translation.x, 3, 1e-12);
  take(transform("odom", "base", 1, 1));
  EXPECT_NEAR(buffer_.lookup("odom", "camera")->transform.translation.x, 4, 1e-12);
}

TEST_F(TransformBufferTest, TreesThatGrowFromTheLeavesAreOne) {
  take(transform("c", "d", kStart, 1));
  take(transform("b", "c", kStart, 1));
  take(transform("b", "e", kStart, 5));
  take(transform("a", "b", kStart, 1));
  EXPECT_NEAR(buffer_.lookup("a", "d")->transform.translation.x, 3, 1e-12);
  EXPECT_NEAR(buffer_.lookup("e", "d")->transform.translation.x, -3, 1e-12);
}

TEST_F(TransformBufferTest, SaysWhichFramesThereAre) {
  take(transform("base", "arm", kStart));
  take(transform("base", "arm", kStart + 1));
  take(transform("arm", "camera", 0), true, authority(7));
  const auto frames = buffer_.frames();
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].name, "arm");
  EXPECT_EQ(frames[0].parent, "base");
  EXPECT_EQ(frames[0].received, 2U);
  EXPECT_EQ(frames[0].oldest, at(kStart));
  EXPECT_EQ(frames[0].newest, at(kStart + 1));
  EXPECT_EQ(frames[1].name, "base");
  EXPECT_TRUE(frames[1].parent.empty());
  EXPECT_TRUE(frames[2].is_static);
  EXPECT_EQ(frames[2].authority, authority(7));
}

TEST(TransformBufferOptionsTest, AreChecked) {
  EXPECT_THROW(TransformBuffer({.history = Duration::zero()}), std::invalid_argument);
  EXPECT_THROW(TransformBuffer({.samples_per_frame = 1}), std::invalid_argument);
  EXPECT_THROW(TransformBuffer({.frames = 1}), std::invalid_argument);
  EXPECT_THROW(TransformBuffer({.parent_silence = Duration(-1)}), std::invalid_argument);
}

// For the thread sanitizer, and because a reader must never see half of a change.
TEST_F(TransformBufferTest, ReadersSeeWholeTransformsWhileOthersWrite) {
  constexpr int kTransforms = 2000;
  take(transform("base", "arm", kStart, 0));
  std::vector<std::thread> threads;
  threads.reserve(4);
  threads.emplace_back([this] {
    for (int i = 1; i <= kTransforms; ++i) {
      buffer_.insert(transform("base", "arm", kStart + i, i, 0.001 * i), false);
      if (i % 100 == 0) {
        buffer_.insert(transform("base", "part_" + std::to_string(i), 0), true);
      }
    }
  });
  std::vector<double> worst(3, 0.0);
  for (double& error : worst) {
    threads.emplace_back([this, &error] {
      for (int i = 0; i < kTransforms; ++i) {
        const TransformResult found = buffer_.lookup("base", "arm");
        if (!found) {
          error = 1;
          return;
        }
        const double x = found->transform.translation.x;
        const double since = to_seconds(from_message(found->header.stamp) - at(kStart));
        error = std::max({error, std::abs(x - since), std::abs(yaw(*found) - 0.001 * x)});
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const double error : worst) {
    EXPECT_LT(error, 1e-9);
  }
  EXPECT_NEAR(buffer_.lookup("base", "arm")->transform.translation.x, kTransforms, 1e-12);
}

}  // namespace
}  // namespace pipescout
