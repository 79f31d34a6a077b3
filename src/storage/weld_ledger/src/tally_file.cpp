// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_ledger/tally_file.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"

namespace pipescout {

namespace {

/// The bends among the landmarks, each from the weld before it; in front of the first, from that.
std::vector<odometry::TallyBend> bends_of(const odometry::WeldLedger& ledger) {
  constexpr double kAnyAngle = 0.5 * std::numbers::pi;  // and as much to either side
  std::vector<odometry::TallyBend> bends;
  const auto& welds = ledger.welds;
  for (const odometry::LedgerLandmark& landmark : ledger.landmarks) {
    if (landmark.kind != odometry::LandmarkKind::kBend) {
      continue;
    }
    const auto behind =
        std::ranges::upper_bound(welds, landmark.chainage, {}, &odometry::LedgerWeld::chainage);
    // The last weld has no joint behind it.
    const std::size_t joint = std::min<std::size_t>(
        behind == welds.begin() ? 0 : behind - welds.begin() - 1, welds.size() - 2);
    odometry::TallyBend bend{.joint = joint,
                             .distance = landmark.chainage - welds[joint].chainage,
                             .standard_deviation = landmark.standard_deviation,
                             .angle = landmark.angle};
    if (std::isnan(bend.angle)) {
      bend.angle = bend.angle_standard_deviation = kAnyAngle;
    }
    bends.push_back(bend);
  }
  return bends;
}

}  // namespace

Tally read_tally(const std::string& path) {
  const CsvTable csv(read_csv_text(path), path);
  const odometry::WeldLedger ledger = ledger_from_csv(csv);
  if (ledger.welds.size() < 2) {
    throw std::runtime_error(path + ": a tally needs two welds, there are " +
                             std::to_string(ledger.welds.size()));
  }
  Tally tally;
  tally.notes = csv.notes();
  tally.chainages.push_back(ledger.welds.front().chainage);
  tally.variances.push_back(0.0);
  for (const odometry::LedgerWeld& weld : ledger.welds) {
    tally.ids.push_back(weld.id);
    if (&weld == &ledger.welds.back()) {
      break;  // no joint begins at the last
    }
    odometry::TallyJoint joint{.length = weld.joint_length};
    if (std::isfinite(weld.joint_standard_deviation)) {
      joint.standard_deviation = weld.joint_standard_deviation;
    }
    tally.joints.push_back(joint);
    tally.chainages.push_back(tally.chainages.back() + joint.length);
    tally.variances.push_back(tally.variances.back() +
                              joint.standard_deviation * joint.standard_deviation);
  }
  tally.bends = bends_of(ledger);
  return tally;
}

std::string format_learnt_tally(std::span<const odometry::LearntJoint> joints,
                                double first_weld_chainage) {
  const auto is_measured = [](const auto& joint) { return joint.observations > 0; };
  const auto first = std::find_if(joints.begin(), joints.end(), is_measured);
  if (first == joints.end()) {
    return {};
  }
  const auto last = std::find_if(joints.rbegin(), joints.rend(), is_measured).base();
  odometry::WeldLedger ledger;
  ledger.runs.push_back({.name = "learnt"});
  double chainage = first_weld_chainage;
  for (auto joint = joints.begin(); joint != first; ++joint) {
    chainage += joint->length;
  }
  double variance = 0.0;
  const auto add_weld = [&](auto joint) {
    odometry::LedgerWeld weld;
    weld.id = "W" + std::to_string(joint - joints.begin());
    weld.chainage = chainage;
    if (joint != last) {
      weld.joint_length = joint->length;
      weld.joint_standard_deviation = joint->standard_deviation;
    }
    // Two welds bound a joint: each has half of its variance.
    const double own = (joint != last ? joint : joint - 1)->standard_deviation / std::sqrt(2.0);
    weld.standard_deviation = std::sqrt(variance + own * own);
    weld.sightings.push_back({.run = 0, .chainage = chainage, .standard_deviation = own});
    ledger.welds.push_back(weld);
  };
  for (auto joint = first; joint != last; ++joint) {
    add_weld(joint);
    chainage += joint->length;
    variance += joint->standard_deviation * joint->standard_deviation;
  }
  add_weld(last);
  return to_csv(ledger);
}

}  // namespace pipescout
