// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::reproduce {
namespace {

using ::pipescout::testing::run_program;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(ReproduceCommand, RefusesWhatMakesNoSense) {
  const ::pipescout::testing::TemporaryFolder folder;
  const auto no_seeds = run_program(REPRODUCE_COMMAND, {"in-pipe", "--seeds", "0"}, folder.path());
  EXPECT_EQ(no_seeds.code(), 2);
  EXPECT_THAT(no_seeds.err, HasSubstr("--seeds"));

  const auto no_base =
      run_program(REPRODUCE_COMMAND, {"in-pipe", "--seed-base", "0"}, folder.path());
  EXPECT_EQ(no_base.code(), 2);
  EXPECT_THAT(no_base.err, HasSubstr("--seed-base"));

  const auto paper = run_program(REPRODUCE_COMMAND, {"odometry", "--seeds", "3"}, folder.path());
  EXPECT_EQ(paper.code(), 1);
  EXPECT_THAT(paper.err, HasSubstr("has no --seeds"));
  EXPECT_THAT(paper.out, IsEmpty());

  const auto whole = run_program(REPRODUCE_COMMAND, {"leaks", "--trials", "3"}, folder.path());
  EXPECT_EQ(whole.code(), 1);
  EXPECT_THAT(whole.err, HasSubstr("has no --part and no --trials"));

  const auto no_part = run_program(REPRODUCE_COMMAND, {"rack", "--part", "image"}, folder.path());
  EXPECT_EQ(no_part.code(), 1);
  EXPECT_THAT(no_part.err, HasSubstr("images"));
  EXPECT_THAT(no_part.out, IsEmpty());

  const auto misspelt = run_program(REPRODUCE_COMMAND, {"in-pip"}, folder.path());
  EXPECT_EQ(misspelt.code(), 1);
  EXPECT_THAT(misspelt.err, HasSubstr("in-pipe"));
}

TEST(ReproduceCommand, RefusesAFolderWithoutDataBeforeTheLongWork) {
  const ::pipescout::testing::TemporaryFolder folder;
  const auto finished =
      run_program(REPRODUCE_COMMAND, {"in-pipe", "--data", folder.path().string()}, folder.path());
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("ili_pipeline/2007.csv"));
  EXPECT_THAT(finished.out, IsEmpty());
}

}  // namespace
}  // namespace pipescout::reproduce
