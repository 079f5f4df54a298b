// A shapes program on Cyclone DDS in its default configuration: -P|-S DOMAIN TOPIC [all]. With
// `all` the writer and the reader keep all samples.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>

#include "shapes_type.h"

static void publish(dds_entity_t writer) {
  ShapeType shape = {"GREEN", 7, 12, 30};
  for (;; ++shape.shapesize, dds_sleepfor(DDS_MSECS(33))) dds_write(writer, &shape);
}

static void subscribe(dds_entity_t reader, const char* topic) {
  for (;; dds_sleepfor(DDS_MSECS(50))) {
    void* raw = NULL;
    dds_sample_info_t info;
    while (dds_take(reader, &raw, &info, 1, 1) == 1) {
      const ShapeType* s = raw;
      if (info.valid_data)
        printf("%-10s %-10s %03d %03d [%d]\n", topic, s->color, s->x, s->y, s->shapesize);
      // The end of an instance may come together with its last sample.
      if (info.instance_state != DDS_IST_ALIVE)
        printf("%-10s %-10s %s\n", topic, s->color,
               info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED ? "disposed" : "no writers");
      dds_return_loan(reader, &raw, 1);
      raw = NULL;
    }
  }
}

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) return 1;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const dds_entity_t participant =
      dds_create_participant((dds_domainid_t)atoi(argv[2]), NULL, NULL);
  const dds_entity_t topic = dds_create_topic(participant, &ShapeType_desc, argv[3], NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  if (argc == 5) dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  if (strcmp(argv[1], "-P") == 0)
    publish(dds_create_writer(participant, topic, qos, NULL));
  else
    subscribe(dds_create_reader(participant, topic, qos, NULL), argv[3]);
  return 0;
}
