// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/consensus_fusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::odometry {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSigma = 0.05;
// With epsilon = 0.75 a sigma of 0.05 supports readings up to 0.0575 m away.
constexpr double kNear = 0.05;

std::vector<OdometerReading> readings_at(const std::vector<double>& distances,
                                         double sigma = kSigma) {
  std::vector<OdometerReading> readings;
  for (const double distance : distances) {
    readings.push_back({.distance = distance, .standard_deviation = sigma});
  }
  return readings;
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no std::invalid_argument";
}

OdometerSet members_of(const std::vector<OdometerReading>& readings,
                       SupportRule rule = SupportRule::kMajority) {
  return ConsensusFusion({.support_rule = rule}).fuse(readings).fusion_set;
}

TEST(ConfidenceDistance, IsTwiceTheAreaUnderTheDensityBetweenTheReadings) {
  // Equations (1) and (3): Simpson's rule over [x_i, x_j].
  const double x_i = 5.32;
  const double x_j = 5.27;
  const double sigma = 0.06;
  constexpr int kSteps = 1000;
  const double step = (x_j - x_i) / kSteps;
  double area = 0.0;
  for (int n = 0; n <= kSteps; ++n) {
    const double u = (n * step) / sigma;
    const double density = std::exp(-0.5 * u * u) / (std::sqrt(2.0 * M_PI) * sigma);
    area += density * (n == 0 || n == kSteps ? 1.0 : n % 2 == 1 ? 4.0 : 2.0);
  }
  area *= std::abs(step) / 3.0;
  EXPECT_NEAR(confidence_distance(x_i, x_j, sigma), 2.0 * area, 1e-12);
}

TEST(ConfidenceDistance, UsesTheSigmaOfTheFirstOdometer) {
  const std::vector<OdometerReading> readings = {{.distance = 1.0, .standard_deviation = 0.1},
                                                 {.distance = 1.1, .standard_deviation = 0.2}};
  const auto distances = confidence_distance_matrix(readings);
  EXPECT_NEAR(distances(0, 1), 0.6826894921, 1e-9);  // one sigma
  EXPECT_NEAR(distances(1, 0), 0.3829249225, 1e-9);  // half a sigma
  EXPECT_EQ(distances(0, 0), 0.0);
}

TEST(ConfidenceDistance, StaysInRangeAtTheLimitsOfDouble) {
  constexpr double kMax = std::numeric_limits<double>::max();
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(confidence_distance(kMax, -kMax, 1.0), 1.0);
  EXPECT_EQ(confidence_distance(1.0, 2.0, kTiny), 1.0);
  EXPECT_EQ(confidence_distance(1.0, 1.0, kTiny), 0.0);
  EXPECT_NEAR(confidence_distance(0.0, kMax, kMax), 0.6826894921, 1e-9);
}

TEST(ConfidenceDistanceMatrix, UnusableReadingIsAsFarAsCanBe) {
  auto readings = readings_at({1.0, kNaN, 1.0});
  const auto distances = confidence_distance_matrix(readings);
  Eigen::Matrix3d expected;
  expected << 0, 1, 0, 1, 1, 1, 0, 1, 0;
  EXPECT_TRUE(distances == expected);
}

TEST(ConfidenceDistanceMatrix, IsStoredRowMajorWithoutGaps) {
  const auto distances = confidence_distance_matrix(readings_at({0.0, 0.05, 0.2}));
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      EXPECT_EQ(distances.data()[3 * i + j], distances(i, j));
    }
  }
}

TEST(RelationMatrix, BoundIsInclusive) {
  ConfidenceDistanceMatrix distances = ConfidenceDistanceMatrix::Zero(2, 2);
  distances(0, 1) = 0.75;
  distances(1, 0) = std::nextafter(0.75, 1.0);
  const auto relation = relation_matrix(distances, 0.75);
  EXPECT_EQ(relation(0, 1), 1);
  EXPECT_EQ(relation(1, 0), 0);
}

TEST(FusionSet, TwoThatAgree) {
  EXPECT_EQ(members_of(readings_at({1.0, 1.0 + kNear})), 0b11U);
}

TEST(FusionSet, TwoThatDisagreeHaveNoConsensusAndNoValue) {
  const auto result = ConsensusFusion({}).fuse(readings_at({1.0, 2.0}));
  EXPECT_EQ(result.status, FusionStatus::kNoConsensus);
  EXPECT_TRUE(std::isnan(result.fused.distance));
  EXPECT_TRUE(std::isnan(result.fused.standard_deviation));
  EXPECT_TRUE(result.fusion_set.none());
  EXPECT_EQ(result.rejections[0], RejectionReason::kUnsupported);
  EXPECT_EQ(result.rejections[1], RejectionReason::kUnsupported);
  EXPECT_EQ(result.relation.rows(), 2);
}

