// Test peer on Cyclone DDS. It sets the participant properties that rmw_cyclonedds sets, so it also
// stands for a ROS 2 process. It is secured by whichever libraries the loader finds under the stock
// names.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>

#include "interop/peers/peer.h"
#include "shape.h"

// One interface, unicast, quick discovery, and what PEER_CYCLONEDDS_SETTINGS adds. CYCLONEDDS_URI,
// if set, replaces all of it.
static const char configuration[] =
    "<CycloneDDS><Domain Id=\"any\">"
    "<General><Interfaces><NetworkInterface address=\"%s\" multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><Peers><Peer address=\"%s\"/></Peers>"
    "<ParticipantIndex>auto</ParticipantIndex><SPDPInterval>500ms</SPDPInterval>"
    "<LeaseDuration>%us</LeaseDuration></Discovery>%s"
    "</Domain></CycloneDDS>";

// A second participant of the process, which leaves before the first one does.
struct companion {
  dds_entity_t participant;  // 0 if there is none, or if it has left
  dds_entity_t reader;
  uint32_t samples, stays_for;
};

// Further readers of the participant, which it deletes after some seconds.
struct passing {
  dds_entity_t reader[PEER_MAX_PASSING];
  uint32_t count;
  dds_time_t until;
};

// The time at which a further topic, writer and reader are made, as an application may do at any
// time.
struct late {
  dds_entity_t participant;
  dds_time_t at;  // 0 if nothing is to be made any more
};

struct cyclone {
  dds_entity_t endpoint;  // the writer or the reader
  interop_Shape* loan;    // the sample handed out by take
  struct companion companion;
  struct passing passing;
  struct late late;
};

static uint32_t matched_readers(void* self) {
  dds_publication_matched_status_t status;
  const struct cyclone* cyclone = self;
  if (dds_get_publication_matched_status(cyclone->endpoint, &status) != DDS_RETCODE_OK) return 0;
  return status.current_count;
}

static uint32_t matched_writers(void* self) {
  dds_subscription_matched_status_t status;
  const struct cyclone* cyclone = self;
  if (dds_get_subscription_matched_status(cyclone->endpoint, &status) != DDS_RETCODE_OK) return 0;
  return status.current_count;
}

static bool write_sample(void* self, int32_t index, const uint8_t* payload, uint32_t length) {
  const struct cyclone* cyclone = self;
  char color[] = "BLUE";
  interop_Shape shape = {.color = color, .x = index, .y = 2 * index, .shapesize = 30};
  shape.payload._buffer = (uint8_t*)payload;
  shape.payload._length = shape.payload._maximum = length;
  return dds_write(cyclone->endpoint, &shape) == DDS_RETCODE_OK;
}

static bool acknowledged(void* self) {
  const struct cyclone* cyclone = self;
  return dds_wait_for_acks(cyclone->endpoint, DDS_MSECS(5)) == DDS_RETCODE_OK;
}

static void return_loan(struct cyclone* cyclone) {
  void* raw = cyclone->loan;
  if (raw != NULL) dds_return_loan(cyclone->endpoint, &raw, 1);
  cyclone->loan = NULL;
}

static void watch_companion(struct companion* companion) {
  if (companion->participant == 0) return;
  void* raw = NULL;
  dds_sample_info_t info;
  while (dds_take(companion->reader, &raw, &info, 1, 1) == 1) {
    if (info.valid_data) {
      peer_say("companion hears %d", ((const interop_Shape*)raw)->x);
      ++companion->samples;
    }
    dds_return_loan(companion->reader, &raw, 1);
    raw = NULL;
  }
  if (companion->samples < companion->stays_for) return;
  dds_delete(companion->participant);
  companion->participant = 0;
  peer_say("companion left");
}

static void watch_passing(struct passing* passing) {
  if (passing->count == 0 || dds_time() < passing->until) return;
  while (passing->count > 0) dds_delete(passing->reader[--passing->count]);
  peer_say("the passing readers are deleted");
}

static const char* created(dds_entity_t entity) {
  return entity >= 0 ? "created" : dds_strretcode(-entity);
}

static void make_further(const char* whose, dds_entity_t participant, dds_entity_t endpoint) {
  const dds_entity_t topic = dds_get_topic(endpoint);
  const dds_entity_t further =
      dds_create_topic(participant, &interop_Shape_desc, "Further", NULL, NULL);
  const dds_entity_t writer = dds_create_writer(participant, topic, NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, topic, NULL, NULL);
  peer_say("%s: topic %s, writer %s, reader %s", whose, created(further), created(writer),
           created(reader));
}

static void watch_late(struct cyclone* cyclone) {
  if (cyclone->late.at == 0 || dds_time() < cyclone->late.at) return;
  cyclone->late.at = 0;
  if (cyclone->companion.participant != 0)
    make_further("late companion", cyclone->companion.participant, cyclone->companion.reader);
  make_further("late", cyclone->late.participant, cyclone->endpoint);
}

