#include "rtps/participant/endpoint_compatibility.hpp"

#include <fmt/format.h>

#include "rtps/types/type_consistency.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

// The refusal names the reader's policy, because it is the reason. XTypes calls this an
// inconsistent topic.
std::optional<QosMismatch> refusal(const TypeJudgement& types, const EndpointData& writer,
                                   const EndpointData& reader) {
  return QosMismatch{
      QosPolicyId::type_consistency_enforcement, "TYPE_CONSISTENCY_ENFORCEMENT",
      describe_type(writer.type_name, writer.type),
      fmt::format("{} for {}", types.refused_by, describe_type(reader.type_name, reader.type))};
}

}  // namespace

bool is_compatible(const EndpointData& local, const EndpointData& remote,
                   EndpointListener& listener, ParticipantCore& core) {
  if (local.topic_name != remote.topic_name) return false;
  const auto refuse = [&](Code code, std::string field, std::string ours, std::string theirs,
                          std::string hint = {}) {
    core.raise_about(Error(code, {.document = "topic " + remote.topic_name,
                                  .field = std::move(field),
                                  .expected = std::move(ours),
                                  .found = std::move(theirs),
                                  .hint = std::move(hint)}),
                     remote);
    return false;
  };
  const bool keyed = has_key(local.guid.entity);
  if (local.type_name != remote.type_name || keyed != has_key(remote.guid.entity))
    listener.on_inconsistent_topic(remote);
  if (local.type_name != remote.type_name)
    return refuse(Code::rtps_type_mismatch, "type", local.type_name, remote.type_name);
  if (keyed != has_key(remote.guid.entity))
    return refuse(Code::rtps_type_mismatch, "type", keyed ? "with key" : "without key",
                  keyed ? "without key" : "with key");
  const bool writes = is_writer(local.guid.entity);
  const auto& writer = writes ? local : remote;
  const auto& reader = writes ? remote : local;
  const auto types = judge_types(writer.type, reader.type, reader.qos.type_consistency);
  if (!types.fits()) listener.on_inconsistent_topic(remote);
  if (!types.fits() && types.refused_by.empty())
    return refuse(Code::rtps_type_mismatch, "type", describe_type(local.type_name, local.type),
                  describe_type(remote.type_name, remote.type));
  const auto why = types.fits() ? mismatch(writer.qos, reader.qos) : refusal(types, writer, reader);
  if (!why) return true;
  if (why->id != QosPolicyId::partition) listener.on_incompatible_qos(remote.guid, *why);
  return refuse(Code::rtps_qos_incompatible, why->policy, "requested " + why->requested,
                "offered " + why->offered, remedy(*why));
}

}  // namespace ddssec::rtps