TEST(FusionSet, WeakSupportCountsForTheOneThatGetsIt) {
  // The coarse odometer cannot contradict the precise one; the precise one contradicts it.
  const std::vector<OdometerReading> readings = {{.distance = 1.0, .standard_deviation = 0.01},
                                                 {.distance = 1.1, .standard_deviation = 0.2}};
  const auto result = ConsensusFusion({}).fuse(readings);
  EXPECT_EQ(result.relation(1, 0), 1);
  EXPECT_EQ(result.relation(0, 1), 0);
  EXPECT_EQ(result.fusion_set, 0b01U);
  EXPECT_EQ(result.fused.distance, 1.0);
  EXPECT_DOUBLE_EQ(result.fused.standard_deviation, 0.01);
  EXPECT_TRUE(members_of(readings, SupportRule::kMutualMajority).none());
}

TEST(FusionSet, ChainOfThreeIsKeptWhole) {
  // Each end has itself and the middle: two of three.
  EXPECT_EQ(members_of(readings_at({0.0, kNear, 2 * kNear})), 0b111U);
}

TEST(FusionSet, ChainOfFourKeepsItsMiddle) {
  EXPECT_EQ(members_of(readings_at({0.0, kNear, 2 * kNear, 3 * kNear})), 0b0110U);
}

TEST(FusionSet, SupportIsNotPassedAlongALongChain) {
  std::vector<double> distances;
  for (int n = 0; n < 16; ++n) {
    distances.push_back(n * kNear);
  }
  EXPECT_TRUE(members_of(readings_at(distances)).none());
}

TEST(FusionSet, SplitInEqualHalvesHasNoConsensus) {
  EXPECT_TRUE(members_of(readings_at({1.0, 1.0, 2.0, 2.0})).none());
  EXPECT_TRUE(members_of(readings_at({1.0, 1.0, 1.0, 2.0, 2.0, 2.0})).none());
}

TEST(FusionSet, MinorityThatAgreesWithItselfIsLeftOut) {
  EXPECT_EQ(members_of(readings_at({1.0, 1.0, 1.0, 2.0, 2.0})), 0b00111U);
  EXPECT_EQ(members_of(readings_at({2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 1.0})), 0b1111000U);
}

TEST(FusionSet, PairAmongScatteredReadingsIsNoGroup) {
  EXPECT_TRUE(members_of(readings_at({1.0, 1.0, 2.0, 3.0, 4.0})).none());
}

TEST(FusionSet, SingleUsableReadingIsSupportedByNobody) {
  auto readings = readings_at({1.0, kNaN, 1.0});
  readings[2].valid = false;
  const auto result = ConsensusFusion({}).fuse(readings);
  EXPECT_EQ(result.status, FusionStatus::kNoConsensus);
  EXPECT_EQ(result.rejections[0], RejectionReason::kUnsupported);
}

TEST(FusionSet, MajorityIsThatOfTheUsableReadings) {
  EXPECT_EQ(members_of(readings_at({1.0, 1.0, kNaN, kNaN, kNaN})), 0b00011U);
}

TEST(FusionSet, NothingUsableIsNoConsensus) {
  const auto result = ConsensusFusion({}).fuse(std::vector<OdometerReading>(3));
  EXPECT_EQ(result.status, FusionStatus::kNoConsensus);
  EXPECT_EQ(result.rejections[0], RejectionReason::kNotANumber);
}

TEST(FusionSet, OdometerThatDoesNotSupportItselfIsNotCounted) {
  RelationMatrix relation = RelationMatrix::Ones(3, 3);
  relation(2, 2) = 0;
  EXPECT_EQ(fusion_set(relation, SupportRule::kMajority), 0b011U);

  RelationMatrix alone = RelationMatrix::Identity(4, 4);
  alone(3, 3) = 0;
  alone(3, 0) = 1;  // the support of one that is not usable
  EXPECT_TRUE(fusion_set(alone, SupportRule::kMajority).none());
}

