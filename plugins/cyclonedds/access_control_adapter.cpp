#include "plugins/cyclonedds/access_control_adapter.hpp"

#include <atomic>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/rollback.hpp"
#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "plugins/cyclonedds/exempt_topics.hpp"
#include "plugins/cyclonedds/own_readers.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"
#include "plugins/cyclonedds/process_questions.hpp"
#include "plugins/cyclonedds/refused_creation.hpp"
#include "plugins/cyclonedds/token_translation.hpp"
#include "plugins/cyclonedds/unguarded_endpoints.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/process_properties.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cyclonedds {
namespace {

using Adapter = AccessControlAdapter;
using Instance = dds_security_access_control;
using CToken = DDS_Security_DataHolder;
using CPermissions = DDS_Security_PermissionsHandle;
using CDomain = DDS_Security_DomainId;
using Partition = DDS_Security_PartitionQosPolicy;
using Tags = DDS_Security_DataTags;

spi::PermissionsHandle permissions(CPermissions handle) { return {handle}; }

// True for the topic of a carrier of that local participant, as is_carrier_topic judges it.
Result<bool> is_carrier_topic_of(Adapter& adapter, CPermissions handle, std::string_view name) {
  if (name != kCarrierTopic) return false;
  DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                          adapter.plugin().participant_sec_attributes(permissions(handle)));
  return is_carrier_topic(name, participant);
}

CPermissions validate_local_permissions(Instance* instance,
                                        const dds_security_authentication* authentication,
                                        const DDS_Security_IdentityHandle identity,
                                        const CDomain domain_id, const DDS_Security_Qos* qos,
                                        Exception* ex) {
  return ask_handle<Adapter>(instance, ex, [&](Adapter& adapter) -> Result<spi::PermissionsHandle> {
    Rollback refused([&] { give_up_identity(authentication, {identity}); });
    DDSSEC_RETURN_IF_ERROR(require(qos));
    adapter.set_authentication(authentication);
    report_plugins_in_use(adapter.host(), PluginKind::access_control);
    adapter.set_domain_id(static_cast<std::uint32_t>(domain_id));
    DDSSEC_ASSIGN_OR_RETURN(auto property_list, properties_from(qos));
    DDSSEC_ASSIGN_OR_RETURN(const auto properties,
                            spi::with_process_properties(std::move(property_list)));
    DDSSEC_ASSIGN_OR_RETURN(const auto grace, spi::clock_step_grace(properties));
    adapter.host().calendar().set_grace(grace);
    DDSSEC_ASSIGN_OR_RETURN(const bool allow_shared_memory,
                            SharedMemoryGuard::is_allowed_by(properties));
    DDSSEC_ASSIGN_OR_RETURN(const bool trusts_type_information,
                            spi::flag_property(properties, spi::property::kTrustTypeInformation));
    if (trusts_type_information) adapter.trust_type_information();
    DDSSEC_ASSIGN_OR_RETURN(const auto handle, adapter.plugin().validate_local_permissions(
                                                   {identity}, domain_id, properties));
    Rollback give_back([&] { (void)adapter.plugin().return_permissions_handle(handle); });
    if (allow_shared_memory) adapter.shared_memory().allow(handle);
    DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                            adapter.plugin().participant_sec_attributes(handle));
    adapter.facts().note(handle, {identity}, participant);
    give_back.release();
    refused.release();
    return handle;
  });
}

CPermissions validate_remote_permissions(Instance* instance, const dds_security_authentication*,
                                         const DDS_Security_IdentityHandle local_identity,
                                         const DDS_Security_IdentityHandle remote_identity,
                                         const CToken* /*permissions_token*/,
                                         const CToken* credential, Exception* ex) {
  return ask_handle<Adapter>(instance, ex, [&](Adapter& adapter) -> Result<spi::PermissionsHandle> {
    DDSSEC_RETURN_IF_ERROR(adapter.facts().check(spi::IdentityHandle{local_identity}));
    DDSSEC_ASSIGN_OR_RETURN(const auto peer, token_from(credential));
    // The announced token is not used, because it can be forged, and the host keeps the first one.
    // The permissions of the handshake are signed.
    DDSSEC_ASSIGN_OR_RETURN(const auto handle,
                            adapter.plugin().validate_remote_permissions(
                                {local_identity}, {remote_identity},
                                {.class_id = std::string(spi::class_id::kPermissions)}, peer));
    Rollback give_back([&] { (void)adapter.plugin().return_permissions_handle(handle); });
    adapter.peer_permissions().note({remote_identity}, handle);
    give_back.release();
    return handle;
  });
}

