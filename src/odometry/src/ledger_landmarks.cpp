// SPDX-License-Identifier: Apache-2.0
#include "ledger_landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace pipescout::odometry {
namespace {

constexpr double kGate = 4.0;  // standard deviations

char letter(LandmarkKind kind) {
  switch (kind) {
    case LandmarkKind::kMarker:
      return 'M';
    case LandmarkKind::kValve:
      return 'V';
    case LandmarkKind::kTee:
      return 'T';
    case LandmarkKind::kBend:
      break;
  }
  return 'B';
}

/// "V00030": ten after the last of this kind, so that ids are never used again while it is there.
std::string next_landmark_id(const WeldLedger& ledger, LandmarkKind kind) {
  const auto is_taken = [&](const std::string& id) {
    return std::ranges::any_of(ledger.landmarks, [&](const auto& other) { return other.id == id; });
  };
  for (std::size_t number = 10;; number += 10) {
    const std::string digits = std::to_string(number);
    std::string id(1, letter(kind));
    id.append(digits.size() < 5 ? 5 - digits.size() : 0, '0');
    id += digits;
    if (!is_taken(id)) {
      return id;
    }
  }
}

bool has_seen(const LedgerLandmark& landmark, std::size_t run) {
  return std::ranges::any_of(landmark.sightings,
                             [run](const LedgerSighting& other) { return other.run == run; });
}

bool is_usable(const LandmarkPosition& seen) {
  return std::isfinite(seen.chainage) && std::isfinite(seen.standard_deviation) &&
         seen.standard_deviation > 0.0;
}

/// A landmark of the ledger and one of the run, and how far apart.
struct LandmarkPair {
  double distance;
  std::size_t known;
  std::size_t seen;
};

/// The pairs that the gate allows, the nearest first.
std::vector<LandmarkPair> landmark_pairs(const WeldLedger& ledger, std::size_t run,
                                         std::span<const LandmarkPosition> landmarks,
                                         const ChainageMap& map) {
  std::vector<LandmarkPair> pairs;
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    if (!is_usable(landmarks[k])) {
      continue;
    }
    const MappedChainage place = map.map(landmarks[k].chainage);
    for (std::size_t l = 0; l < ledger.landmarks.size(); ++l) {
      const LedgerLandmark& known = ledger.landmarks[l];
      const double distance = std::abs(known.chainage - place.chainage);
      const double sigma = std::hypot(known.standard_deviation, place.standard_deviation,
                                      landmarks[k].standard_deviation);
      if (known.kind == landmarks[k].kind && !has_seen(known, run) && distance <= kGate * sigma) {
        pairs.push_back({distance, l, k});
      }
    }
  }
  std::ranges::stable_sort(pairs, {}, &LandmarkPair::distance);
  return pairs;
}

}  // namespace

void place_landmarks(WeldLedger& ledger, const LedgerParameters& parameters) {
  std::vector<ChainageMap> maps;
  for (std::size_t run = 0; run < ledger.runs.size(); ++run) {
    maps.push_back(run_to_ledger(ledger, run, parameters));
  }
  for (LedgerLandmark& landmark : ledger.landmarks) {
    double information = 0.0;
    double weighted = 0.0;
    for (const LedgerSighting& sighting : landmark.sightings) {
      const MappedChainage place = maps[sighting.run].map(sighting.chainage);
      const double variance = place.standard_deviation * place.standard_deviation +
                              sighting.standard_deviation * sighting.standard_deviation;
      if (std::isfinite(place.chainage) && std::isfinite(variance)) {
        information += 1.0 / variance;
        weighted += place.chainage / variance;
      }
    }
    if (information > 0.0) {
      landmark.chainage = weighted / information;
      landmark.standard_deviation = 1.0 / std::sqrt(information);
    }
    landmark.position.reset();
  }
  std::ranges::stable_sort(ledger.landmarks, {}, &LedgerLandmark::chainage);
}

WeldLedger add_landmarks(WeldLedger ledger, std::size_t run,
                         std::span<const LandmarkPosition> landmarks,
                         const LedgerParameters& parameters) {
  const ChainageMap map = run_to_ledger(ledger, run, parameters);
  std::vector<bool> is_known(landmarks.size());
  for (const LandmarkPair& pair : landmark_pairs(ledger, run, landmarks, map)) {
    if (is_known[pair.seen] || has_seen(ledger.landmarks[pair.known], run)) {
      continue;
    }
    is_known[pair.seen] = true;
    ledger.landmarks[pair.known].sightings.push_back(
        {.run = run,
         .chainage = landmarks[pair.seen].chainage,
         .standard_deviation = landmarks[pair.seen].standard_deviation});
  }
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    if (is_known[k] || !is_usable(landmarks[k]) ||
        !std::isfinite(map.map(landmarks[k].chainage).chainage)) {
      continue;
    }
    LedgerLandmark added;
    added.id = next_landmark_id(ledger, landmarks[k].kind);
    added.kind = landmarks[k].kind;
    added.sightings = {{.run = run,
                        .chainage = landmarks[k].chainage,
                        .standard_deviation = landmarks[k].standard_deviation}};
    ledger.landmarks.push_back(std::move(added));
  }
  place_landmarks(ledger, parameters);
  return ledger;
}

const char* to_string(LandmarkKind kind) noexcept {
  switch (kind) {
    case LandmarkKind::kMarker:
      return "marker";
    case LandmarkKind::kValve:
      return "valve";
    case LandmarkKind::kTee:
      return "tee";
    case LandmarkKind::kBend:
      return "bend";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
