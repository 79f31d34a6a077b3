// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_model.hpp"

#include <gtest/gtest.h>

namespace pipescout::rack_vision {
namespace {

TEST(RowOfPipes, LeavesTheGapsBetweenThePipes) {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {10, 0.15}}}, {"b", {{0, 0.2}, {10, 0.2}}, 0.1}};
  const std::vector<Pipe> pipes = row_of_pipes(row);
  EXPECT_DOUBLE_EQ(pipes[0].start.x(), 0.15);
  EXPECT_DOUBLE_EQ(pipes[1].start.x(), 0.3 + 0.1 + 0.2);
  EXPECT_FALSE(pipes[0].movable);
  EXPECT_TRUE(pipes[1].movable);
}

}  // namespace
}  // namespace pipescout::rack_vision