TEST(Rejections, NameTheFirstReasonThatApplies) {
  auto readings = readings_at({1.0, 1.0, 1.0, kNaN, kInfinity, 1.0, 1.0, 1.0, 1.0, 3.0});
  readings[5].standard_deviation = 0.0;
  readings[6].standard_deviation = -kSigma;
  readings[7].standard_deviation = kNaN;
  readings[8].standard_deviation = kInfinity;
  readings.push_back({.distance = kNaN, .standard_deviation = kNaN, .valid = false});
  readings.push_back({.distance = kNaN, .standard_deviation = kNaN});
  const auto result = ConsensusFusion({}).fuse(readings);
  using enum RejectionReason;
  const std::array<RejectionReason, kMaxOdometers> expected = {
      kNone,     kNone,     kNone,     kNotANumber,  kNotANumber,    kBadSigma,
      kBadSigma, kBadSigma, kBadSigma, kUnsupported, kMarkedInvalid, kNotANumber};
  EXPECT_EQ(result.rejections, expected);
  EXPECT_EQ(result.fusion_set, 0b111U);
}

TEST(Rejections, ReadingThatOverflowsWithItsOffsetIsNotANumber) {
  constexpr double kMax = std::numeric_limits<double>::max();
  const auto result =
      ConsensusFusion({.offsets = {0.0, 0.0, kMax}}).fuse(readings_at({1.0, 1.0, kMax}));
  EXPECT_EQ(result.rejections[2], RejectionReason::kNotANumber);
  EXPECT_EQ(result.confidence_distance(2, 2), 1.0);
  EXPECT_EQ(result.fused.distance, 1.0);
}

TEST(FuseMembers, WeighsByTheInverseVarianceOrByEquation13) {
  const std::vector<OdometerReading> readings = {{.distance = 1.0, .standard_deviation = 0.1},
                                                 {.distance = 2.0, .standard_deviation = 0.2}};
  const auto likely = fuse_members(readings, {}, 0b11, Weighting::kMaximumLikelihood);
  EXPECT_NEAR(likely.distance, 1.2, 1e-12);  // weights 4 : 1
  EXPECT_NEAR(likely.standard_deviation, std::sqrt(1.0 / 125.0), 1e-12);
  const auto paper = fuse_members(readings, {}, 0b11, Weighting::kPaperEquation13);
  EXPECT_NEAR(paper.distance, 4.0 / 3.0, 1e-12);  // weights 2 : 1
  EXPECT_NEAR(paper.standard_deviation, std::sqrt(2.0) / 15.0, 1e-12);
}

TEST(FuseMembers, AddsTheOffsets) {
  const std::vector<double> offsets = {0.5, 1.5, 100.0};
  const auto fused =
      fuse_members(readings_at({1.0, 1.0, 1.0}), offsets, 0b011, Weighting::kMaximumLikelihood);
  EXPECT_DOUBLE_EQ(fused.distance, 2.0);
}

TEST(FuseMembers, EqualReadingsFuseToThemselvesToTheLastBit) {
  for (std::size_t m = kMinOdometers; m <= kMaxOdometers; ++m) {
    for (int n = 1; n <= 20; ++n) {
      auto readings = readings_at(std::vector<double>(m, 0.1 * n));
      for (std::size_t i = 0; i < m; ++i) {
        readings[i].standard_deviation = 0.01 * static_cast<double>(i + 3);
      }
      const auto all = OdometerSet((1UL << m) - 1);
      EXPECT_EQ(fuse_members(readings, {}, all, Weighting::kMaximumLikelihood).distance, 0.1 * n);
    }
  }
}

TEST(FuseMembers, SurvivesSigmasWhoseSquareOverflows) {
  for (const double sigma : {1e-300, 1e300}) {
    for (const auto weighting : {Weighting::kMaximumLikelihood, Weighting::kPaperEquation13}) {
      const auto fused = fuse_members(readings_at({1.0, 1.0}, sigma), {}, 0b11, weighting);
      EXPECT_EQ(fused.distance, 1.0);
      EXPECT_NEAR(fused.standard_deviation / sigma, std::sqrt(0.5), 1e-12);
    }
  }
}

TEST(FuseMembers, RefusesWhatItCannotFuse) {
  const auto readings = readings_at({1.0, kNaN, 1.0});
  const auto fuse = [&](OdometerSet members, std::vector<double> offsets = {}) {
    return message_of([&] {
      static_cast<void>(fuse_members(readings, offsets, members, Weighting::kMaximumLikelihood));
    });
  };
  EXPECT_EQ(fuse(0b000), "members: 0 odometers are outside [1, 3]");
  EXPECT_EQ(fuse(0b1001), "members: odometer 3 is outside [0, 2]");
  EXPECT_EQ(fuse(0b011), "members: odometer 1 is not usable (not a number)");
  EXPECT_EQ(fuse(0b101, {0.0}), "offsets: 1 values for 3 odometers, must be as many or none");
}

