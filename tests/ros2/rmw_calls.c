// Makes the calls that rmw_cyclonedds_cpp makes for a context and a node, in its order, on Cyclone
// DDS alone: a participant with the security properties in its QoS, readers of three builtin
// topics, then the topics and endpoints of a node.
// Usage: rmw_calls ENCLAVE_FOLDER NODE [TOPIC [publish|subscribe]]
// TOPIC is written and read as well, as rt/TOPIC, or only one of the two: "publish" writes samples,
// and "subscribe" prints "heard" when one arrives.
// It prints "created", then "met" once a builtin reader shows another participant, and ends with
// the end of standard input. If a call fails, its name is printed and the exit status is 1.
#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <dds/dds.h>

#include "shape.h"

enum { kPatience = 20000, kLook = 20 };  // milliseconds

static void say(const char* line) {
  puts(line);
  fflush(stdout);
}

static dds_entity_t must(dds_entity_t entity, const char* call, const char* name) {
  if (entity >= 0) return entity;
  fprintf(stdout, "failed: %s %s: %s\n", call, name, dds_strretcode(-entity));
  fflush(stdout);
  exit(1);
}

static void add(dds_qos_t* qos, const char* property, const char* format, ...) {
  char value[4096];
  va_list values;
  va_start(values, format);
  vsnprintf(value, sizeof value, format, values);
  va_end(values);
  dds_qset_prop(qos, property, value);
}

// The revocation list is named only when its file exists, as rmw_dds_common does.
static dds_entity_t secured_participant(const char* enclave) {
  dds_qos_t* qos = dds_create_qos();
  char list[4096];
  snprintf(list, sizeof list, "%s/crl.pem", enclave);
  add(qos, "dds.sec.auth.identity_ca", "file:%s/identity_ca.cert.pem", enclave);
  add(qos, "dds.sec.auth.identity_certificate", "file:%s/cert.pem", enclave);
  add(qos, "dds.sec.auth.private_key", "file:%s/key.pem", enclave);
  add(qos, "dds.sec.access.permissions_ca", "file:%s/permissions_ca.cert.pem", enclave);
  add(qos, "dds.sec.access.governance", "file:%s/governance.p7s", enclave);
  add(qos, "dds.sec.access.permissions", "file:%s/permissions.p7s", enclave);
  if (access(list, F_OK) == 0) add(qos, "org.eclipse.cyclonedds.sec.auth.crl", "file:%s", list);
  static const char* const libraries[3][4] = {
      {"auth", "dds_security_auth", "init_authentication", "finalize_authentication"},
      {"crypto", "dds_security_crypto", "init_crypto", "finalize_crypto"},
      {"access", "dds_security_ac", "init_access_control", "finalize_access_control"}};
  for (int i = 0; i < 3; ++i) {
    static const char* const kinds[3] = {"path", "init", "finalize"};
    for (int kind = 0; kind < 3; ++kind) {
      char property[64];
      snprintf(property, sizeof property, "dds.sec.%s.library.%s", libraries[i][0], kinds[kind]);
      dds_qset_prop(qos, property, libraries[i][kind + 1]);
    }
  }
  const dds_entity_t participant =
      must(dds_create_participant(DDS_DOMAIN_DEFAULT, qos, NULL), "dds_create_participant", "");
  dds_delete_qos(qos);
  return participant;
}

struct node {
  dds_entity_t participant, publisher, subscriber;
};

static dds_entity_t topic_of(const struct node* node, const char* name) {
  return must(dds_create_topic(node->participant, &interop_Shape_desc, name, NULL, NULL),
              "dds_create_topic", name);
}
static dds_entity_t writes(const struct node* node, const char* name) {
  return must(dds_create_writer(node->publisher, topic_of(node, name), NULL, NULL),
              "dds_create_writer", name);
}
static dds_entity_t reads(const struct node* node, const char* name) {
  return must(dds_create_reader(node->subscriber, topic_of(node, name), NULL, NULL),
              "dds_create_reader", name);
}

// A service is a topic for requests and one for replies.
static void serves(const struct node* node, const char* node_name, const char* service) {
  char name[512];
  snprintf(name, sizeof name, "rq/%s/%sRequest", node_name, service);
  reads(node, name);
  snprintf(name, sizeof name, "rr/%s/%sReply", node_name, service);
  writes(node, name);
}

static void create_node(const struct node* node, const char* name) {
  static const char* const services[] = {"get_parameters",      "get_parameter_types",
                                         "set_parameters",      "set_parameters_atomically",
                                         "describe_parameters", "list_parameters"};
  writes(node, "rt/rosout");
  for (size_t i = 0; i < sizeof services / sizeof *services; ++i) serves(node, name, services[i]);
  writes(node, "rt/parameter_events");
  reads(node, "rt/parameter_events");
}

// Returns how many participants the builtin reader shows, including its own.
static int32_t participants_seen(dds_entity_t reader) {
  void* samples[16] = {NULL};
  dds_sample_info_t infos[16];
  const dds_return_t count = dds_read(reader, samples, infos, 16, 16);
  if (count > 0) dds_return_loan(reader, samples, count);
  return count;
}

static bool has_sample(dds_entity_t reader) {
  void* samples[1] = {NULL};
  dds_sample_info_t info;
  const dds_return_t count = dds_take(reader, samples, &info, 1, 1);
  if (count > 0) dds_return_loan(reader, samples, count);
  return count > 0 && info.valid_data;
}

struct endpoints {
  dds_entity_t writer, reader;  // 0 if there is none
};

// Creates the endpoints that write samples and wait for one. A node that does both has none.
static struct endpoints create_own_topic(const struct node* node, int argc, char** argv) {
  struct endpoints used = {0, 0};
  if (argc < 4) return used;
  char name[512];
  snprintf(name, sizeof name, "rt/%s", argv[3]);
  const char* const direction = argc > 4 ? argv[4] : "";
  if (strcmp(direction, "subscribe") != 0) used.writer = writes(node, name);
  if (strcmp(direction, "publish") != 0) used.reader = reads(node, name);
  return argc > 4 ? used : (struct endpoints){0, 0};
}

static void run(dds_entity_t participants, struct endpoints own) {
  struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
  bool met = false, heard = false;
  for (int waited = 0; waited < kPatience && poll(&input, 1, kLook) == 0; waited += kLook) {
    if (!met && participants_seen(participants) > 1) {
      met = true;
      say("met");
    }
    const interop_Shape sample = {.color = "BLUE", .x = waited};
    if (own.writer != 0) must(dds_write(own.writer, &sample), "dds_write", "");
    if (own.reader != 0 && !heard && has_sample(own.reader)) {
      heard = true;
      say("heard");
    }
  }
}

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  struct node node = {.participant = secured_participant(argv[1])};
  const dds_entity_t participants =
      must(dds_create_reader(node.participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL),
           "dds_create_reader", "DCPSParticipant");
  must(dds_create_reader(node.participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, NULL, NULL),
       "dds_create_reader", "DCPSSubscription");
  must(dds_create_reader(node.participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL),
       "dds_create_reader", "DCPSPublication");
  node.publisher =
      must(dds_create_publisher(node.participant, NULL, NULL), "dds_create_publisher", "");
  node.subscriber =
      must(dds_create_subscriber(node.participant, NULL, NULL), "dds_create_subscriber", "");
  writes(&node, "ros_discovery_info");
  reads(&node, "ros_discovery_info");
  create_node(&node, argv[2]);
  const struct endpoints own = create_own_topic(&node, argc, argv);
  say("created");
  run(participants, own);
  must(dds_delete(node.participant), "dds_delete", "");
  return 0;
}