DDS_Security_boolean check_create_participant(Instance* instance, const CPermissions handle,
                                              const CDomain domain_id, const DDS_Security_Qos*,
                                              Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) {
    return or_give_up(adapter, permissions(handle),
                      adapter.plugin().check_create_participant(permissions(handle), domain_id));
  });
}

struct WriterCalls {
  static constexpr auto kCheck = &spi::AccessControl::check_create_datawriter;
  static constexpr auto kAttributes = &spi::AccessControl::datawriter_sec_attributes;
  static constexpr auto kDirection = EndpointDirection::writes;
};
struct ReaderCalls {
  static constexpr auto kCheck = &spi::AccessControl::check_create_datareader;
  static constexpr auto kAttributes = &spi::AccessControl::datareader_sec_attributes;
  static constexpr auto kDirection = EndpointDirection::reads;
};

// The data in the host's call about a local endpoint, besides its question.
struct LocalEndpoint {
  spi::PermissionsHandle local;
  CDomain domain_id;
  const DDS_Security_Qos* qos;
};

template <class Calls>
Status check_create_endpoint(Adapter& adapter, const LocalEndpoint& endpoint,
                             const spi::EndpointRequest& request) {
  const auto local = endpoint.local;
  DDSSEC_RETURN_IF_ERROR(adapter.facts().check(local));
  auto& plugin = adapter.plugin();
  DDSSEC_RETURN_IF_ERROR((plugin.*Calls::kCheck)(local, endpoint.domain_id, request));
  DDSSEC_ASSIGN_OR_RETURN(const auto attributes, (plugin.*Calls::kAttributes)(local, request));
  constexpr bool kIsWriter = Calls::kDirection == EndpointDirection::writes;
  DDSSEC_RETURN_IF_ERROR(check_endpoint_is_guarded(adapter, local, request, attributes, kIsWriter));
  return check_not_exposed_by_shared_memory(adapter, local, request.topic_name, endpoint.qos,
                                            attributes, Calls::kDirection);
}

// Readers that the core itself makes, without the application, need no permission.
Result<bool> is_reader_of_core(Adapter& adapter, CPermissions handle,
                               const spi::EndpointRequest& request) {
  if (reads_local_builtin_topic(request)) return true;
  return is_carrier_topic_of(adapter, handle, request.topic_name);
}

template <class Calls>
DDS_Security_boolean check_create(Instance* instance, const CPermissions handle,
                                  const CDomain domain_id, const char* topic_name,
                                  const DDS_Security_Qos* qos, const Partition* partition,
                                  const Tags* tags, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto question,
                            EndpointQuestion::from(topic_name, partition, tags));
    const auto request = question.request();
    if constexpr (Calls::kDirection == EndpointDirection::reads) {
      DDSSEC_ASSIGN_OR_RETURN(const bool needs_none, is_reader_of_core(adapter, handle, request));
      if (needs_none) return {};
    }
    return check_create_endpoint<Calls>(adapter, {permissions(handle), domain_id, qos}, request);
  });
}

DDS_Security_boolean check_create_topic(Instance* instance, const CPermissions handle,
                                        const CDomain domain_id, const char* topic_name,
                                        const DDS_Security_Qos*, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(topic_name));
    if (is_local_builtin_topic(topic_name)) return {};
    DDSSEC_ASSIGN_OR_RETURN(const auto carriers, is_carrier_topic_of(adapter, handle, topic_name));
    if (carriers) return {};
    DDSSEC_RETURN_IF_ERROR(adapter.facts().check(permissions(handle)));
    return adapter.plugin().check_create_topic(permissions(handle), domain_id, topic_name);
  });
}

DDS_Security_boolean check_remote_participant(Instance* instance, const CPermissions handle,
                                              const CDomain domain_id,
                                              const DDS_Security_ParticipantBuiltinTopicDataSecure*,
                                              Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) {
    return adapter.plugin().check_remote_participant(permissions(handle), domain_id);
  });
}

