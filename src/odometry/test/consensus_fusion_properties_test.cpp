// SPDX-License-Identifier: Apache-2.0
// Properties for m = 2..16. Distances and sigmas are multiples of 2^-10 m, so that translations by
// such multiples and scalings by powers of two are exact, and results can be compared bit by bit.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>
#include <vector>

#include "pipescout/odometry/consensus_fusion.hpp"

namespace pipescout::odometry {
namespace {

constexpr double kGrid = 1.0 / 1024.0;                  // m
constexpr double kSupportedSigmas = 1.150349380376008;  // erf(z / sqrt(2)) = 0.75
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Readings = std::vector<OdometerReading>;

/// From [from, to). At full size always: rapidcheck's small first cases would be readings that all
/// agree.
template <typename Integer>
Integer draw(Integer from, Integer to) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<Integer>(from, to));
}

std::size_t draw_count() {
  return draw(kMinOdometers, kMaxOdometers + 1);
}

/// Close enough together that groups form, with sigmas from 0.01 to 0.1 m.
OdometerReading draw_reading() {
  return {.distance = draw(5000, 5200) * kGrid, .standard_deviation = draw(10, 100) * kGrid};
}

Readings draw_readings() {
  Readings readings(draw_count());
  std::generate(readings.begin(), readings.end(), draw_reading);
  return readings;
}

OdometerReading draw_unusable() {
  OdometerReading reading = draw_reading();
  switch (draw(0, 6)) {
    case 0:
      reading.valid = false;
      break;
    case 1:
      reading.distance = kNaN;
      break;
    case 2:
      reading.distance = *rc::gen::element(kInfinity, -kInfinity);
      break;
    case 3:
      reading.standard_deviation = kNaN;
      break;
    case 4:
      reading.standard_deviation = -reading.standard_deviation;
      break;
    default:
      reading.standard_deviation = *rc::gen::element(0.0, -0.0, kInfinity);
  }
  return reading;
}

/// About a quarter of them unusable.
Readings draw_mixed() {
  Readings readings = draw_readings();
  for (auto& reading : readings) {
    if (draw(0, 4) == 3) {
      reading = draw_unusable();
    }
  }
  return readings;
}

ConsensusFusionParameters draw_parameters(std::size_t m) {
  ConsensusFusionParameters parameters;
  parameters.epsilon = draw(1, 100) * 0.01;
  parameters.weighting =
      *rc::gen::element(Weighting::kMaximumLikelihood, Weighting::kPaperEquation13);
  parameters.support_rule = *rc::gen::element(SupportRule::kMajority, SupportRule::kMutualMajority);
  if (draw(0, 2) == 1) {
    for (std::size_t i = 0; i < m; ++i) {
      parameters.offsets.push_back(draw(-100, 100) * kGrid);
    }
  }
  return parameters;
}

