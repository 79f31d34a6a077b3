// SPDX-License-Identifier: Apache-2.0
#include "pipe_places.hpp"

#include <algorithm>
#include <cmath>

#include "section_overlap.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr std::size_t kBeam = 64;      // combinations of the first pipes that are kept
constexpr double kParallel = 0.9998;   // cosine of 1.1 degrees
constexpr double kSmallRadius = 1e-3;  // m: what the tolerance leaves at least

std::vector<PipeSection> sections_at(const Pipe& pipe, double offset, double tolerance) {
  std::vector<PipeSection> sections;
  append_sections(pipe, offset, sections);
  for (PipeSection& section : sections) {
    section.radius_start = std::max(kSmallRadius, section.radius_start - 0.5 * tolerance);
    section.radius_end = std::max(kSmallRadius, section.radius_end - 0.5 * tolerance);
  }
  return sections;
}

bool intersect(const std::vector<PipeSection>& a, const std::vector<PipeSection>& b) {
  return std::ranges::any_of(a, [&](const PipeSection& one) {
    return std::ranges::any_of(
        b, [&](const PipeSection& other) { return sections_overlap(one, other); });
  });
}

/// Of two pipes that run the same way.
bool change_sides(const Pipe& a, double offset_a, const Pipe& b, double offset_b) {
  if (std::abs(a.direction.dot(b.direction)) < kParallel) {
    return false;
  }
  const double before = b.start.x() - a.start.x();
  return before * (before + offset_b - offset_a) < 0;
}

/// What the search keeps of each pair of places.
class Compatibility {
 public:
  Compatibility(const RackModel& model, std::span<const std::vector<PipePlace>> places,
                double tolerance)
      : model_(model), places_(places) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      auto& of_pipe = sections_.emplace_back();
      for (const PipePlace& place : places[i]) {
        of_pipe.push_back(sections_at(model.pipes[i], place.offset, tolerance));
      }
    }
  }

  [[nodiscard]] bool holds(std::size_t pipe, std::size_t place, std::size_t other,
                           std::size_t other_place) const {
    return !change_sides(model_.pipes[pipe], places_[pipe][place].offset, model_.pipes[other],
                         places_[other][other_place].offset) &&
           !intersect(sections_[pipe][place], sections_[other][other_place]);
  }

 private:
  const RackModel& model_;
  std::span<const std::vector<PipePlace>> places_;
  std::vector<std::vector<std::vector<PipeSection>>> sections_;  ///< by pipe and place
};

struct Combination {
  std::array<std::size_t, kMaxPipes> chosen{};
  double score = 0;
};

}  // namespace

void place_pipes(const RackModel& model, std::span<const std::vector<PipePlace>> places,
                 double tolerance, std::size_t most, std::vector<PlacedPipes>& placed) {
  const Compatibility compatible(model, places, tolerance);
  std::vector<Combination> kept(1);
  for (std::size_t pipe = 0; pipe < places.size(); ++pipe) {
    if (places[pipe].empty()) {
      continue;
    }
    std::vector<Combination> next;
    for (const Combination& before : kept) {
      for (std::size_t place = 0; place < places[pipe].size(); ++place) {
        bool fits = true;
        for (std::size_t other = 0; other < pipe && fits; ++other) {
          fits =
              places[other].empty() || compatible.holds(pipe, place, other, before.chosen[other]);
        }
        if (fits) {
          Combination& longer = next.emplace_back(before);
          longer.chosen[pipe] = place;
          longer.score += places[pipe][place].score;
        }
      }
    }
    std::ranges::stable_sort(next, std::ranges::greater{}, &Combination::score);
    next.resize(std::min(next.size(), std::max(kBeam, most)));
    kept = std::move(next);
  }
  placed.clear();
  for (const Combination& combination : std::span(kept).first(std::min(kept.size(), most))) {
    PlacedPipes& result = placed.emplace_back();
    result.score = combination.score;
    for (std::size_t pipe = 0; pipe < places.size(); ++pipe) {
      if (!places[pipe].empty()) {
        result.offsets[pipe] = places[pipe][combination.chosen[pipe]].offset;
      }
    }
  }
}

}  // namespace pipescout::rack_vision