DDS_Security_boolean check_remote_datawriter(
    Instance* instance, const CPermissions handle, const CDomain domain_id,
    const DDS_Security_PublicationBuiltinTopicDataSecure* data, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(data));
    DDSSEC_ASSIGN_OR_RETURN(
        const auto question,
        EndpointQuestion::from(data->topic_name, &data->partition, &data->data_tags));
    return adapter.plugin().check_remote_datawriter(permissions(handle), domain_id,
                                                    question.request());
  });
}

DDS_Security_boolean check_remote_datareader(
    Instance* instance, const CPermissions handle, const CDomain domain_id,
    const DDS_Security_SubscriptionBuiltinTopicDataSecure* data,
    DDS_Security_boolean* is_relay_only, Exception* ex) {
  // The host reads this value even after a refusal, from memory that it did not initialize.
  if (is_relay_only != nullptr) *is_relay_only = 0;
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(data, is_relay_only));
    DDSSEC_ASSIGN_OR_RETURN(
        const auto question,
        EndpointQuestion::from(data->topic_name, &data->partition, &data->data_tags));
    DDSSEC_ASSIGN_OR_RETURN(const auto reader,
                            adapter.plugin().check_remote_datareader(permissions(handle), domain_id,
                                                                     question.request()));
    *is_relay_only = reader.is_relay_only;
    return {};
  });
}

DDS_Security_boolean check_remote_topic(Instance* instance, const CPermissions handle,
                                        const CDomain domain_id,
                                        const DDS_Security_TopicBuiltinTopicData* data,
                                        Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(data));
    DDSSEC_RETURN_IF_ERROR(require(data->name));
    return adapter.plugin().check_remote_topic(permissions(handle), domain_id, data->name);
  });
}

// Cyclone's core matches local endpoints without asking and has no checks of instances, so six
// functions of the table below have no caller. The standard's builtin plugin allows all of them
// (DDS-Security 1.2, clause 10.4.3), because creation and remote matching were checked already.
template <class... Arguments>
DDS_Security_boolean allow(Instance* instance, Arguments... arguments) noexcept {
  Exception* const ex = std::get<sizeof...(arguments) - 1>(std::tuple(arguments...));
  return ask<Adapter>(instance, ex, [](Adapter&) -> Status { return {}; });
}

DDS_Security_boolean get_permissions_token(Instance* instance, CToken* token,
                                           const CPermissions handle, Exception* ex) {
  return ask_token<Adapter>(instance, token, ex, [&](Adapter& adapter) {
    return adapter.plugin().permissions_token(permissions(handle));
  });
}

DDS_Security_boolean get_permissions_credential_token(Instance* instance, CToken* token,
                                                      const CPermissions handle, Exception* ex) {
  return ask_token<Adapter>(instance, token, ex, [&](Adapter& adapter) {
    return adapter.plugin().permissions_credential_token(permissions(handle));
  });
}

DDS_Security_boolean get_participant_sec_attributes(
    Instance* instance, const CPermissions handle,
    DDS_Security_ParticipantSecurityAttributes* attributes, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(attributes));
    *attributes = {};
    DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                            adapter.plugin().participant_sec_attributes(permissions(handle)));
    // The host asks this once, and creates the participant after it.
    DDSSEC_RETURN_IF_ERROR(join_or_give_up(adapter, permissions(handle)));
    *attributes = to_c(participant);
    return {};
  });
}

DDS_Security_boolean get_topic_sec_attributes(Instance* instance, const CPermissions handle,
                                              const char* topic_name,
                                              DDS_Security_TopicSecurityAttributes* attributes,
                                              Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(topic_name, attributes));
    *attributes = {};
    DDSSEC_ASSIGN_OR_RETURN(const auto topic,
                            adapter.plugin().topic_sec_attributes(permissions(handle), topic_name));
    *attributes = to_c(topic);
    return {};
  });
}

// True if access control decides which peers get the keys of such an endpoint.
bool needs_gate(const spi::EndpointSecurityAttributes& endpoint) {
  return !endpoint.is_builtin &&
         (endpoint.topic.is_read_protected || endpoint.topic.is_write_protected) &&
         (endpoint.is_submessage_protected() || endpoint.is_payload_protected());
}