double offset_of(const ConsensusFusionParameters& parameters, std::size_t i) {
  return parameters.offsets.empty() ? 0.0 : parameters.offsets[i];
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same_bits(const FusedDistance& a, const FusedDistance& b) {
  return same_bits(a.distance, b.distance) && same_bits(a.standard_deviation, b.standard_deviation);
}

bool close(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 1e-12 * (1.0 + std::abs(a));
}

RC_GTEST_PROP(ConfidenceDistanceProperty, IsInTheUnitIntervalWithZeroDiagonal, ()) {
  const Readings readings = draw_readings();
  const auto distances = confidence_distance_matrix(readings);
  RC_ASSERT(static_cast<std::size_t>(distances.rows()) == readings.size());
  RC_ASSERT((distances.array() >= 0.0).all());
  RC_ASSERT((distances.array() <= 1.0).all());
  RC_ASSERT((distances.diagonal().array() == 0.0).all());
}

RC_GTEST_PROP(ConfidenceDistanceProperty, IsSymmetricWhenSigmasAreEqual, ()) {
  Readings readings = draw_readings();
  for (auto& reading : readings) {
    reading.standard_deviation = readings.front().standard_deviation;
  }
  const auto distances = confidence_distance_matrix(readings);
  RC_ASSERT(distances == distances.transpose());
}

RC_GTEST_PROP(ConfidenceDistanceProperty, GrowsWithTheGapAndShrinksWithSigma, ()) {
  const double x = draw_reading().distance;
  const double gap = draw(0, 500) * kGrid;
  const double wider = gap + draw(0, 500) * kGrid;
  const double sigma = draw(1, 200) * kGrid;
  const double coarser = sigma + draw(0, 200) * kGrid;
  const double distance = confidence_distance(x, x + gap, sigma);
  RC_ASSERT(distance <= confidence_distance(x, x + wider, sigma));
  RC_ASSERT(distance >= confidence_distance(x, x + gap, coarser));
  RC_ASSERT(same_bits(distance, confidence_distance(x, x - gap, sigma)));
}

RC_GTEST_PROP(RelationProperty, GrowsWithEpsilonAndSoDoesTheFusionSet, ()) {
  const auto distances = confidence_distance_matrix(draw_mixed());
  const int strict = draw(1, 100);
  const int loose = draw(strict, 100);
  const auto strict_relation = relation_matrix(distances, strict * 0.01);
  const auto loose_relation = relation_matrix(distances, loose * 0.01);
  RC_ASSERT((strict_relation.array() <= loose_relation.array()).all());
  for (const auto rule : {SupportRule::kMajority, SupportRule::kMutualMajority}) {
    const auto strict_set = fusion_set(strict_relation, rule);
    RC_ASSERT((strict_set & fusion_set(loose_relation, rule)) == strict_set);
  }
}

RC_GTEST_PROP(FusionSetProperty, MutualMajorityIsPartOfTheMajority, ()) {
  const auto distances = confidence_distance_matrix(draw_mixed());
  const auto relation = relation_matrix(distances, draw(1, 100) * 0.01);
  const auto mutual = fusion_set(relation, SupportRule::kMutualMajority);
  RC_ASSERT((mutual & fusion_set(relation, SupportRule::kMajority)) == mutual);
}

RC_GTEST_PROP(FusionSetProperty, RulesAreOneWhenSigmasAreEqual, ()) {
  Readings readings = draw_readings();
  for (auto& reading : readings) {
    reading.standard_deviation = readings.front().standard_deviation;
  }
  const auto relation = relation_matrix(confidence_distance_matrix(readings), 0.75);
  RC_ASSERT(fusion_set(relation, SupportRule::kMutualMajority) ==
            fusion_set(relation, SupportRule::kMajority));
}

RC_GTEST_PROP(FusionSetProperty, FaultyMinorityCannotMoveTheFusionPastWhatTheOthersSupport, ()) {
  // The breakdown point: fewer than half of the readings are anything at all.
  Readings readings = draw_readings();
  const std::size_t m = readings.size();
  const std::size_t faulty = draw(std::size_t{0}, (m - 1) / 2 + 1);
  for (std::size_t i = 0; i < faulty; ++i) {
    readings[i].distance = draw(0, 10000) * kGrid;
    readings[i].standard_deviation = draw(1, 5000) * kGrid;
  }
  double lowest = kInfinity;
  double highest = -kInfinity;
  for (std::size_t i = faulty; i < m; ++i) {
    const double reach = kSupportedSigmas * readings[i].standard_deviation;
    lowest = std::min(lowest, readings[i].distance - reach);
    highest = std::max(highest, readings[i].distance + reach);
  }
  for (const auto rule : {SupportRule::kMajority, SupportRule::kMutualMajority}) {
    const auto result = ConsensusFusion({.support_rule = rule}).fuse(readings);
    for (std::size_t j = 0; j < m; ++j) {
      if (!result.fusion_set[j]) {
        continue;
      }
      bool supported_by_honest = false;
      for (std::size_t i = faulty; i < m; ++i) {
        supported_by_honest |=
            result.relation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) == 1;
      }
      RC_ASSERT(supported_by_honest);
    }
    if (result.status == FusionStatus::kOk) {
      RC_ASSERT(result.fused.distance >= lowest - 1e-9);
      RC_ASSERT(result.fused.distance <= highest + 1e-9);
    }
  }
}

RC_GTEST_PROP(FusionProperty, FusedIsInsideTheFusionSetAndNoWorseThanItsBestMember, ()) {
  const Readings readings = draw_mixed();
  const auto parameters = draw_parameters(readings.size());
  const auto result = ConsensusFusion(parameters).fuse(readings);
  RC_CLASSIFY(result.status == FusionStatus::kOk, "consensus");
  RC_ASSERT((result.status == FusionStatus::kOk) == result.fusion_set.any());
  if (result.status == FusionStatus::kNoConsensus) {
    RC_ASSERT(std::isnan(result.fused.distance));
    RC_ASSERT(std::isnan(result.fused.standard_deviation));
    return;
  }
  double lowest = kInfinity;
  double highest = -kInfinity;
  double best_sigma = kInfinity;
  double worst_sigma = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (result.fusion_set[i]) {
      const double distance = readings[i].distance + offset_of(parameters, i);
      lowest = std::min(lowest, distance);
      highest = std::max(highest, distance);
      best_sigma = std::min(best_sigma, readings[i].standard_deviation);
      worst_sigma = std::max(worst_sigma, readings[i].standard_deviation);
    }
  }
  RC_ASSERT(result.fused.distance >= lowest);
  RC_ASSERT(result.fused.distance <= highest);
  const bool likely = parameters.weighting == Weighting::kMaximumLikelihood;
  RC_ASSERT(result.fused.standard_deviation <= (likely ? best_sigma : worst_sigma) * (1.0 + 1e-12));
}

