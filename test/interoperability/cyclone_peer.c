// SPDX-License-Identifier: Apache-2.0
// The other vendor's side of the interoperability tests, in Cyclone DDS's own C API.
//
//   cyclone_peer DOMAIN
//
// Echoes what it hears on rt/interop/TYPE_in to rt/interop/TYPE_out, for three types; the echo's
// frame_id tells that it was here. Publishes one reliable, transient-local image on
// rt/interop/latched. Requests more than a best-effort publisher offers on rt/interop/strict.
// Uses the action /interop/fibonacci, see cyclone_action.h.
// Prints a line per discovered endpoint of a topic or service below interop, as its discovery sees
// it:
//   endpoint WRITER|READER TOPIC TYPE RELIABILITY DURABILITY
// and ends when its standard input does.
#include <dds/dds.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "all_messages.h"
#include "cyclone_action.h"

#define ECHO_MARK "echoed by cyclone"

static void check(dds_return_t code, const char* what) {
  if (code < 0) {
    fprintf(stderr, "cyclone_peer: %s: %s\n", what, dds_strretcode(-code));
    exit(1);
  }
}

// The name under which ROS 2 knows a type on the wire differs from the one in the IDL file.
static dds_entity_t make_topic(dds_entity_t participant, dds_topic_descriptor_t descriptor,
                               const char* type, const char* topic) {
  descriptor.m_typename = type;
  const dds_entity_t made = dds_create_topic(participant, &descriptor, topic, NULL, NULL);
  check(made, topic);
  return made;
}

static dds_qos_t* make_qos(bool reliable, bool transient_local, int depth) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_SECS(1));
  dds_qset_durability(qos,
                      transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  return qos;
}

struct echo {
  dds_entity_t reader;
  dds_entity_t writer;
  // The frame_id of the type's header, to leave the mark in.
  char** (*frame_id)(void* message);
};

static char** image_frame(void* message) {
  return &((sensor_msgs_msg_Image*)message)->header.frame_id;
}
static char** odometry_frame(void* message) {
  return &((nav_msgs_msg_Odometry*)message)->header.frame_id;
}
static char** fused_frame(void* message) {
  return &((pipescout_msgs_msg_FusedOdometer*)message)->header.frame_id;
}

static void make_echo(struct echo* echo, dds_entity_t participant,
                      dds_topic_descriptor_t descriptor, const char* type, const char* name,
                      char** (*frame_id)(void*)) {
  char topic[64];
  dds_qos_t* qos = make_qos(true, false, 10);
  snprintf(topic, sizeof topic, "rt/interop/%s_in", name);
  echo->reader =
      dds_create_reader(participant, make_topic(participant, descriptor, type, topic), qos, NULL);
  check(echo->reader, topic);
  snprintf(topic, sizeof topic, "rt/interop/%s_out", name);
  echo->writer =
      dds_create_writer(participant, make_topic(participant, descriptor, type, topic), qos, NULL);
  check(echo->writer, topic);
  echo->frame_id = frame_id;
  dds_delete_qos(qos);
}

static void run_echo(const struct echo* echo) {
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(echo->reader, &sample, &info, 1, 1) > 0) {
    if (info.valid_data) {
      char** frame_id = echo->frame_id(sample);
      char* original = *frame_id;
      char mark[] = ECHO_MARK;
      *frame_id = mark;
      check(dds_write(echo->writer, sample), "echo");
      *frame_id = original;
    }
    check(dds_return_loan(echo->reader, &sample, 1), "return loan");
    sample = NULL;
  }
}

