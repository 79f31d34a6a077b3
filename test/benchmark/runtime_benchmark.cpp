// SPDX-License-Identifier: Apache-2.0
// What the runtime adds to topics and services: actions, and transforms with libtf2 in the same
// run.
#include "action_cases.hpp"
#include "figures.hpp"
#include "program.hpp"
#include "transform_cases.hpp"

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  return pb::run_program(
      argc, argv,
      [] {
        pb::register_action_cases();
        pb::register_transform_cases();
      },
      [] {
        pb::Figures figures;
        pb::add_action_figures(figures);
        pb::add_transform_figures(figures);
        return figures;
      });
}