TEST(Parameters, DefaultsAreThoseOfThePaperAndValid) {
  const ConsensusFusionParameters parameters;
  EXPECT_EQ(parameters.epsilon, 0.75);
  EXPECT_EQ(parameters.weighting, Weighting::kMaximumLikelihood);
  EXPECT_EQ(parameters.support_rule, SupportRule::kMajority);
  EXPECT_TRUE(parameters.offsets.empty());
  EXPECT_NO_THROW(parameters.validate());
}

TEST(Parameters, WrongOnesAreRefusedByFieldValueAndRange) {
  const auto refusal = [](const ConsensusFusionParameters& parameters) {
    return message_of([&] { static_cast<void>(ConsensusFusion(parameters)); });
  };
  EXPECT_EQ(refusal({.epsilon = 0.0}), "epsilon: 0 is outside (0, 1)");
  EXPECT_EQ(refusal({.epsilon = 1.0}), "epsilon: 1 is outside (0, 1)");
  EXPECT_EQ(refusal({.epsilon = -0.5}), "epsilon: -0.5 is outside (0, 1)");
  EXPECT_THAT(refusal({.epsilon = kNaN}), AllOf(HasSubstr("epsilon"), HasSubstr("nan")));
  EXPECT_EQ(refusal({.weighting = static_cast<Weighting>(2)}), "weighting: 2 is outside {0, 1}");
  EXPECT_EQ(refusal({.support_rule = static_cast<SupportRule>(9)}),
            "support_rule: 9 is outside {0, 1}");
  EXPECT_EQ(refusal({.offsets = {0.1}}), "offsets: 1 odometers are outside [2, 16]");
  EXPECT_EQ(refusal({.offsets = std::vector<double>(17)}),
            "offsets: 17 odometers are outside [2, 16]");
  EXPECT_EQ(refusal({.offsets = {0.1, kInfinity}}), "offsets[1]: inf is outside (-inf, inf)");
}

TEST(Sizes, WrongOnesAreRefusedByFieldValueAndRange) {
  const auto fuse = [](std::size_t m, std::vector<double> offsets = {}) {
    return message_of([&] {
      const ConsensusFusion fusion({.offsets = std::move(offsets)});
      static_cast<void>(fusion.fuse(std::vector<OdometerReading>(m)));
    });
  };
  EXPECT_EQ(fuse(0), "readings: 0 odometers are outside [2, 16]");
  EXPECT_EQ(fuse(1), "readings: 1 odometers are outside [2, 16]");
  EXPECT_EQ(fuse(17), "readings: 17 odometers are outside [2, 16]");
  EXPECT_EQ(fuse(3, {0.1, 0.2}), "offsets: 2 values for 3 odometers, must be as many or none");
}

TEST(Sizes, MatricesMustBeSquareAndOfTheRightSize) {
  EXPECT_THROW(static_cast<void>(confidence_distance_matrix({})), std::invalid_argument);
  EXPECT_EQ(message_of([] {
              static_cast<void>(relation_matrix(ConfidenceDistanceMatrix::Zero(2, 3), 0.75));
            }),
            "confidence_distance: 2 x 3 is not square");
  EXPECT_EQ(message_of([] {
              static_cast<void>(relation_matrix(ConfidenceDistanceMatrix::Zero(2, 2), 1.5));
            }),
            "epsilon: 1.5 is outside (0, 1)");
  EXPECT_EQ(message_of([] {
              static_cast<void>(fusion_set(RelationMatrix::Ones(1, 1), SupportRule::kMajority));
            }),
            "relation: 1 odometers are outside [2, 16]");
  EXPECT_EQ(
      message_of([] {
        static_cast<void>(fusion_set(RelationMatrix::Ones(2, 2), static_cast<SupportRule>(7)));
      }),
      "rule: 7 is outside {0, 1}");
}

TEST(ToString, NamesEveryValue) {
  EXPECT_STREQ(to_string(RejectionReason::kNone), "none");
  EXPECT_STREQ(to_string(RejectionReason::kUnsupported), "unsupported");
  EXPECT_STREQ(to_string(RejectionReason::kMarkedInvalid), "marked invalid");
  EXPECT_STREQ(to_string(RejectionReason::kNotANumber), "not a number");
  EXPECT_STREQ(to_string(RejectionReason::kBadSigma), "bad sigma");
  EXPECT_STREQ(to_string(static_cast<RejectionReason>(99)), "unknown");
  EXPECT_STREQ(to_string(FusionStatus::kOk), "ok");
  EXPECT_STREQ(to_string(FusionStatus::kNoConsensus), "no consensus");
  EXPECT_STREQ(to_string(static_cast<FusionStatus>(99)), "unknown");
}

}  // namespace
}  // namespace pipescout::odometry
