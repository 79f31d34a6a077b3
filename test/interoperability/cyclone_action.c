// SPDX-License-Identifier: Apache-2.0
#include "cyclone_action.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "all_messages.h"

#define TYPE "example_interfaces::action::dds_::Fibonacci_"
#define NAME "/interop/fibonacci/_action/"

static void check(dds_return_t code, const char* what) {
  if (code < 0) {
    fprintf(stderr, "cyclone_peer: %s: %s\n", what, dds_strretcode(-code));
    exit(1);
  }
}

static dds_entity_t make_topic(dds_entity_t participant, dds_topic_descriptor_t descriptor,
                               const char* type, const char* topic) {
  descriptor.m_typename = type;
  const dds_entity_t made = dds_create_topic(participant, &descriptor, topic, NULL, NULL);
  check(made, topic);
  return made;
}

static dds_entity_t make_endpoint(dds_entity_t participant, bool is_writer,
                                  const dds_topic_descriptor_t* descriptor, const char* type,
                                  const char* topic, bool transient_local) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos,
                      transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, transient_local ? 1 : 10);
  const dds_entity_t made_topic = make_topic(participant, *descriptor, type, topic);
  const dds_entity_t made = is_writer ? dds_create_writer(participant, made_topic, qos, NULL)
                                      : dds_create_reader(participant, made_topic, qos, NULL);
  check(made, topic);
  dds_delete_qos(qos);
  return made;
}

void make_action(struct cyclone_action* action, dds_entity_t participant) {
  memset(action, 0, sizeof *action);
  for (uint8_t i = 0; i < 15; ++i) {
    action->goal_id[i] = (uint8_t)(0xc7 + i);
  }
  action->goal_writer =
      make_endpoint(participant, true, &example_interfaces_action_Fibonacci_SendGoal_Request_desc,
                    TYPE "SendGoal_Request_", "rq" NAME "send_goalRequest", false);
  action->goal_reader =
      make_endpoint(participant, false, &example_interfaces_action_Fibonacci_SendGoal_Response_desc,
                    TYPE "SendGoal_Response_", "rr" NAME "send_goalReply", false);
  action->result_writer =
      make_endpoint(participant, true, &example_interfaces_action_Fibonacci_GetResult_Request_desc,
                    TYPE "GetResult_Request_", "rq" NAME "get_resultRequest", false);
  action->result_reader = make_endpoint(
      participant, false, &example_interfaces_action_Fibonacci_GetResult_Response_desc,
      TYPE "GetResult_Response_", "rr" NAME "get_resultReply", false);
  action->feedback_reader =
      make_endpoint(participant, false, &example_interfaces_action_Fibonacci_FeedbackMessage_desc,
                    TYPE "FeedbackMessage_", "rt" NAME "feedback", false);
  action->status_reader =
      make_endpoint(participant, false, &action_msgs_msg_GoalStatusArray_desc,
                    "action_msgs::msg::dds_::GoalStatusArray_", "rt" NAME "status", true);
}

static bool is_matched(dds_entity_t writer, dds_entity_t reader) {
  dds_publication_matched_status_t readers;
  dds_subscription_matched_status_t writers;
  check(dds_get_publication_matched_status(writer, &readers), "matched readers");
  check(dds_get_subscription_matched_status(reader, &writers), "matched writers");
  return readers.current_count > 0 && writers.current_count > 0;
}

static void print_numbers(const int32_t* numbers, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    printf(" %d", numbers[i]);
  }
  printf("\n");
  fflush(stdout);
}

// Takes one sample; false when there is none. The sample is to be given back.
static bool take(dds_entity_t reader, void** sample) {
  dds_sample_info_t info;
  *sample = NULL;
  while (dds_take(reader, sample, &info, 1, 1) > 0) {
    if (info.valid_data) {
      return true;
    }
    check(dds_return_loan(reader, sample, 1), "return loan");
    *sample = NULL;
  }
  return false;
}

static void give_back(dds_entity_t reader, void** sample) {
  check(dds_return_loan(reader, sample, 1), "return loan");
}

static void send_requests(struct cyclone_action* action) {
  if (action->is_ended || action->rounds++ % 10 != 0) {
    return;
  }
  if (!action->is_accepted && is_matched(action->goal_writer, action->goal_reader)) {
    example_interfaces_action_Fibonacci_SendGoal_Request request = {.goal = {.order = 3}};
    // Another goal each time: the reply to the one before may have been lost, while the server's
    // writer had not found its reader.
    ++action->goal_id[15];
    memcpy(request.goal_id.uuid_, action->goal_id, sizeof action->goal_id);
    check(dds_write(action->goal_writer, &request), "send_goal");
  } else if (action->is_accepted && is_matched(action->result_writer, action->result_reader)) {
    example_interfaces_action_Fibonacci_GetResult_Request request;
    memcpy(request.goal_id.uuid_, action->goal_id, sizeof action->goal_id);
    check(dds_write(action->result_writer, &request), "get_result");
  } else {
    action->rounds = 0;
  }
}

void run_action(struct cyclone_action* action) {
  void* sample;
  send_requests(action);
  while (take(action->goal_reader, &sample)) {
    const example_interfaces_action_Fibonacci_SendGoal_Response* reply = sample;
    printf("goal_reply %d\n", reply->accepted);
    fflush(stdout);
    action->is_accepted |= reply->accepted;
    action->rounds = 0;
    give_back(action->goal_reader, &sample);
  }
  while (take(action->feedback_reader, &sample)) {
    const example_interfaces_action_Fibonacci_FeedbackMessage* message = sample;
    printf("feedback %x", message->goal_id.uuid_[0]);
    print_numbers(message->feedback.sequence._buffer, message->feedback.sequence._length);
    give_back(action->feedback_reader, &sample);
  }
  while (take(action->status_reader, &sample)) {
    const action_msgs_msg_GoalStatusArray* message = sample;
    for (uint32_t i = 0; i < message->status_list._length; ++i) {
      printf("status %d\n", message->status_list._buffer[i].status);
    }
    fflush(stdout);
    give_back(action->status_reader, &sample);
  }
  while (take(action->result_reader, &sample)) {
    const example_interfaces_action_Fibonacci_GetResult_Response* reply = sample;
    action->is_ended = 1;
    printf("result %d", reply->status);
    print_numbers(reply->result.sequence._buffer, reply->result.sequence._length);
    give_back(action->result_reader, &sample);
  }
}
