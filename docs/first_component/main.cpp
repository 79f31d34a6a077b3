// SPDX-License-Identifier: Apache-2.0
// The component as a program of its own.
#include "pipescout/dds/run_component.hpp"
#include "slip_alarm.hpp"

int main(int argc, char** argv) {
  return pipescout::run<tutorial::SlipAlarm>(argc, argv);
}
