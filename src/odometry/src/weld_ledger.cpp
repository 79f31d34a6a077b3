// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_ledger.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "ledger_adjustment.hpp"
#include "ledger_landmarks.hpp"
#include "pipescout/validation/check.hpp"
#include "weld_alignment_model.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

void check_run(const LedgerRun& run) {
  const auto fits = [](const std::string& text) {
    return std::none_of(text.begin(), text.end(),
                        [](char c) { return c == '|' || (static_cast<unsigned char>(c) < 0x20U); });
  };
  if (run.name.empty() || !fits(run.name)) {
    refuse("name: '", run.name, "' is empty or holds '|' or control characters");
  }
  if (!fits(run.date)) {
    refuse("date: '", run.date, "' holds '|' or control characters");
  }
}

/// "W00010", "W00020", ...: room for welds that later runs find between.
std::string first_id(std::size_t k) {
  const std::string digits = std::to_string(10 * (k + 1));
  std::string id = "W";
  id.append(digits.size() < 5 ? 5 - digits.size() : 0, '0');
  return id.append(digits);
}

/// How exactly a weld's own place is known, leaving aside the way to it.
double own_sigma(const LedgerWeld& weld) {
  double information = 0.0;
  for (const LedgerSighting& sighting : weld.sightings) {
    information += 1.0 / (sighting.standard_deviation * sighting.standard_deviation);
  }
  return information > 0.0 ? 1.0 / std::sqrt(information) : weld.standard_deviation;
}

/// The welds of the run that the ledger does not have, where the alignment puts them, in order.
void add_unmatched(LedgerUpdate& update, std::size_t run, std::span<const WeldPosition> welds,
                   double shortest_joint) {
  std::vector<LedgerWeld>& known = update.ledger.welds;
  std::set<std::string> ids;
  for (const LedgerWeld& weld : known) {
    ids.insert(weld.id);
  }
  std::vector<LedgerWeld> added;
  for (const UnmatchedWeld& unmatched : update.alignment.only_a) {
    const WeldPosition& seen = welds[unmatched.index];
    const MappedChainage place = update.alignment.a_to_b.map(seen.chainage);
    const auto next = std::lower_bound(
        known.begin(), known.end(), place.chainage,
        [](const LedgerWeld& weld, double chainage) { return weld.chainage < chainage; });
    const bool near_next = next != known.end() && next->chainage - place.chainage < shortest_joint;
    const bool near_previous =
        next != known.begin() && place.chainage - std::prev(next)->chainage < shortest_joint;
    if (near_next || near_previous) {
      update.ambiguous.push_back(unmatched.index);
      continue;
    }
    const std::string stem = next == known.begin() ? "W00000" : std::prev(next)->id;
    std::string id;
    for (int suffix = 1; id.empty() || ids.contains(id); ++suffix) {
      id = stem + "." + std::to_string(suffix);
    }
    ids.insert(id);
    LedgerWeld weld;
    weld.id = id;
    weld.chainage = place.chainage;
    weld.standard_deviation = place.standard_deviation;
    weld.sightings = {
        {.run = run, .chainage = seen.chainage, .standard_deviation = seen.standard_deviation}};
    added.push_back(std::move(weld));
  }
  update.added = added.size();
  known.insert(known.end(), std::make_move_iterator(added.begin()),
               std::make_move_iterator(added.end()));
  std::stable_sort(known.begin(), known.end(), [](const LedgerWeld& one, const LedgerWeld& next) {
    return one.chainage < next.chainage;
  });
}

}  // namespace

void LedgerParameters::validate() const {
  alignment.validate();
  require("length_noise", length_noise, length_noise > 0.0 && length_noise <= 1.0, "(0, 1]");
  require("scale_sigma", scale_sigma, scale_sigma >= 0.0 && scale_sigma <= 0.2, "[0, 0.2]");
  require("shortest_joint", shortest_joint, shortest_joint > 0.0 && shortest_joint <= 10.0,
          "(0, 10]");
}

LedgerUpdate build_ledger(const LedgerRun& run, std::span<const WeldPosition> welds,
                          const LedgerParameters& parameters) {
  parameters.validate();
  check_run(run);
  LedgerUpdate update;
  const alignment::WeldSequence sequence = alignment::usable(welds, update.unusable);
  if (sequence.size() < 3) {
    return update;
  }
  update.accepted = true;
  update.added = sequence.size();
  update.ledger.runs.push_back(run);
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    const WeldPosition& seen = welds[sequence.index[k]];
    LedgerWeld weld;
    weld.id = first_id(k);
    weld.chainage = seen.chainage;
    weld.sightings = {
        {.run = 0, .chainage = seen.chainage, .standard_deviation = seen.standard_deviation}};
    update.ledger.welds.push_back(std::move(weld));
  }
  adjust(update.ledger, parameters);
  return update;
}

