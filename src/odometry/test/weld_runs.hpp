// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "pipescout/odometry/weld_alignment.hpp"

namespace pipescout::odometry::test {

inline constexpr int kSpurious = -1;

/// A pipe: chainage of its girth welds, m.
using Pipe = std::vector<double>;

/// `joints` of 12 m, normal with the given relative spread.
[[nodiscard]] Pipe regular_pipe(std::size_t joints, double spread, std::mt19937_64& engine);

/// As real lines are laid: three joints in four of 12.2 m +- 2 cm, the others cut to 1 .. 12 m.
[[nodiscard]] Pipe laid_pipe(std::size_t joints, std::mt19937_64& engine);

/// What a run does to the truth.
struct RunFaults {
  double missed = 0.02;           // share of the welds
  double spurious = 0.01;         // per weld, anywhere but within 0.5 m of a weld
  double detection_sigma = 0.02;  // m
  double scale = 1.0;             // of the odometer at the start
  double drift = 0.02;            // change of the scale over the run, linear (wear)
  double noise = 0.01;            // m / sqrt(m)
  double slip_share = 0.01;       // of the joints
  double largest_slip = 3.0;      // m, uniform within +-, at one place of the joint
  double start = 0.0;             // m, of the run's chainage
};

struct WeldRun {
  std::vector<WeldPosition> welds;
  std::vector<int> truth;     // index in the pipe of each weld, or kSpurious
  std::vector<double> place;  // m, where in the pipe the run saw it
};

/// The run over the welds [first, last) of the pipe.
[[nodiscard]] WeldRun make_run(const Pipe& pipe, std::size_t first, std::size_t last,
                               const RunFaults& faults, std::mt19937_64& engine);

/// The same run, driven from the other end.
[[nodiscard]] WeldRun driven_back(const WeldRun& run);

struct AlignmentScore {
  std::size_t common = 0;  // welds that both runs saw
  std::size_t right = 0;   // of these, matched with each other
  std::size_t wrong = 0;   // matches of sightings more than 0.3 m apart in the pipe
};
[[nodiscard]] AlignmentScore score(const WeldAlignment& alignment, const WeldRun& a,
                                   const WeldRun& b);

}  // namespace pipescout::odometry::test
