// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/bounded_vector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <stdexcept>
#include <vector>

namespace pipescout {
namespace {

using ::testing::ElementsAre;

using Numbers = BoundedVector<int, 3>;

TEST(BoundedVectorTest, IsAVectorUpToItsBound) {
  Numbers numbers{1, 2};
  numbers.push_back(3);
  EXPECT_THAT(numbers, ElementsAre(1, 2, 3));
  EXPECT_EQ(numbers.max_size(), 3u);
  EXPECT_EQ(numbers.front(), 1);
  EXPECT_EQ(numbers.at(2), 3);
  EXPECT_EQ(std::accumulate(numbers.begin(), numbers.end(), 0), 6);
  numbers.pop_back();
  numbers.erase(numbers.begin());
  EXPECT_THAT(numbers, ElementsAre(2));
  numbers.insert(numbers.begin(), 7);
  numbers.emplace_back(9);
  EXPECT_THAT(numbers, ElementsAre(7, 2, 9));
  numbers = {4, 5};
  EXPECT_EQ(numbers, (std::vector<int>{4, 5}));
  numbers.assign(3, 8);
  EXPECT_EQ(numbers, (Numbers{8, 8, 8}));
  EXPECT_LT((Numbers{1}), numbers);
}

TEST(BoundedVectorTest, WhatExceedsTheBoundIsRefusedAndChangesNothing) {
  Numbers full{1, 2, 3};
  const std::vector<int> four{1, 2, 3, 4};
  EXPECT_THROW(full.push_back(4), std::length_error);
  EXPECT_THROW(full.emplace_back(4), std::length_error);
  EXPECT_THROW(full.insert(full.begin(), 4), std::length_error);
  EXPECT_THROW(full.insert(full.end(), four.begin(), four.begin() + 1), std::length_error);
  EXPECT_THROW(full.resize(4), std::length_error);
  EXPECT_THROW(full.reserve(4), std::length_error);
  EXPECT_THROW(full.assign(4, 0), std::length_error);
  EXPECT_THROW(full.assign(four.begin(), four.end()), std::length_error);
  EXPECT_THROW(full = four, std::length_error);
  EXPECT_THROW((full = {1, 2, 3, 4}), std::length_error);
  EXPECT_THAT(full, ElementsAre(1, 2, 3));
  EXPECT_THROW(Numbers(4), std::length_error);
  EXPECT_THROW((Numbers{1, 2, 3, 4}), std::length_error);
  EXPECT_THROW(Numbers(four.begin(), four.end()), std::length_error);
}

TEST(BoundedVectorTest, HoldsTruthValues) {
  BoundedVector<bool, 2> truths{true};
  truths.push_back(false);
  EXPECT_TRUE(truths[0]);
  EXPECT_FALSE(truths[1]);
  EXPECT_THROW(truths.push_back(true), std::length_error);
}

}  // namespace
}  // namespace pipescout