LedgerUpdate merge_run(const WeldLedger& ledger, const LedgerRun& run,
                       std::span<const WeldPosition> welds, const LedgerParameters& parameters) {
  parameters.validate();
  check_run(run);
  if (std::find(ledger.runs.begin(), ledger.runs.end(), run) != ledger.runs.end()) {
    refuse("name: the ledger has the run '", run.name, "' of '", run.date, "' already");
  }
  LedgerUpdate update;
  update.ledger = ledger;
  update.alignment = align_welds(welds, weld_positions(ledger), parameters.alignment);
  update.unusable = update.alignment.unusable_a;
  if (update.alignment.status != AlignmentStatus::kOk) {
    return update;
  }
  update.accepted = true;
  const std::size_t index = update.ledger.runs.size();
  update.ledger.runs.push_back(run);
  for (const WeldMatch& match : update.alignment.matches) {
    update.ledger.welds[match.b].sightings.push_back(
        {.run = index,
         .chainage = welds[match.a].chainage,
         .standard_deviation = welds[match.a].standard_deviation});
  }
  add_unmatched(update, index, welds, parameters.shortest_joint);
  for (LedgerWeld& weld : update.ledger.welds) {
    weld.position.reset();
  }
  update.ledger.frame = MapFrame::kNone;
  adjust(update.ledger, parameters);
  place_landmarks(update.ledger, parameters);
  return update;
}

std::vector<WeldPosition> weld_positions(const WeldLedger& ledger) {
  std::vector<WeldPosition> result;
  for (const LedgerWeld& weld : ledger.welds) {
    result.push_back({.chainage = weld.chainage, .standard_deviation = own_sigma(weld)});
  }
  return result;
}

std::vector<WeldEvidence> evidence(const WeldLedger& ledger) {
  struct Extent {
    std::size_t first = std::numeric_limits<std::size_t>::max();
    std::size_t last = 0;
  };
  std::vector<Extent> extents(ledger.runs.size());
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    for (const LedgerSighting& sighting : ledger.welds[k].sightings) {
      Extent& extent = extents[sighting.run];
      extent.first = std::min(extent.first, k);
      extent.last = std::max(extent.last, k);
    }
  }
  std::vector<WeldEvidence> result(ledger.welds.size());
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    WeldEvidence& entry = result[k];
    entry.seen = ledger.welds[k].sightings.size();
    entry.passed = static_cast<std::size_t>(
        std::count_if(extents.begin(), extents.end(),
                      [k](const Extent& extent) { return extent.first <= k && k <= extent.last; }));
    entry.verdict = entry.seen >= 2     ? WeldVerdict::kConfirmed
                    : entry.passed >= 2 ? WeldVerdict::kDoubtful
                                        : WeldVerdict::kSingle;
  }
  return result;
}

WeldLedger lay_along(WeldLedger ledger, const CentreLine& line) {
  ledger.frame = line.frame();
  for (LedgerWeld& weld : ledger.welds) {
    weld.position = line.at(weld.chainage, weld.standard_deviation);
  }
  for (LedgerLandmark& landmark : ledger.landmarks) {
    landmark.position = line.at(landmark.chainage, landmark.standard_deviation);
  }
  return ledger;
}

ChainageMap run_to_ledger(const WeldLedger& ledger, std::size_t run,
                          const LedgerParameters& parameters) {
  parameters.validate();
  std::vector<ChainageKnot> knots;
  for (const LedgerWeld& weld : ledger.welds) {
    for (const LedgerSighting& sighting : weld.sightings) {
      if (sighting.run == run) {
        knots.push_back(
            {.from = sighting.chainage,
             .to = weld.chainage,
             .standard_deviation = std::hypot(sighting.standard_deviation, own_sigma(weld))});
      }
    }
  }
  if (run >= ledger.runs.size()) {
    throw std::out_of_range("run " + std::to_string(run) + " of " +
                            std::to_string(ledger.runs.size()));
  }
  if (knots.size() > 1 && knots.front().from > knots.back().from) {
    std::reverse(knots.begin(), knots.end());
  }
  return ChainageMap(std::move(knots), {.length_noise = parameters.length_noise,
                                        .scale_sigma = parameters.scale_sigma});
}

LedgerPlace locate(const WeldLedger& ledger, const MappedChainage& place) {
  LedgerPlace result;
  if (!std::isfinite(place.chainage) || ledger.welds.empty()) {
    return result;
  }
  const auto next = std::upper_bound(
      ledger.welds.begin(), ledger.welds.end(), place.chainage,
      [](double chainage, const LedgerWeld& weld) { return chainage < weld.chainage; });
  const LedgerWeld& nearest = next == ledger.welds.begin() ? *next : *std::prev(next);
  result.chainage = place.chainage;
  result.standard_deviation = std::hypot(place.standard_deviation, nearest.standard_deviation);
  if (next == ledger.welds.begin()) {
    return result;
  }
  const LedgerWeld& before = *std::prev(next);
  result.weld = before.id;
  result.from_weld = place.chainage - before.chainage;
  result.from_weld_standard_deviation = place.standard_deviation;
  if (next != ledger.welds.end() && before.position && next->position) {
    const double t = result.from_weld / (next->chainage - before.chainage);
    const double survey =
        std::lerp(before.position->standard_deviation, next->position->standard_deviation, t);
    result.position =
        MapPosition{.coordinates = map_between(ledger.frame, before.position->coordinates,
                                               next->position->coordinates, t),
                    .standard_deviation = std::hypot(survey, place.standard_deviation)};
  }
  return result;
}

const char* to_string(WeldVerdict verdict) noexcept {
  switch (verdict) {
    case WeldVerdict::kConfirmed:
      return "confirmed";
    case WeldVerdict::kSingle:
      return "single";
    case WeldVerdict::kDoubtful:
      return "doubtful";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
