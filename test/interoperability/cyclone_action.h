// SPDX-License-Identifier: Apache-2.0
// A client of the action /interop/fibonacci, made of plain DDS endpoints of the other vendor.
#pragma once

#include <dds/dds.h>

struct cyclone_action {
  dds_entity_t goal_writer, goal_reader;      // requests and replies of send_goal
  dds_entity_t result_writer, result_reader;  // of get_result
  dds_entity_t feedback_reader, status_reader;
  uint8_t goal_id[16];  // of the last request
  unsigned rounds;      // since the last request
  int is_accepted;
  int is_ended;
};

void make_action(struct cyclone_action* action, dds_entity_t participant);
// To be called about ten times a second. Sends a goal of order 3 once a server is there, then asks
// for its result, each again after a second without an answer; prints what comes:
//   goal_reply ACCEPTED
//   feedback FIRST_BYTE_OF_THE_IDENTIFIER NUMBER...
//   status STATUS                (of each goal that a status message lists)
//   result STATUS NUMBER...
void run_action(struct cyclone_action* action);