static bool take_sample(void* self, struct peer_sample* sample) {
  struct cyclone* cyclone = self;
  watch_companion(&cyclone->companion);
  watch_passing(&cyclone->passing);
  watch_late(cyclone);
  return_loan(cyclone);
  void* raw = NULL;
  dds_sample_info_t info;
  while (dds_take(cyclone->endpoint, &raw, &info, 1, 1) == 1) {
    cyclone->loan = raw;
    if (info.valid_data) {
      const interop_Shape* shape = raw;
      *sample = (struct peer_sample){shape->color, shape->x, shape->payload._buffer,
                                     shape->payload._length};
      return true;
    }
    return_loan(cyclone);
    raw = NULL;
  }
  return false;
}

// ---- set-up

static void set_document(dds_qos_t* qos, const char* property, const char* value) {
  char* uri = value == NULL ? NULL : peer_uri("file:", value);
  if (uri != NULL) dds_qset_prop(qos, property, uri);
  free(uri);
}

static void set_library(dds_qos_t* qos, const char* what, const char* library, const char* entry) {
  const char* const names[] = {"path", "init", "finalize"};
  for (int i = 0; i < 3; ++i) {
    char property[64], value[64];
    snprintf(property, sizeof property, "dds.sec.%s.library.%s", what, names[i]);
    snprintf(value, sizeof value, "%s_%s", names[i], entry);
    dds_qset_prop(qos, property, i == 0 ? library : value);
  }
}

static void set_security(dds_qos_t* qos, const struct peer_options* options) {
  const char* const* security = options->security;
  set_library(qos, "auth", options->plugin_auth, "authentication");
  set_library(qos, "access", options->plugin_ac, "access_control");
  set_library(qos, "crypto", options->plugin_crypto, "crypto");
  set_document(qos, "dds.sec.auth.identity_ca", security[PEER_IDENTITY_CA]);
  set_document(qos, "dds.sec.auth.identity_certificate", security[PEER_IDENTITY_CERTIFICATE]);
  set_document(qos, "dds.sec.auth.private_key", security[PEER_PRIVATE_KEY]);
  set_document(qos, "dds.sec.access.permissions_ca", security[PEER_PERMISSIONS_CA]);
  set_document(qos, "dds.sec.access.governance", security[PEER_GOVERNANCE]);
  set_document(qos, "dds.sec.access.permissions", security[PEER_PERMISSIONS]);
  set_document(qos, "org.eclipse.cyclonedds.sec.auth.crl", security[PEER_CRL]);
  if (security[PEER_PASSWORD] != NULL)
    dds_qset_prop(qos, "dds.sec.auth.password", security[PEER_PASSWORD]);
}

static dds_entity_t create_domain(const struct peer_options* options) {
  if (getenv("CYCLONEDDS_URI") != NULL) return 0;
  const char* const settings = getenv("PEER_CYCLONEDDS_SETTINGS");
  char text[2048];
  snprintf(text, sizeof text, configuration, options->address, options->peer,
           options->lease > 0 ? options->lease : 10, settings != NULL ? settings : "");
  return dds_create_domain(options->domain, text);
}

static void set_user_data(dds_qos_t* qos, const struct peer_options* options) {
  if (options->user_data == 0) return;
  void* const octets = calloc(options->user_data, 1);
  if (octets != NULL) dds_qset_userdata(qos, octets, options->user_data);
  free(octets);
}

static dds_entity_t create_participant(const struct peer_options* options) {
  dds_qos_t* qos = dds_create_qos();
  if (!options->plain) set_security(qos, options);
  for (size_t i = 0; i < options->properties; ++i)
    dds_qset_prop(qos, options->property_name[i], options->property_value[i]);
  set_user_data(qos, options);
  const dds_entity_t participant = dds_create_participant(options->domain, qos, NULL);
  dds_delete_qos(qos);
  return participant;
}

static dds_entity_t create_group(dds_entity_t participant, const struct peer_options* options) {
  dds_qos_t* qos = dds_create_qos();
  if (options->partition != NULL) dds_qset_partition1(qos, options->partition);
  const dds_entity_t group = options->publish ? dds_create_publisher(participant, qos, NULL)
                                              : dds_create_subscriber(participant, qos, NULL);
  dds_delete_qos(qos);
  return group;
}

