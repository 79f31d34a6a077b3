// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_ledger/tally_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <pipescout/odometry/weld_ledger.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TallyFileTest : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    const auto path = folder_.path() / "tally.csv";
    std::ofstream(path, std::ios::trunc) << text;
    return path.string();
  }
  std::string refusal(const std::string& text) const {
    try {
      (void)read_tally(write(text));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  testing::TemporaryFolder folder_;
};

TEST_F(TallyFileTest, GivesJointsAndWhereTheyBegin) {
  const Tally tally =
      read_tally(write("id,joint_length_m,joint_length_sd_m\nA,12,0.01\nB,11.5,0.02\nC,,\n"));
  EXPECT_THAT(tally.ids, ElementsAre("A", "B", "C"));
  ASSERT_EQ(tally.joints.size(), 2U);
  EXPECT_EQ(tally.joints[0].length, 12.0);
  EXPECT_EQ(tally.joints[1].length, 11.5);
  EXPECT_EQ(tally.joints[1].standard_deviation, 0.02);
  EXPECT_THAT(tally.chainages, ElementsAre(0.0, 12.0, 23.5));
  EXPECT_NEAR(tally.variances[2], 1e-4 + 4e-4, 1e-12);
}

TEST_F(TallyFileTest, GivesBendsByTheWeldBeforeThem) {
  const Tally tally = read_tally(
      write("id,kind,angle_deg,chainage_m,chainage_sd_m\nB1,bend,30,-2,0.2\nA,weld,,0,0.01\n"
            "V,valve,,3,0.3\nB,weld,,12,0.01\nB2,bend,,15.5,0.3\nC,weld,,24,0.01\n"
            "B3,bend,90,25,0.1\n"));
  ASSERT_EQ(tally.bends.size(), 3U);
  EXPECT_EQ(tally.bends[0].joint, 0U);
  EXPECT_EQ(tally.bends[0].distance, -2.0);
  EXPECT_NEAR(tally.bends[0].angle, 0.5236, 1e-4);
  EXPECT_EQ(tally.bends[0].standard_deviation, 0.2);
  EXPECT_EQ(tally.bends[1].joint, 1U);
  EXPECT_EQ(tally.bends[1].distance, 3.5);
  EXPECT_GT(tally.bends[1].angle_standard_deviation, 1.5);
  EXPECT_EQ(tally.bends[2].joint, 1U);
  EXPECT_EQ(tally.bends[2].distance, 13.0);
  EXPECT_LT(tally.bends[2].angle_standard_deviation, 0.1);
}

TEST_F(TallyFileTest, NamesFileLineAndColumn) {
  EXPECT_THAT(refusal("id,joint_length_m\nA,12\nB,-3\nC,\n"),
              AllOf(HasSubstr("tally.csv:3: "), HasSubstr("joint_length_m")));
  EXPECT_THAT(refusal("id,joint_length_m\nA,12\nA,12\nC,\n"),
              AllOf(HasSubstr("tally.csv:3: "), HasSubstr("id")));
  EXPECT_THAT(refusal("id,joint_length_m\nA,\nB,12\nC,\n"),
              AllOf(HasSubstr("tally.csv:2: "), HasSubstr("joint_length_m")));
  EXPECT_THAT(refusal("id,joint_length_m\nA,nan\nB,12\nC,\n"), HasSubstr("tally.csv:2: "));
  EXPECT_THAT(refusal("name,length\nA,12\n"), AllOf(HasSubstr("tally.csv:1: "), HasSubstr("name")));
  EXPECT_NE(refusal("id,joint_length_m\nA,\n"), "");
  EXPECT_NE(refusal(""), "");
  EXPECT_THROW((void)read_tally("/no/such/tally.csv"), std::runtime_error);
}

TEST_F(TallyFileTest, ALearntTallyIsReadAgain) {
  const std::vector<odometry::LearntJoint> joints{
      {12.0, 0.1, 0}, {11.9, 0.01, 2}, {12.0, 0.1, 0}, {12.2, 0.02, 1}, {12.0, 0.1, 0}};
  const Tally tally = read_tally(write(format_learnt_tally(joints, 100.0)));
  EXPECT_THAT(tally.ids, ElementsAre("W1", "W2", "W3", "W4"));
  ASSERT_EQ(tally.joints.size(), 3U);
  EXPECT_NEAR(tally.joints[0].length, 11.9, 1e-9);
  EXPECT_NEAR(tally.joints[0].standard_deviation, 0.01, 1e-9);
  EXPECT_NEAR(tally.joints[2].length, 12.2, 1e-9);
  EXPECT_NEAR(tally.chainages[0], 112.0, 1e-9);
  EXPECT_EQ(format_learnt_tally(std::vector<odometry::LearntJoint>{{12.0, 0.1, 0}}, 0.0), "");
}

}  // namespace
}  // namespace pipescout
