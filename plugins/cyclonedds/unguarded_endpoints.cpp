#include "plugins/cyclonedds/unguarded_endpoints.hpp"

#include "plugins/cyclonedds/token_translation.hpp"

namespace ddssec::cyclonedds {

Status check_endpoint_is_guarded(AccessControlAdapter& adapter, spi::PermissionsHandle handle,
                                 const spi::EndpointRequest& request,
                                 const spi::EndpointSecurityAttributes& endpoint, bool is_writer) {
  const bool is_controlled =
      is_writer ? endpoint.topic.is_read_protected : endpoint.topic.is_write_protected;
  if (endpoint.is_submessage_protected() || endpoint.is_payload_protected()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                          adapter.plugin().participant_sec_attributes(handle));
  const bool relies_on_messages = participant.is_rtps_protected() && !is_writer;
  if (participant.allow_unauthenticated_participants && (is_controlled || relies_on_messages))
    return fail(Code::unauthenticated_peers_unstoppable,
                {.document = "governance",
                 .field = "allow_unauthenticated_participants",
                 .expected = "false, or protection of the topic",
                 .found = "true"});
  if (!is_controlled) return {};
  return fail(Code::controlled_topic_unguarded,
              {.document = "governance",
               .field = is_writer ? "enable_read_access_control" : "enable_write_access_control",
               .expected = "false, or protection of the topic",
               .found = "true, with metadata_protection_kind and data_protection_kind NONE",
               .note = "topic \"" + std::string(request.topic_name) + "\""});
}

Status check_not_exposed_by_shared_memory(AccessControlAdapter& adapter,
                                          spi::PermissionsHandle handle, std::string_view topic,
                                          const DDS_Security_Qos* qos,
                                          const spi::EndpointSecurityAttributes& endpoint,
                                          EndpointDirection direction) {
  auto& guard = adapter.shared_memory();
  if (guard.is_allowed(handle)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                          adapter.plugin().participant_sec_attributes(handle));
  const auto promise = promise_for_samples(participant, endpoint, direction);
  if (promise.empty()) return {};
  if (qos != nullptr) {
    DDSSEC_ASSIGN_OR_RETURN(const auto properties, properties_from(qos));
    DDSSEC_ASSIGN_OR_RETURN(const auto allowed, SharedMemoryGuard::is_allowed_by(properties));
    if (allowed) return {};
  }
  return guard.check(topic, promise);
}

}  // namespace ddssec::cyclonedds