static dds_entity_t create_endpoint(dds_entity_t group, dds_entity_t topic,
                                    const struct peer_options* options) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(
      qos, options->is_volatile ? DDS_DURABILITY_VOLATILE : DDS_DURABILITY_TRANSIENT_LOCAL);
  const bool all = options->keep_last == 0;
  const dds_history_kind_t kind = all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST;
  const int32_t depth = all ? 0 : (int32_t)options->keep_last;
  dds_qset_history(qos, kind, depth);
  if (options->publish) dds_qset_durability_service(qos, 0, kind, depth, -1, -1, -1);
  // Cyclone passes the key size to the cryptography plugin with each endpoint's properties.
  if (!options->plain && options->security[PEER_KEYSIZE] != NULL)
    dds_qset_prop(qos, "dds.sec.crypto.keysize", options->security[PEER_KEYSIZE]);
  if (!options->plain && options->security[PEER_CIPHER] != NULL)
    dds_qset_prop(qos, "dds.sec.crypto.symmetric_cipher_algorithm", options->security[PEER_CIPHER]);
  set_user_data(qos, options);
  const dds_entity_t endpoint = options->publish ? dds_create_writer(group, topic, qos, NULL)
                                                 : dds_create_reader(group, topic, qos, NULL);
  dds_delete_qos(qos);
  return endpoint;
}

// Creates further readers beside the endpoint. peer_refused reports what could not be made.
static int create_passing(dds_entity_t reader, const struct peer_options* options,
                          struct passing* passing) {
  const dds_entity_t group = dds_get_parent(reader), topic = dds_get_topic(reader);
  for (; passing->count < options->passing; ++passing->count) {
    const dds_entity_t further = create_endpoint(group, topic, options);
    if (further < 0) return peer_refused("passing reader", dds_strretcode(-further));
    passing->reader[passing->count] = further;
  }
  passing->until = dds_time() + DDS_SECS(PEER_PASSING_SECONDS);
  return 0;
}

// Creates an endpoint that is not used, in a partition of its own.
static dds_entity_t create_decoy(dds_entity_t participant, dds_entity_t topic,
                                 const struct peer_options* options) {
  if (options->decoy == NULL) return 0;
  struct peer_options other = *options;
  other.partition = options->decoy;
  const dds_entity_t group = create_group(participant, &other);
  return group < 0 ? group : create_endpoint(group, topic, &other);
}

// Returns the endpoint of a participant that it also makes. peer_refused reports what could not be
// made.
static dds_entity_t join(const struct peer_options* options, dds_entity_t* participant) {
  *participant = create_participant(options);
  if (*participant < 0) return -peer_refused("participant", dds_strretcode(-*participant));
  const dds_entity_t topic =
      dds_create_topic(*participant, &interop_Shape_desc, options->topic, NULL, NULL);
  if (topic < 0) return -peer_refused("topic", dds_strretcode(-topic));
  if (create_decoy(*participant, topic, options) < 0) return -peer_refused("decoy", "an error");
  const dds_entity_t group = create_group(*participant, options);
  if (group < 0) return -peer_refused("publisher or subscriber", dds_strretcode(-group));
  // With large announcements there are two endpoints. The later one shows that the first one, which
  // is not used, has not delayed it.
  if (options->user_data > 0 && create_endpoint(group, topic, options) < 0)
    return -peer_refused("endpoint", "the first one");
  const dds_entity_t endpoint = create_endpoint(group, topic, options);
  if (endpoint < 0) return -peer_refused("endpoint", dds_strretcode(-endpoint));
  return endpoint;
}

static int join_companion(const struct peer_options* options, struct companion* companion) {
  struct peer_options own = *options;
  own.publish = false;
  own.security[PEER_CRL] = NULL;
  own.security[PEER_IDENTITY_CERTIFICATE] = strtok(options->companion, ",");
  own.security[PEER_PRIVATE_KEY] = strtok(NULL, ",");
  own.security[PEER_PERMISSIONS] = strtok(NULL, ",");
  const char* const samples = strtok(NULL, ",");
  if (samples == NULL) return peer_refused("companion", "not four words");
  companion->stays_for = (uint32_t)strtoul(samples, NULL, 10);
  companion->reader = join(&own, &companion->participant);
  return companion->reader < 0 ? -companion->reader : 0;
}

static int run(const struct peer_options* options) {
  const dds_entity_t domain = create_domain(options);
  if (domain < 0) return peer_refused("domain", dds_strretcode(-domain));
  struct cyclone cyclone = {0};
  if (options->companion != NULL) {
    const int refused = join_companion(options, &cyclone.companion);
    if (refused != 0) return refused;
  }
  dds_entity_t participant;
  cyclone.endpoint = join(options, &participant);
  if (cyclone.endpoint < 0) return -cyclone.endpoint;
  const int refused = create_passing(cyclone.endpoint, options, &cyclone.passing);
  if (refused != 0) return refused;
  if (options->late > 0)
    cyclone.late = (struct late){participant, dds_time() + DDS_SECS(options->late)};
  const struct peer_stack stack = {&cyclone, options->publish ? matched_readers : matched_writers,
                                   write_sample, acknowledged, take_sample};
  const int status = peer_run(options, &stack);
  return_loan(&cyclone);
  return status;
}

int main(int argc, char** argv) {
  struct peer_options options;
  peer_parse(argc, argv, &options);
  const int status = run(&options);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return status;
}
