// The measuring peer on Cyclone DDS with its own plugins. Small samples share datagrams, as in
// ddsperf, which is Cyclone's fastest mode.
#include <stdio.h>
#include <stdlib.h>

#include <dds/dds.h>

#include "bench/participants.h"
#include "blob.h"

static const char loopback[] =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface address=\"127.0.0.1\" "
    "multicast=\"false\"/></Interfaces><AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><Peers><Peer address=\"127.0.0.1\"/></Peers>"
    "<ParticipantIndex>auto</ParticipantIndex><SPDPInterval>500ms</SPDPInterval></Discovery>"
    "</Domain></CycloneDDS>";

// For many processes: participants find each other by multicast, as stock Cyclone does, and with
// its own periods.
static const char multicast[] =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface address=\"%s\" "
    "multicast=\"true\"/></Interfaces></General></Domain></CycloneDDS>";

enum { MOST_LOANS = 256 };

struct cyclone {
  dds_entity_t writer, reader, waitset;
  void* loans[MOST_LOANS];
  dds_sample_info_t infos[MOST_LOANS];
  int32_t taken, next;
  struct bench_stack stack;
};

static uint32_t readers(void* self) {
  dds_publication_matched_status_t status;
  const struct cyclone* cyclone = self;
  if (dds_get_publication_matched_status(cyclone->writer, &status) != DDS_RETCODE_OK) return 0;
  return status.current_count;
}

static uint32_t writers(void* self) {
  dds_subscription_matched_status_t status;
  const struct cyclone* cyclone = self;
  if (dds_get_subscription_matched_status(cyclone->reader, &status) != DDS_RETCODE_OK) return 0;
  return status.current_count;
}

static bool write_blob(void* self, const struct bench_blob* blob) {
  const struct cyclone* cyclone = self;
  Blob sample = {.seq = blob->seq, .pad = blob->pad, .t_ns = blob->t_ns};
  sample.data._buffer = (uint8_t*)blob->data;
  sample.data._length = sample.data._maximum = blob->length;
  return dds_write(cyclone->writer, &sample) == DDS_RETCODE_OK;
}

static bool take_blob(void* self, struct bench_blob* blob) {
  struct cyclone* cyclone = self;
  for (;;) {
    if (cyclone->next == cyclone->taken) {
      if (cyclone->taken > 0) dds_return_loan(cyclone->reader, cyclone->loans, cyclone->taken);
      cyclone->loans[0] = NULL;
      cyclone->next = 0;
      cyclone->taken =
          dds_take(cyclone->reader, cyclone->loans, cyclone->infos, MOST_LOANS, MOST_LOANS);
      if (cyclone->taken <= 0) {
        cyclone->taken = 0;
        return false;
      }
    }
    const int32_t at = cyclone->next++;
    if (!cyclone->infos[at].valid_data) continue;
    const Blob* sample = cyclone->loans[at];
    *blob = (struct bench_blob){sample->seq, sample->pad, sample->t_ns, sample->data._buffer,
                                sample->data._length};
    return true;
  }
}

static void wait_for_data(void* self) {
  const struct cyclone* cyclone = self;
  dds_waitset_wait(cyclone->waitset, NULL, 0, DDS_MSECS(20));
}

static bool acknowledged(void* self) {
  const struct cyclone* cyclone = self;
  dds_write_flush(cyclone->writer);
  return dds_wait_for_acks(cyclone->writer, DDS_MSECS(10)) == DDS_RETCODE_OK;
}

static void on_data(dds_entity_t reader, void* self) {
  (void)reader;
  const struct cyclone* cyclone = self;
  bench_on_data(&cyclone->stack);
}

// ---- set-up

static void set_document(dds_qos_t* qos, const char* property, const char* folder,
                         const char* name) {
  char* uri = bench_document("file:", folder, name);
  if (uri != NULL) dds_qset_prop(qos, property, uri);
  free(uri);
}

