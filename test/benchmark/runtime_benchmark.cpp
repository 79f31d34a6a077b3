// SPDX-License-Identifier: Apache-2.0
// What the runtime adds to topics and services: actions.
#include "action_cases.hpp"
#include "program.hpp"

int main(int argc, char** argv) {
  using namespace pipescout::benchmarks;  // NOLINT(google-build-using-namespace): of this function
  return run_program(
      argc, argv, [] { register_action_cases(); },
      [] {
        Figures figures;
        add_action_figures(figures);
        return figures;
      });
}
