// SPDX-License-Identifier: Apache-2.0
#include "cdr_cases.hpp"
#include "program.hpp"
#include "samples.hpp"

namespace pb = pipescout::benchmarks;

int main(int argc, char** argv) {
  return pb::run_program(argc, argv, pb::register_cdr, [] {
    pb::Figures figures;
    for (const auto& [name, samples] : pb::all_samples()) {
      figures.add_row({{"case", name},
                       {"median_us", samples.median()},
                       {"p99_us", samples.quantile(0.99)},
                       {"samples", samples.size()}});
    }
    pb::add_cdr_figures(figures);
    return figures;
  });
}
