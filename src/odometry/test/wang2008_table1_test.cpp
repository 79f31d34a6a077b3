// SPDX-License-Identifier: Apache-2.0
// Table 1 of the paper, recomputed from the installed data file.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/odometry/consensus_fusion.hpp"
#include "rival_rules.hpp"

namespace pipescout::odometry {
namespace {

constexpr std::array<double, 3> kSigmas = {0.06, 0.055, 0.056};  // Table 1, m
const std::vector<double> kOffsets = {0.18, 0.155, 0.165};       // section 4, m
constexpr double kPipeLength = 5.5;                              // section 4, m

struct Row {
  std::vector<OdometerReading> readings;
  double paper = 0.0;
};

std::vector<Row> load_table() {
  std::ifstream file(TABLE_1);
  std::string line;
  std::getline(file, line);
  if (line != "reading,odometer_1,odometer_2,odometer_3,paper") {
    throw std::runtime_error("unexpected header: " + line);
  }
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) {
      values.push_back(std::stod(cell));
    }
    if (values.size() != 5 || values[0] != static_cast<double>(rows.size() + 1)) {
      throw std::runtime_error("unexpected row: " + line);
    }
    Row row;
    for (std::size_t i = 0; i < 3; ++i) {
      row.readings.push_back({.distance = values[i + 1], .standard_deviation = kSigmas[i]});
    }
    row.paper = values[4];
    rows.push_back(row);
  }
  return rows;
}

ConsensusFusionResult fuse(const Row& row, Weighting weighting,
                           SupportRule rule = SupportRule::kMajority) {
  return ConsensusFusion({.weighting = weighting, .support_rule = rule, .offsets = kOffsets})
      .fuse(row.readings);
}

Row compensated(Row row) {
  for (std::size_t i = 0; i < row.readings.size(); ++i) {
    row.readings[i].distance += kOffsets[i];
  }
  return row;
}

class Table1 : public ::testing::Test {
 protected:
  const std::vector<Row> rows_ = load_table();
};

TEST_F(Table1, HasTenRows) {
  ASSERT_EQ(rows_.size(), 10U);
}

TEST_F(Table1, SupportSetsFollowFromEpsilon) {
  // Rightmost digit: odometer 1.
  const std::vector<OdometerSet> expected = {0b110, 0b111, 0b110, 0b101, 0b110,
                                             0b111, 0b111, 0b011, 0b110, 0b111};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    for (const auto rule : {SupportRule::kMajority, SupportRule::kMutualMajority}) {
      const auto result = fuse(rows_[i], Weighting::kMaximumLikelihood, rule);
      EXPECT_EQ(result.fusion_set, expected[i]) << "row " << i + 1;
      EXPECT_EQ(result.status, FusionStatus::kOk);
      for (std::size_t j = 0; j < 3; ++j) {
        EXPECT_EQ(result.rejections[j],
                  expected[i][j] ? RejectionReason::kNone : RejectionReason::kUnsupported);
      }
    }
  }
}

TEST_F(Table1, Equation13GivesTheExpectedValues) {
  const std::vector<double> expected = {5.5099, 5.4623, 5.5148, 5.5219, 5.5049,
                                        5.5157, 5.5320, 5.5117, 5.4749, 5.5392};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    EXPECT_NEAR(fuse(rows_[i], Weighting::kPaperEquation13).fused.distance, expected[i], 5e-5)
        << "row " << i + 1;
  }
}

TEST_F(Table1, MaximumLikelihoodGivesTheExpectedValues) {
  const std::vector<double> expected = {5.5097, 5.4612, 5.5146, 5.5213, 5.5048,
                                        5.5148, 5.5308, 5.5110, 5.4748, 5.5384};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    EXPECT_NEAR(fuse(rows_[i], Weighting::kMaximumLikelihood).fused.distance, expected[i], 5e-5)
        << "row " << i + 1;
  }
}

TEST_F(Table1, StandardDeviationsAreTheExpectedOnes) {
  const std::vector<double> expected = {0.039, 0.033, 0.039, 0.041, 0.039,
                                        0.033, 0.033, 0.041, 0.039, 0.033};
  for (const auto weighting : {Weighting::kMaximumLikelihood, Weighting::kPaperEquation13}) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      EXPECT_NEAR(fuse(rows_[i], weighting).fused.standard_deviation, expected[i], 5e-4)
          << "row " << i + 1;
    }
  }
}

