#include "tests/unit/rtps_idl/cyclone_serializer.h"

#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/ddsi_serdata.h>

#include "rich.h"

static const char loopback[] =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces>"
    "<NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>";

static const dds_topic_descriptor_t* const descriptors[] = {
    &rich_Everything_desc, &rich_Primitives_desc, &rich_Collections_desc, &rich_EnumKey_desc,
    &rich_ArrayKey_desc,   &rich_PointKey_desc,   &rich_Extended_desc,    &rich_inner_Id_desc,
    &rich_Nested_desc,     &rich_MixedKey_desc,   &rich_Frame_desc};
enum { descriptor_count = sizeof descriptors / sizeof descriptors[0] };

struct cyclone_type {
  const dds_topic_descriptor_t* descriptor;
  struct ddsi_serdata* sample;  // any sample, because it knows its type
};

static dds_entity_t participant(void) {
  static dds_entity_t made = 0;
  const dds_domainid_t domain = 188;
  if (made == 0 && dds_create_domain(domain, loopback) >= 0)
    made = dds_create_participant(domain, NULL, NULL);
  return made;
}

// Writes a zero sample and reads it within the participant. The sample knows the type that
// serializes it.
static struct ddsi_serdata* any_sample(const dds_topic_descriptor_t* descriptor, bool xcdr2) {
  dds_qos_t* qos = dds_create_qos();
  const dds_data_representation_id_t id =
      xcdr2 ? DDS_DATA_REPRESENTATION_XCDR2 : DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos, 1, &id);
  char name[128];
  snprintf(name, sizeof name, "%s%d", strrchr(descriptor->m_typename, ':') + 1, xcdr2);
  const dds_entity_t topic = dds_create_topic(participant(), descriptor, name, qos, NULL);
  const dds_entity_t reader = dds_create_reader(participant(), topic, qos, NULL);
  const dds_entity_t writer = dds_create_writer(participant(), topic, qos, NULL);
  dds_delete_qos(qos);
  void* zero = calloc(1, descriptor->m_size);
  struct ddsi_serdata* out = NULL;
  dds_sample_info_t info;
  if (writer > 0 && dds_write(writer, zero) == 0)
    dds_takecdr(reader, &out, 1, &info, DDS_ANY_STATE);
  free(zero);
  return out;
}

const struct cyclone_type* cyclone_type(const char* name, bool xcdr2) {
  static struct cyclone_type types[descriptor_count][2];  // [xcdr2]; each is made at its first use
  for (size_t i = 0; i < descriptor_count; ++i) {
    if (strcmp(descriptors[i]->m_typename, name) != 0) continue;
    struct cyclone_type* type = &types[i][xcdr2];
    type->descriptor = descriptors[i];
    if (type->sample == NULL) type->sample = any_sample(descriptors[i], xcdr2);
    return type->sample != NULL ? type : NULL;
  }
  return NULL;
}

size_t cyclone_again(const struct cyclone_type* type, const uint8_t* octets, size_t size,
                     uint8_t* out, size_t most, uint8_t key_hash[16]) {
  const ddsrt_iovec_t vector = {(void*)octets, size};
  struct ddsi_serdata* read =
      ddsi_serdata_from_ser_iov(type->sample->type, SDK_DATA, 1, &vector, size);
  if (read == NULL) return 0;
  void* sample = calloc(1, type->descriptor->m_size);
  size_t written = 0;
  if (ddsi_serdata_to_sample(read, sample, NULL, NULL)) {
    struct ddsi_serdata* again = ddsi_serdata_from_sample(type->sample->type, SDK_DATA, sample);
    if (ddsi_serdata_size(again) <= most) {
      written = ddsi_serdata_size(again);
      ddsi_serdata_to_ser(again, 0, written, out);
      struct ddsi_keyhash hash;
      ddsi_serdata_get_keyhash(again, &hash, false);
      memcpy(key_hash, hash.value, 16);
    }
    ddsi_serdata_unref(again);
  }
  dds_sample_free(sample, type->descriptor, DDS_FREE_ALL);
  ddsi_serdata_unref(read);
  return written;
}