RC_GTEST_PROP(FusionProperty, AgreesWithThePlainFormula, ()) {
  const Readings readings = draw_readings();
  const auto parameters = draw_parameters(readings.size());
  const auto members = OdometerSet(draw(1UL, 1UL << readings.size()));
  const auto fused = fuse_members(readings, parameters.offsets, members, parameters.weighting);
  long double weighted = 0.0L;
  long double variance = 0.0L;
  long double sum = 0.0L;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (members[i]) {
      const long double sigma = readings[i].standard_deviation;
      const long double weight = parameters.weighting == Weighting::kMaximumLikelihood
                                     ? 1.0L / (sigma * sigma)
                                     : 1.0L / sigma;
      weighted += weight * (readings[i].distance + offset_of(parameters, i));
      variance += weight * weight * sigma * sigma;
      sum += weight;
    }
  }
  RC_ASSERT(close(fused.distance, static_cast<double>(weighted / sum)));
  RC_ASSERT(close(fused.standard_deviation, static_cast<double>(std::sqrt(variance) / sum)));
}

RC_GTEST_PROP(FusionProperty, MaximumLikelihoodIsTheMoreCertain, ()) {
  const Readings readings = draw_readings();
  const auto all = OdometerSet((1UL << readings.size()) - 1);
  const auto likely = fuse_members(readings, {}, all, Weighting::kMaximumLikelihood);
  const auto paper = fuse_members(readings, {}, all, Weighting::kPaperEquation13);
  RC_ASSERT(likely.standard_deviation <= paper.standard_deviation * (1.0 + 1e-12));
}

RC_GTEST_PROP(FusionProperty, FollowsAPermutationOfTheOdometers, ()) {
  const Readings readings = draw_mixed();
  const std::size_t m = readings.size();
  const auto parameters = draw_parameters(m);
  std::vector<std::size_t> order(m);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = m - 1; i > 0; --i) {
    std::swap(order[i], order[draw(std::size_t{0}, i + 1)]);
  }
  Readings shuffled;
  auto shuffled_parameters = parameters;
  shuffled_parameters.offsets.clear();
  for (const std::size_t from : order) {
    shuffled.push_back(readings[from]);
    if (!parameters.offsets.empty()) {
      shuffled_parameters.offsets.push_back(parameters.offsets[from]);
    }
  }
  const auto straight = ConsensusFusion(parameters).fuse(readings);
  const auto permuted = ConsensusFusion(shuffled_parameters).fuse(shuffled);
  RC_ASSERT(permuted.status == straight.status);
  for (std::size_t i = 0; i < m; ++i) {
    RC_ASSERT(permuted.fusion_set[i] == straight.fusion_set[order[i]]);
    RC_ASSERT(permuted.rejections[i] == straight.rejections[order[i]]);
    for (std::size_t j = 0; j < m; ++j) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto column = static_cast<Eigen::Index>(j);
      const auto old_row = static_cast<Eigen::Index>(order[i]);
      const auto old_column = static_cast<Eigen::Index>(order[j]);
      RC_ASSERT(same_bits(permuted.confidence_distance(row, column),
                          straight.confidence_distance(old_row, old_column)));
      RC_ASSERT(permuted.relation(row, column) == straight.relation(old_row, old_column));
    }
  }
  RC_ASSERT(close(permuted.fused.distance, straight.fused.distance));
  RC_ASSERT(close(permuted.fused.standard_deviation, straight.fused.standard_deviation));
}

RC_GTEST_PROP(FusionProperty, FollowsATranslation, ()) {
  const Readings readings = draw_mixed();
  const ConsensusFusion fusion(draw_parameters(readings.size()));
  const double shift = draw(-1000000, 1000000) * kGrid;
  Readings moved = readings;
  for (auto& reading : moved) {
    reading.distance += shift;
  }
  const auto here = fusion.fuse(readings);
  const auto there = fusion.fuse(moved);
  RC_ASSERT(there.confidence_distance == here.confidence_distance);
  RC_ASSERT(there.relation == here.relation);
  RC_ASSERT(there.fusion_set == here.fusion_set);
  RC_ASSERT(there.rejections == here.rejections);
  if (here.status == FusionStatus::kOk) {
    RC_ASSERT(std::abs(there.fused.distance - shift - here.fused.distance) < 1e-9);
  }
  RC_ASSERT(close(there.fused.standard_deviation, here.fused.standard_deviation));
}

