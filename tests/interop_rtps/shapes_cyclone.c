// A shapes program on Cyclone DDS in its default configuration: -P|-S DOMAIN TOPIC [all|more]. With
// `all` the writer and the reader keep all samples. With `more` they do, too, and there is a second
// topic, TOPIC1, whose writer or reader is made as soon as the permissions allow it.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>

#include "shapes_type.h"

typedef struct {
  char topic[64];
  dds_entity_t entity;  // 0: not made yet
} Endpoint;

// Does nothing if the permissions do not allow the endpoint.
static void make(Endpoint* endpoint, dds_entity_t participant, const dds_qos_t* qos, bool writes) {
  const dds_entity_t topic =
      dds_create_topic(participant, &ShapeType_desc, endpoint->topic, NULL, NULL);
  if (topic < 0) return;
  const dds_entity_t entity = writes ? dds_create_writer(participant, topic, qos, NULL)
                                     : dds_create_reader(participant, topic, qos, NULL);
  if (entity > 0)
    endpoint->entity = entity;
  else
    dds_delete(topic);
}

static void print_samples(const Endpoint* endpoint) {
  void* raw = NULL;
  dds_sample_info_t info;
  while (dds_take(endpoint->entity, &raw, &info, 1, 1) == 1) {
    const ShapeType* s = raw;
    if (info.valid_data)
      printf("%-10s %-10s %03d %03d [%d]\n", endpoint->topic, s->color, s->x, s->y, s->shapesize);
    // The end of an instance may come together with its last sample.
    if (info.instance_state != DDS_IST_ALIVE)
      printf("%-10s %-10s %s\n", endpoint->topic, s->color,
             info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED ? "disposed" : "no writers");
    dds_return_loan(endpoint->entity, &raw, 1);
    raw = NULL;
  }
}

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) return 1;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const bool writes = strcmp(argv[1], "-P") == 0, has_more = argc == 5 && !strcmp(argv[4], "more");
  const dds_entity_t participant =
      dds_create_participant((dds_domainid_t)atoi(argv[2]), NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  if (argc == 5) dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  Endpoint endpoints[2] = {0};
  snprintf(endpoints[0].topic, sizeof endpoints[0].topic, "%s", argv[3]);
  snprintf(endpoints[1].topic, sizeof endpoints[1].topic, "%s1", argv[3]);
  ShapeType shape = {"GREEN", 7, 12, 30};
  for (;; ++shape.shapesize, dds_sleepfor(writes ? DDS_MSECS(33) : DDS_MSECS(50))) {
    for (int i = 0; i < (has_more ? 2 : 1); ++i) {
      if (endpoints[i].entity == 0 && shape.shapesize % 10 == 0)
        make(&endpoints[i], participant, qos, writes);
      if (endpoints[i].entity == 0) continue;
      if (writes)
        dds_write(endpoints[i].entity, &shape);
      else
        print_samples(&endpoints[i]);
    }
  }
}
