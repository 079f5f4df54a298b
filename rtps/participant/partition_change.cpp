#include "rtps/participant/partition_change.hpp"

namespace ddssec::rtps {

bool leaves_readers(const ParticipantCore& core, const LocalWriter* writer, const Qos& qos) {
  if (writer == nullptr || !core.security || writer->data.qos.partition == qos.partition)
    return false;
  const auto* attributes = core.security->keyring().attributes(writer->data.guid.entity);
  return attributes != nullptr && attributes->topic.is_read_protected &&
         (attributes->is_payload_protected() || attributes->is_submessage_protected());
}

Status check_partition_change(const ParticipantCore& core, const LocalEndpoints& locals,
                              const EntityId& endpoint, const Qos& qos) {
  const auto* data = locals.find(endpoint);
  if (!core.security || data == nullptr || data->qos.partition == qos.partition) return {};
  DDSSEC_RETURN_IF_ERROR(core.security->admission().check_partitions(endpoint, qos.partition));
  const auto* writer = locals.find_writer(endpoint);
  if (!leaves_readers(core, writer, qos) || core.attributes().is_key_revision_enabled) return {};
  return fail(Code::rtps_immutable_policy,
              {.document = "QoS of the publisher of a writer on topic " + writer->data.topic_name,
               .field = "PARTITION",
               .expected = "enable_key_revision in the governance, since readers of the former "
                           "partitions have the writer's keys",
               .found = "none",
               .hint = "create a new publisher and writer for the other partitions, or enable key "
                       "revision"});
}

}  // namespace ddssec::rtps