static void print_endpoints(dds_entity_t builtin_reader, const char* kind) {
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(builtin_reader, &sample, &info, 1, 1) > 0) {
    const dds_builtintopic_endpoint_t* endpoint = sample;
    if (info.valid_data && info.instance_state == DDS_ALIVE_INSTANCE_STATE &&
        strlen(endpoint->topic_name) > 2 &&
        strncmp(endpoint->topic_name + 2, "/interop/", 9) == 0) {
      dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
      dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
      dds_duration_t blocking = 0;
      dds_qget_reliability(endpoint->qos, &reliability, &blocking);
      dds_qget_durability(endpoint->qos, &durability);
      printf("endpoint %s %s %s %s %s\n", kind, endpoint->topic_name, endpoint->type_name,
             reliability == DDS_RELIABILITY_RELIABLE ? "reliable" : "best_effort",
             durability == DDS_DURABILITY_TRANSIENT_LOCAL ? "transient_local" : "volatile");
      fflush(stdout);
    }
    check(dds_return_loan(builtin_reader, &sample, 1), "return loan");
    sample = NULL;
  }
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: cyclone_peer DOMAIN\n");
    return 2;
  }
  const dds_entity_t participant =
      dds_create_participant((dds_domainid_t)strtoul(argv[1], NULL, 10), NULL, NULL);
  check(participant, "participant");

  struct echo echoes[3];
  make_echo(&echoes[0], participant, sensor_msgs_msg_Image_desc, "sensor_msgs::msg::dds_::Image_",
            "image", image_frame);
  make_echo(&echoes[1], participant, nav_msgs_msg_Odometry_desc, "nav_msgs::msg::dds_::Odometry_",
            "odometry", odometry_frame);
  make_echo(&echoes[2], participant, pipescout_msgs_msg_FusedOdometer_desc,
            "pipescout_msgs::msg::dds_::FusedOdometer_", "fused", fused_frame);

  dds_qos_t* latched_qos = make_qos(true, true, 1);
  const dds_entity_t latched =
      dds_create_writer(participant,
                        make_topic(participant, sensor_msgs_msg_Image_desc,
                                   "sensor_msgs::msg::dds_::Image_", "rt/interop/latched"),
                        latched_qos, NULL);
  check(latched, "latched writer");
  uint8_t pixels[] = {1, 2, 3, 4};
  char frame[] = "latched", encoding[] = "mono16";
  sensor_msgs_msg_Image image = {.header = {.stamp = {.sec = 7, .nanosec = 8}, .frame_id = frame},
                                 .height = 1,
                                 .width = 2,
                                 .encoding = encoding,
                                 .step = 4,
                                 .data = {._maximum = 4, ._length = 4, ._buffer = pixels}};
  check(dds_write(latched, &image), "latched write");
  dds_delete_qos(latched_qos);

  dds_qos_t* strict_qos = make_qos(true, true, 1);
  check(dds_create_reader(participant,
                          make_topic(participant, sensor_msgs_msg_Image_desc,
                                     "sensor_msgs::msg::dds_::Image_", "rt/interop/strict"),
                          strict_qos, NULL),
        "strict reader");
  dds_delete_qos(strict_qos);

  struct cyclone_action action;
  make_action(&action, participant);

  const dds_entity_t writers =
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL);
  const dds_entity_t readers =
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, NULL, NULL);
  check(writers, "publications");
  check(readers, "subscriptions");

  const dds_entity_t waitset = dds_create_waitset(participant);
  for (size_t i = 0; i < 3; ++i) {
    check(dds_waitset_attach(waitset, dds_create_readcondition(echoes[i].reader, DDS_ANY_STATE),
                             (dds_attach_t)i),
          "attach");
  }
  check(dds_waitset_attach(waitset, dds_create_readcondition(writers, DDS_ANY_STATE), 3), "attach");
  check(dds_waitset_attach(waitset, dds_create_readcondition(readers, DDS_ANY_STATE), 4), "attach");
  printf("ready\n");
  fflush(stdout);

  // The parent closes our standard input, or dies, to end us.
  struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
  while (poll(&input, 1, 0) == 0) {
    dds_attach_t triggered[5];
    dds_waitset_wait(waitset, triggered, 5, DDS_MSECS(100));
    for (size_t i = 0; i < 3; ++i) {
      run_echo(&echoes[i]);
    }
    run_action(&action);
    print_endpoints(writers, "WRITER");
    print_endpoints(readers, "READER");
  }
  check(dds_delete(participant), "delete");
  return 0;
}
