// SPDX-License-Identifier: Apache-2.0
#include "reproduce/reproduce.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace pipescout::host {
namespace {

TEST(Reproduce, OdometryGivesThePapersTable) {
  std::ostringstream out;
  const auto result = reproduce_odometry(out);
  const std::vector<std::vector<int>> supports{{2, 3},    {1, 2, 3}, {2, 3}, {1, 3}, {2, 3},
                                               {1, 2, 3}, {1, 2, 3}, {1, 2}, {2, 3}, {1, 2, 3}};
  const std::vector<double> equation_13{5.5099, 5.4623, 5.5148, 5.5219, 5.5049,
                                        5.5157, 5.5320, 5.5117, 5.4749, 5.5392};
  ASSERT_EQ(result.rows.size(), 10U);
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const auto& row = result.rows[i];
    EXPECT_EQ(row["readings"].size(), 3U);
    EXPECT_EQ(row["support"].get<std::vector<int>>(), supports[i]) << i;
    EXPECT_NEAR(row["fused_paper"].get<double>(), equation_13[i], 5e-5) << i;
    EXPECT_TRUE(row["fused_ml"].is_number());
    EXPECT_TRUE(row["paper"].is_number());
  }
  EXPECT_LE(result.figures["rows_1_to_9_max_abs_error_m"].get<double>(), 0.006);
  EXPECT_NEAR(result.figures["row_10_error_m"].get<double>(), 0.0184, 1e-4);
  EXPECT_TRUE(result.seeds.is_array());
  EXPECT_TRUE(result.seeds.empty());
  EXPECT_THAT(out.str(), ::testing::HasSubstr("does not follow from the method"));
}

TEST(Reproduce, ListsItsTables) {
  ASSERT_EQ(reproducible_tables().size(), 1U);
  EXPECT_EQ(reproducible_tables().front().name, "odometry");
}

}  // namespace
}  // namespace pipescout::host
