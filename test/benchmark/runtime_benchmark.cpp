// SPDX-License-Identifier: Apache-2.0
// What the runtime costs beyond messages: transforms, with libtf2 in the same run.
#include "figures.hpp"
#include "program.hpp"
#include "transform_cases.hpp"

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  return pb::run_program(
      argc, argv, [] { pb::register_transform_cases(); },
      [] {
        pb::Figures figures;
        pb::add_transform_figures(figures);
        return figures;
      });
}