static void set_security(dds_qos_t* qos, const char* folder) {
  static const char* const libraries[][2] = {
      {"dds.sec.auth.library.path", "dds_security_auth"},
      {"dds.sec.auth.library.init", "init_authentication"},
      {"dds.sec.auth.library.finalize", "finalize_authentication"},
      {"dds.sec.access.library.path", "dds_security_ac"},
      {"dds.sec.access.library.init", "init_access_control"},
      {"dds.sec.access.library.finalize", "finalize_access_control"},
      {"dds.sec.crypto.library.path", "dds_security_crypto"},
      {"dds.sec.crypto.library.init", "init_crypto"},
      {"dds.sec.crypto.library.finalize", "finalize_crypto"}};
  for (size_t i = 0; i < sizeof libraries / sizeof *libraries; ++i)
    dds_qset_prop(qos, libraries[i][0], libraries[i][1]);
  set_document(qos, "dds.sec.auth.identity_ca", folder, "identity_ca.pem");
  set_document(qos, "dds.sec.auth.identity_certificate", folder, "cert.pem");
  set_document(qos, "dds.sec.auth.private_key", folder, "key.pem");
  set_document(qos, "dds.sec.access.permissions_ca", folder, "permissions_ca.pem");
  set_document(qos, "dds.sec.access.governance", folder, "governance.p7s");
  set_document(qos, "dds.sec.access.permissions", folder, "permissions.p7s");
}

static dds_qos_t* endpoint_qos(const struct bench_options* options) {
  dds_qos_t* qos = dds_create_qos();
  if (options->best_effort) {
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    return qos;
  }
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  return qos;
}

static bool create_endpoints(dds_entity_t participant, const struct bench_options* options,
                             struct cyclone* cyclone) {
  const char* written = bench_written(options->role);
  const char* read = bench_read(options->role);
  dds_qos_t* qos = endpoint_qos(options);
  dds_listener_t* listener = dds_create_listener(cyclone);
  if (bench_listens(options)) dds_lset_data_available(listener, on_data);
  if (written != NULL) {
    const dds_entity_t topic = dds_create_topic(participant, &Blob_desc, written, NULL, NULL);
    cyclone->writer = dds_create_writer(participant, topic, qos, NULL);
  }
  if (read != NULL) {
    const dds_entity_t topic = dds_create_topic(participant, &Blob_desc, read, NULL, NULL);
    cyclone->reader = dds_create_reader(participant, topic, qos, listener);
    cyclone->waitset = dds_create_waitset(participant);
    dds_set_status_mask(cyclone->reader, DDS_DATA_AVAILABLE_STATUS);
    if (!bench_listens(options)) dds_waitset_attach(cyclone->waitset, cyclone->reader, 0);
  }
  dds_delete_listener(listener);
  dds_delete_qos(qos);
  return cyclone->writer >= 0 && cyclone->reader >= 0;
}

static int run(const struct bench_options* options) {
  char shared[sizeof multicast + 64];
  snprintf(shared, sizeof shared, multicast, options->address);
  if (dds_create_domain(options->domain, bench_is_local(options) ? loopback : shared) < 0)
    return bench_refused("domain", "Cyclone DDS does not take its configuration");
  if (options->role == BENCH_TPUT_PUB) dds_write_set_batch(true);
  dds_qos_t* qos = dds_create_qos();
  if (options->security != NULL) set_security(qos, options->security);
  const dds_entity_t participant = dds_create_participant(options->domain, qos, NULL);
  dds_delete_qos(qos);
  if (participant < 0) return bench_refused("participant", dds_strretcode(-participant));
  static struct cyclone cyclone;
  cyclone.stack = (struct bench_stack){&cyclone,  readers,       writers,     write_blob,
                                       take_blob, wait_for_data, acknowledged};
  if (!create_endpoints(participant, options, &cyclone))
    return bench_refused("endpoint", "Cyclone DDS refused a topic, a writer or a reader");
  return bench_run(options, &cyclone.stack);
}

int main(int argc, char** argv) {
  struct bench_options options;
  bench_parse(argc, argv, &options);
  const int code = run(&options);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return code;
}
