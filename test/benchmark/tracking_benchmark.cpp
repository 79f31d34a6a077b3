// SPDX-License-Identifier: Apache-2.0
// What tracking a pipe costs, and what keeping it in view does.
#include "arm_cases.hpp"
#include "figures.hpp"
#include "program.hpp"
#include "tracking_cases.hpp"

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  return pb::run_program(
      argc, argv,
      [] {
        pb::register_tracker_cases();
        pb::register_arm_cases();
      },
      [] {
        pb::Figures figures;
        pb::add_tracker_figures(figures);
        pb::add_arm_figures(figures);
        return figures;
      });
}
