// SPDX-License-Identifier: Apache-2.0
#include "pipe_place.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::rack_vision {
namespace {

constexpr double kClearlyMore = 0.15;  // of the samples

struct Agreement {
  int samples = 0;
  double mean = 0;
};

/// Of each sample its vote that is nearest to the place, where that is near enough.
Agreement agreement_on(double place, std::span<const PlaceVote> votes) {
  Agreement agreement;
  double sum = 0;
  for (std::size_t i = 0; i < votes.size();) {
    const std::uint32_t sample = votes[i].sample;
    const PlaceVote* nearest = &votes[i];
    for (; i < votes.size() && votes[i].sample == sample; ++i) {
      if (std::abs(votes[i].offset - place) < std::abs(nearest->offset - place)) {
        nearest = &votes[i];
      }
    }
    if (std::abs(nearest->offset - place) <= nearest->half_width) {
      ++agreement.samples;
      sum += nearest->offset;
    }
  }
  agreement.mean = agreement.samples > 0 ? sum / agreement.samples : place;
  return agreement;
}

}  // namespace

std::optional<double> agreed_place(std::span<const PlaceVote> votes, int samples,
                                   double least_share) {
  Agreement best;
  for (const PlaceVote& vote : votes) {
    const Agreement agreement = agreement_on(vote.offset, votes);
    if (agreement.samples > best.samples) {
      best = agreement;
    }
  }
  if (best.samples == 0 || best.samples < least_share * samples) {
    return std::nullopt;
  }
  const double rival = best.samples - kClearlyMore * samples;
  const bool is_clear = std::ranges::none_of(votes, [&](const PlaceVote& vote) {
    return std::abs(vote.offset - best.mean) > 3 * vote.half_width &&
           agreement_on(vote.offset, votes).samples > rival;
  });
  return is_clear ? std::optional(best.mean) : std::nullopt;
}

}  // namespace pipescout::rack_vision
