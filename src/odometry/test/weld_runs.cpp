// SPDX-License-Identifier: Apache-2.0
#include "weld_runs.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace pipescout::odometry::test {
namespace {

using Uniform = std::uniform_real_distribution<double>;
using Normal = std::normal_distribution<double>;

Pipe laid_end_to_end(const std::vector<double>& joints) {
  Pipe pipe{0.0};
  for (const double joint : joints) {
    pipe.push_back(pipe.back() + joint);
  }
  return pipe;
}

}  // namespace

Pipe regular_pipe(std::size_t joints, double spread, std::mt19937_64& engine) {
  Normal length(12.0, 12.0 * spread);
  std::vector<double> lengths(joints);
  std::generate(lengths.begin(), lengths.end(), [&] { return length(engine); });
  return laid_end_to_end(lengths);
}

Pipe laid_pipe(std::size_t joints, std::mt19937_64& engine) {
  Normal whole(12.2, 0.02);
  Uniform cut(1.0, 12.0);
  Uniform share(0.0, 1.0);
  std::vector<double> lengths(joints);
  std::generate(lengths.begin(), lengths.end(),
                [&] { return share(engine) < 0.75 ? whole(engine) : cut(engine); });
  return laid_end_to_end(lengths);
}

WeldRun make_run(const Pipe& pipe, std::size_t first, std::size_t last, const RunFaults& faults,
                 std::mt19937_64& engine) {
  Uniform share(0.0, 1.0);
  Normal normal(0.0, 1.0);
  WeldRun run;
  double chainage = faults.start;
  const auto see = [&](double there, int truth, double place) {
    run.welds.push_back({.chainage = there + faults.detection_sigma * normal(engine),
                         .standard_deviation = faults.detection_sigma});
    run.truth.push_back(truth);
    run.place.push_back(place);
  };
  for (std::size_t k = first; k < last; ++k) {
    if (k > first) {
      const double length = pipe[k] - pipe[k - 1];
      const double done = (pipe[k] - pipe[first]) / (pipe[last - 1] - pipe[first]);
      double measured = length * (faults.scale + faults.drift * done) +
                        faults.noise * std::sqrt(length) * normal(engine);
      if (share(engine) < faults.slip_share) {
        measured += faults.largest_slip * (2.0 * share(engine) - 1.0);
      }
      measured = std::max(measured, 0.1);
      if (share(engine) < faults.spurious) {
        // A detector takes what is nearer than this to a weld for the weld itself.
        constexpr double kApart = 0.5;  // m
        const double place = kApart + share(engine) * (measured - 2.0 * kApart);
        if (place >= kApart) {
          see(chainage + place, kSpurious, pipe[k - 1] + place * length / measured);
        }
      }
      chainage += measured;
    }
    if (share(engine) >= faults.missed) {
      see(chainage, static_cast<int>(k), pipe[k]);
    }
  }
  return run;
}

WeldRun driven_back(const WeldRun& run) {
  WeldRun back = run;
  std::reverse(back.welds.begin(), back.welds.end());
  std::reverse(back.truth.begin(), back.truth.end());
  std::reverse(back.place.begin(), back.place.end());
  for (WeldPosition& weld : back.welds) {
    weld.chainage = run.welds.back().chainage - weld.chainage;
  }
  return back;
}

AlignmentScore score(const WeldAlignment& alignment, const WeldRun& a, const WeldRun& b) {
  AlignmentScore result;
  const std::set<int> seen_by_b(b.truth.begin(), b.truth.end());
  for (const int weld : a.truth) {
    result.common += weld != kSpurious && seen_by_b.contains(weld) ? 1U : 0U;
  }
  for (const WeldMatch& match : alignment.matches) {
    const int weld = a.truth[match.a];
    result.right += weld != kSpurious && weld == b.truth[match.b] ? 1U : 0U;
    result.wrong += std::abs(a.place[match.a] - b.place[match.b]) > 0.3 ? 1U : 0U;
  }
  return result;
}

}  // namespace pipescout::odometry::test