RC_GTEST_PROP(FusionProperty, FollowsAChangeOfUnit, ()) {
  const Readings readings = draw_mixed();
  const auto parameters = draw_parameters(readings.size());
  const double scale = std::ldexp(1.0, draw(-20, 20));
  Readings scaled = readings;
  for (auto& reading : scaled) {
    reading.distance *= scale;
    reading.standard_deviation *= scale;
  }
  auto scaled_parameters = parameters;
  for (auto& offset : scaled_parameters.offsets) {
    offset *= scale;
  }
  const auto one = ConsensusFusion(parameters).fuse(readings);
  const auto other = ConsensusFusion(scaled_parameters).fuse(scaled);
  RC_ASSERT(other.confidence_distance == one.confidence_distance);
  RC_ASSERT(other.fusion_set == one.fusion_set);
  RC_ASSERT(other.rejections == one.rejections);
  if (one.status == FusionStatus::kOk) {
    RC_ASSERT(same_bits(other.fused.distance, one.fused.distance * scale));
    RC_ASSERT(same_bits(other.fused.standard_deviation, one.fused.standard_deviation * scale));
  }
}

RC_GTEST_PROP(FusionProperty, UnusableReadingsHaveNoInfluence, ()) {
  const Readings readings = draw_mixed();
  const auto parameters = draw_parameters(readings.size());
  const auto with = ConsensusFusion(parameters).fuse(readings);

  // Unusable in another way: not a bit of the rest changes.
  Readings otherwise = readings;
  Readings usable;
  std::vector<std::size_t> places;
  ConsensusFusionParameters usable_parameters = parameters;
  usable_parameters.offsets.clear();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (with.rejections[i] == RejectionReason::kNone ||
        with.rejections[i] == RejectionReason::kUnsupported) {
      usable.push_back(readings[i]);
      places.push_back(i);
      if (!parameters.offsets.empty()) {
        usable_parameters.offsets.push_back(parameters.offsets[i]);
      }
    } else {
      otherwise[i] = draw_unusable();
    }
  }
  const auto changed = ConsensusFusion(parameters).fuse(otherwise);
  RC_ASSERT(changed.confidence_distance == with.confidence_distance);
  RC_ASSERT(changed.relation == with.relation);
  RC_ASSERT(changed.fusion_set == with.fusion_set);
  RC_ASSERT(same_bits(changed.fused, with.fused));

  // Not there at all: the same again.
  if (usable.size() < kMinOdometers) {
    return;
  }
  const auto without = ConsensusFusion(usable_parameters).fuse(usable);
  RC_ASSERT(without.status == with.status);
  RC_ASSERT(same_bits(without.fused, with.fused));
  for (std::size_t i = 0; i < places.size(); ++i) {
    RC_ASSERT(without.fusion_set[i] == with.fusion_set[places[i]]);
    for (std::size_t j = 0; j < places.size(); ++j) {
      RC_ASSERT(same_bits(
          without.confidence_distance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)),
          with.confidence_distance(static_cast<Eigen::Index>(places[i]),
                                   static_cast<Eigen::Index>(places[j]))));
    }
  }
}

RC_GTEST_PROP(FusionProperty, ReasonsAndFusionSetTellTheSame, ()) {
  const Readings readings = draw_mixed();
  const auto result = ConsensusFusion(draw_parameters(readings.size())).fuse(readings);
  for (std::size_t i = 0; i < kMaxOdometers; ++i) {
    const bool exists = i < readings.size();
    RC_ASSERT(result.fusion_set[i] == (exists && result.rejections[i] == RejectionReason::kNone));
  }
}

RC_GTEST_PROP(FusionProperty, SameInputGivesTheSameBits, ()) {
  const Readings readings = draw_mixed();
  const auto parameters = draw_parameters(readings.size());
  const ConsensusFusion fusion(parameters);
  const auto first = fusion.fuse(readings);
  Readings others(readings.size());
  std::generate(others.begin(), others.end(), draw_reading);
  static_cast<void>(fusion.fuse(others));  // leaves nothing behind
  for (const auto& again : {fusion.fuse(readings), ConsensusFusion(parameters).fuse(readings)}) {
    RC_ASSERT(again.confidence_distance == first.confidence_distance);
    RC_ASSERT(again.relation == first.relation);
    RC_ASSERT(again.fusion_set == first.fusion_set);
    RC_ASSERT(again.rejections == first.rejections);
    RC_ASSERT(same_bits(again.fused, first.fused));
  }
}

}  // namespace
}  // namespace pipescout::odometry
