// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "figures.hpp"

namespace pipescout::benchmarks {

/// What all programs do: reads `--json FILE` and the options of Google Benchmark, runs what
/// `register_cases` registers, prints what `evaluate` makes of it and writes it to FILE. Returns
/// the exit code.
///
/// The cases take turns in random order, ten times over, so that a slow spell of the machine hits
/// all alike.
int run_program(int argc, char** argv, const std::function<void()>& register_cases,
                const std::function<Figures()>& evaluate);

}  // namespace pipescout::benchmarks