TEST_F(Table1, RowsOneToNineAgreeWithThePaper) {
  const auto largest_error = [this](Weighting weighting) {
    double largest = 0.0;
    for (std::size_t i = 0; i < 9; ++i) {
      largest =
          std::max(largest, std::abs(fuse(rows_[i], weighting).fused.distance - rows_[i].paper));
    }
    return largest;
  };
  EXPECT_NEAR(largest_error(Weighting::kMaximumLikelihood), 0.0052, 5e-5);
  EXPECT_NEAR(largest_error(Weighting::kPaperEquation13), 0.0057, 5e-5);
}

TEST_F(Table1, CannotTellTheMeaningsOfSupportByAGroupApart) {
  for (const Row& row : rows_) {
    const auto result = fuse(row, Weighting::kMaximumLikelihood);
    EXPECT_EQ(test::largest_mutual_group(result.confidence_distance, result.relation),
              result.fusion_set);
    EXPECT_EQ(test::largest_connected_group(result.relation), result.fusion_set);
  }
}

TEST_F(Table1, RowTenIsThePapersFigureOnlyWithoutOdometerOne) {
  const Row& row = rows_[9];
  const auto result = fuse(row, Weighting::kPaperEquation13);
  EXPECT_LT(result.confidence_distance.maxCoeff(), 0.42);  // far below epsilon = 0.75
  for (const auto weighting : {Weighting::kMaximumLikelihood, Weighting::kPaperEquation13}) {
    EXPECT_GT(fuse(row, weighting).fused.distance - row.paper, 0.018);
    const double two_and_three = fuse_members(row.readings, kOffsets, 0b110, weighting).distance;
    const bool likely = weighting == Weighting::kMaximumLikelihood;
    EXPECT_NEAR(two_and_three, likely ? 5.5248 : 5.5249, 5e-5);
    EXPECT_EQ(std::round(100.0 * two_and_three), std::round(100.0 * row.paper));
  }
}

TEST_F(Table1, MatricesOfRowTwoAreThePrintedOnes) {
  const auto result = fuse(rows_[1], Weighting::kPaperEquation13);
  Eigen::Matrix3d printed;
  printed << 0.00, 0.60, 0.26, 0.64, 0.00, 0.41, 0.28, 0.41, 0.00;
  EXPECT_LE((result.confidence_distance - printed).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_TRUE((result.relation.array() == 1).all());
}

TEST_F(Table1, RelationOfRowNineIsThePrintedOne) {
  const auto result = fuse(rows_[8], Weighting::kPaperEquation13);
  Eigen::Matrix<std::uint8_t, 3, 3> printed;
  printed << 1, 0, 0, 0, 1, 1, 0, 1, 1;
  EXPECT_TRUE(result.relation == printed);
}

TEST_F(Table1, MatrixDOfRowNineIsPrintedWrong) {
  // Neither from the raw readings nor from the compensated ones.
  EXPECT_GT(std::abs(confidence_distance_matrix(rows_[8].readings)(1, 2) - 0.41), 0.1);
  EXPECT_GT(std::abs(confidence_distance_matrix(compensated(rows_[8]).readings)(1, 2) - 0.41), 0.1);
  EXPECT_NEAR(confidence_distance_matrix(rows_[1].readings)(2, 1), 0.41, 0.005);  // that of row 2
}

TEST_F(Table1, CompensatedReadingsWouldContradictTheRelationOfRowTwo) {
  const auto readings = compensated(rows_[1]).readings;
  const auto relation = relation_matrix(confidence_distance_matrix(readings), 0.75);
  EXPECT_EQ(relation(0, 1), 0);
  EXPECT_EQ(relation(1, 0), 0);
  EXPECT_EQ(relation.cast<int>().sum(), 7);
}

TEST_F(Table1, PositioningErrorIsBelowOnePercent) {
  for (const Row& row : rows_) {
    for (const auto weighting : {Weighting::kMaximumLikelihood, Weighting::kPaperEquation13}) {
      EXPECT_LT(std::abs(fuse(row, weighting).fused.distance - kPipeLength), 0.01 * kPipeLength);
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