// Answers get_datawriter_sec_attributes, and get_datareader_sec_attributes for a reader that is
// open.
template <class Calls>
Status tell_attributes(Adapter& adapter, const CPermissions handle,
                       const spi::EndpointRequest& request,
                       DDS_Security_EndpointSecurityAttributes& attributes) {
  DDSSEC_ASSIGN_OR_RETURN(const auto found,
                          (adapter.plugin().*Calls::kAttributes)(permissions(handle), request));
  constexpr bool kWrites = Calls::kDirection == EndpointDirection::writes;
  auto& endpoints = adapter.endpoints();
  // This step comes first: if there is no memory for it, nothing exists yet that the host would
  // have to free.
  if (!found.is_builtin) endpoints.add(&attributes, permissions(handle), kWrites, request);
  attributes = to_c(found);
  if (!needs_gate(found)) return {};
  auto status = make_scope(adapter.id(), request, attributes.ac_endpoint_properties);
  if (status) return status;
  attributes = {};
  endpoints.remove(&attributes);
  return status;
}

// Answers a question about an endpoint. `tell(adapter, request)` writes `attributes`, which are
// empty before.
template <class Tell>
DDS_Security_boolean ask_endpoint(Instance* instance, const char* topic_name,
                                  const Partition* partition, const Tags* tags,
                                  DDS_Security_EndpointSecurityAttributes* attributes,
                                  Exception* ex, Tell&& tell) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(attributes));
    *attributes = {};
    DDSSEC_ASSIGN_OR_RETURN(const auto question,
                            EndpointQuestion::from(topic_name, partition, tags));
    return tell(adapter, question.request());
  });
}

DDS_Security_boolean get_datawriter_sec_attributes(
    Instance* instance, const CPermissions handle, const char* topic_name,
    const Partition* partition, const Tags* tags,
    DDS_Security_EndpointSecurityAttributes* attributes, Exception* ex) {
  const auto tell = [&](Adapter& adapter, const spi::EndpointRequest& request) {
    return tell_attributes<WriterCalls>(adapter, handle, request, *attributes);
  };
  return ask_endpoint(instance, topic_name, partition, tags, attributes, ex, tell);
}

DDS_Security_boolean get_datareader_sec_attributes(
    Instance* instance, const CPermissions handle, const char* topic_name,
    const Partition* partition, const Tags* tags,
    DDS_Security_EndpointSecurityAttributes* attributes, Exception* ex) {
  const auto tell = [&](Adapter& adapter, const spi::EndpointRequest& request) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto participant,
                            adapter.plugin().participant_sec_attributes(permissions(handle)));
    if (is_closed(request, participant, adapter.type_lookup())) {
      *attributes = closed_reader_attributes();
      return {};
    }
    if (is_carrier_topic(request.topic_name, participant)) {
      *attributes = closed_reader_attributes();
      attributes->is_discovery_protected = true;
      return {};
    }
    return tell_attributes<ReaderCalls>(adapter, handle, request, *attributes);
  };
  return ask_endpoint(instance, topic_name, partition, tags, attributes, ex, tell);
}

// The values in ac_endpoint_properties of these attributes live as long as the library.
template <class Attributes>
DDS_Security_boolean return_attributes(Instance* instance, const Attributes*, Exception* ex) {
  return allow(instance, ex);
}

// The host declares the object const although it gives it back, and never uses it again.
DDS_Security_boolean return_datawriter_sec_attributes(
    Instance* instance, const DDS_Security_EndpointSecurityAttributes* attributes, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    adapter.endpoints().remove(attributes);
    if (attributes != nullptr)
      free_scope(const_cast<DDS_Security_PropertySeq&>(attributes->ac_endpoint_properties));
    return {};
  });
}

// The host calls this when a reader is gone.
DDS_Security_boolean return_datareader_sec_attributes(
    Instance* instance, const DDS_Security_EndpointSecurityAttributes* attributes, Exception* ex) {
  look_for_ended_readers();
  return return_datawriter_sec_attributes(instance, attributes, ex);
}

DDS_Security_boolean return_permissions_handle(Instance* instance, CPermissions handle,
                                               Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    return forget_permissions(adapter, permissions(handle));
  });
}

constexpr dds_security_access_control kTable = {
    .gv = nullptr,
    .validate_local_permissions = validate_local_permissions,
    .validate_remote_permissions = validate_remote_permissions,
    .check_create_participant = check_create_participant,
    .check_create_datawriter = check_create<WriterCalls>,
    .check_create_datareader = check_create<ReaderCalls>,
    .check_create_topic = check_create_topic,
    .check_local_datawriter_register_instance = allow,
    .check_local_datawriter_dispose_instance = allow,
    .check_remote_participant = check_remote_participant,
    .check_remote_datawriter = check_remote_datawriter,
    .check_remote_datareader = check_remote_datareader,
    .check_remote_topic = check_remote_topic,
    .check_local_datawriter_match = allow,
    .check_local_datareader_match = allow,
    .check_remote_datawriter_register_instance = allow,
    .check_remote_datawriter_dispose_instance = allow,
    .get_permissions_token = get_permissions_token,
    .get_permissions_credential_token = get_permissions_credential_token,
    .set_listener = set_listener<Adapter>,
    .return_permissions_token = return_token<Adapter>,
    .return_permissions_credential_token = return_token<Adapter>,
    .get_participant_sec_attributes = get_participant_sec_attributes,
    .get_topic_sec_attributes = get_topic_sec_attributes,
    .get_datawriter_sec_attributes = get_datawriter_sec_attributes,
    .get_datareader_sec_attributes = get_datareader_sec_attributes,
    .return_participant_sec_attributes =
        return_attributes<DDS_Security_ParticipantSecurityAttributes>,
    .return_topic_sec_attributes = return_attributes<DDS_Security_TopicSecurityAttributes>,
    .return_datawriter_sec_attributes = return_datawriter_sec_attributes,
    .return_datareader_sec_attributes = return_datareader_sec_attributes,
    .return_permissions_handle = return_permissions_handle,
};

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

}  // namespace

AccessControlAdapter::AccessControlAdapter(std::unique_ptr<Host> host,
                                           const MakePlugin<spi::AccessControl>& make,
                                           ddsi_domaingv* domain,
                                           SharedMemoryGuard::Probe find_bypass)
    : dds_security_access_control(kTable),
      id_(next_id()),
      host_(std::move(host)),
      plugin_(make(host_->services_with_record(!has_our_authentication()))),
      shared_memory_(std::move(find_bypass)),
      timer_(host_->clock()) {
  gv = domain;
  register_in_process();
}

AccessControlAdapter::~AccessControlAdapter() { unregister_from_process(); }

TypeLookup AccessControlAdapter::type_lookup() const {
  return trusts_type_information_ || !has_our_cryptography() ? TypeLookup::open
                                                             : TypeLookup::closed;
}

void AccessControlAdapter::listen(const dds_security_access_control_listener* listener) {
  if (listener == nullptr || listener->on_revoke_permissions == nullptr) return timer_.stop();
  const auto revoke = [this, tell = listener->on_revoke_permissions](spi::PermissionsHandle one) {
    tell(this, one.value);
  };
  timer_.start({.revoke_ended =
                    [this, revoke](const std::stop_token& stop) {
                      report_clock_steps(*host_, PluginKind::access_control);
                      revoke_ended(stop, revoke);
                    },
                .next_expiry = [this] { return plugin_->next_expiry(); }});
}

void AccessControlAdapter::poll_endpoints() {
  const auto now = host_->clock().monotonic();
  for (const auto local : facts_.locals()) {
    const auto changed = endpoints_.poll(local, *plugin_, now);
    if (!changed) continue;
    end_sessions_now();
    host_->notice(Event(*changed));
  }
}

// All local participants are cut off before the host is informed of one, so that none of them
// counts as another one that is still valid.
void AccessControlAdapter::revoke_ended(const std::stop_token& stop, const Revoke& revoke) {
  std::vector<std::pair<spi::PermissionsHandle, std::optional<spi::IdentityHandle>>> ended;
  const auto expired = plugin_->poll();
  poll_endpoints();
  for (const auto handle : expired) ended.emplace_back(handle, facts_.identity_of(handle));
  for (const auto& [handle, own] : ended) {
    if (!own) continue;
    facts_.cut_off(*own, Code::grant_expired);
    cut_off_cryptography(*own);
  }
  for (const auto& [handle, own] : ended)
    if (!stop.stop_requested() && (!own || facts_.has_others(*own))) revoke(handle);
}

}  // namespace ddssec::cyclonedds
