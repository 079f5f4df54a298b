#include "rtps/security/admission.hpp"

namespace ddssec::rtps {
namespace {

std::string hex(std::uint32_t value) {
  Writer out;
  out.write(value);
  return to_hex(out.view());
}

// Returns both masks as text.
std::string text_of(const spi::SecurityInfo& info) {
  return hex(info.mask) + " " + hex(info.plugin_mask);
}

std::unexpected<Error> mismatch_error(const ParticipantData& data, const spi::SecurityInfo& own) {
  return fail(Code::rtps_security_info_mismatch,
              {.document = "participant " + data.guid.to_string(),
               .field = "participant_security_info",
               .expected = text_of(own),
               .found = text_of(data.security_info.value_or(spi::SecurityInfo{}))});
}

// Either both participants revise their keys or neither does. Otherwise the one that does not
// could no longer communicate with the other.
Status check_key_revision(const ParticipantData& data, const spi::SecurityInfo& own,
                          const spi::SecurityInfo& remote) {
  constexpr auto kEnabled = spi::kMaskIsValid | spi::kKeyRevisionBit;
  const bool ours = (own.mask & kEnabled) == kEnabled;
  const bool theirs = (remote.mask & kEnabled) == kEnabled;
  if (ours == theirs) return {};
  return fail(Code::rtps_key_revision_mismatch, {.document = "participant " + data.guid.to_string(),
                                                 .field = "enable_key_revision",
                                                 .expected = ours ? "true" : "false",
                                                 .found = theirs ? "true" : "false"});
}

std::vector<std::string_view> views_of(const std::vector<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

// True if nothing of the endpoint is protected or subject to access control.
bool is_open(const spi::EndpointSecurityAttributes& attributes) {
  const auto& topic = attributes.topic;
  return !topic.is_read_protected && !topic.is_write_protected && !topic.is_discovery_protected &&
         !attributes.is_submessage_protected() && !attributes.is_payload_protected();
}

}  // namespace

// ---- participants

bool Admission::admits_unauthenticated() const {
  const auto& attributes = core_.own->attributes();
  return attributes.allow_unauthenticated_participants && !attributes.is_rtps_protected();
}

bool Admission::may_authenticate(const ParticipantData& data) const {
  return data.identity_token && check_participant(data);
}

Admission::Decision Admission::judge(const ParticipantData& data) {
  if (may_authenticate(data)) return Decision::authenticate;
  if (admits_unauthenticated()) return Decision::admit_unauthenticated;
  core_.count_failed();
  const auto document = "participant " + data.guid.to_string();
  auto why = data.identity_token
                 ? check_participant(data).error().with_default_document(document)
                 : Error(Code::rtps_peer_not_secured,
                         {.document = document, .expected = "an identity token", .found = "none"});
  core_.raise(std::move(why), data.guid, EventOrigin::anyone);
  return Decision::refuse;
}

// Checks whether the participant announces attributes with which it can communicate with the local
// one.
Status Admission::check_participant(const ParticipantData& data) const {
  const auto own_info = spi::security_info(core_.own->attributes());
  const auto info = data.security_info.value_or(spi::SecurityInfo{});
  DDSSEC_RETURN_IF_ERROR(check_key_revision(data, own_info, info));
  if (!spi::is_compatible(own_info, info)) return mismatch_error(data, own_info);
  if (!data.ciphers) return {};
  DDSSEC_RETURN_IF_ERROR(check_ciphers(data.vendor, data.ciphers->builtin_required));
  return check_ciphers(data.vendor, data.ciphers->key_exchange_required);
}

Status Admission::check_proven(const ParticipantData& proven) const {
  DDSSEC_RETURN_IF_ERROR(check_participant(proven));
  return check_domain(proven);
}

// Checks the signed data, because an announcement may have been changed on its way. Other vendors
// do not include the domain tag in this data, so their tag is not compared.
Status Admission::check_domain(const ParticipantData& proven) const {
  const bool says_no_tag = proven.domain_tag.empty() && proven.vendor != kVendorDdssec;
  const auto& tag = says_no_tag ? proven.domain_tag : core_.own->domain_tag();
  if (is_of_domain(proven, core_.own->domain_id(), tag)) return {};
  const auto text = [](std::uint32_t domain, const std::string& domain_tag) {
    return "domain " + std::to_string(domain) + ", tag \"" + domain_tag + "\"";
  };
  const auto own_id = static_cast<std::uint32_t>(core_.own->domain_id());
  auto error = Error(Code::rtps_domain_differs,
                     {.document = "what participant " + proven.guid.to_string() + " signed",
                      .field = "DOMAIN_ID and DOMAIN_TAG",
                      .expected = text(own_id, core_.own->domain_tag()),
                      .found = text(proven.domain_id.value_or(own_id), proven.domain_tag)});
  core_.raise(error, proven.guid, EventOrigin::its_keys);
  return std::unexpected(std::move(error));
}

// A vendor-specific bit has a meaning only for that vendor. Cryptography learns from the handshake
// which local ciphers the peer supports.
Status Admission::check_ciphers(VendorId vendor, spi::CipherMask required) const {
  auto supported = core_.own->ciphers().supported;
  if (vendor != kVendorDdssec) supported &= spi::kStandardCiphers;
  if (spi::is_supported_by(required, supported)) return {};
  return fail(Code::rtps_cipher_unsupported,
              {.field = "symmetric_cipher", .expected = hex(supported), .found = hex(required)});
}

// ---- endpoints

Admission::Endpoint Admission::Endpoint::of(const EndpointData& announced) {
  return {announced.guid,
          announced.topic_name,
          announced.qos.partition,
          announced.qos.data_tags,
          announced.security_info.value_or(spi::SecurityInfo{}),
          announced.by_secure_discovery,
          announced.required_ciphers};
}

Status Admission::check_own(const EntityId& id, const NewEndpoint& endpoint) {
  auto& plugin = core_.own->plugins().access_control;
  const auto permissions = core_.own->permissions();
  const auto names = views_of(endpoint.partitions);
  const spi::EndpointRequest request{
      .topic_name = endpoint.topic, .partitions = names, .data_tags = endpoint.data_tags};
  return is_writer(id)
             ? plugin.check_create_datawriter(permissions, core_.own->domain_id(), request)
             : plugin.check_create_datareader(permissions, core_.own->domain_id(), request);
}

// Endpoints that are matched stay matched, unless the governance has changed. Peers judge us by the
// renewed permissions from their next handshake with us on.
bool Admission::may_still(const EntityId& id) {
  const auto asked = own_.find(id);
  const bool as_at_the_start =
      !core_.governance_change.has_changed() &&
      core_.own->plugins().access_control.renewals(core_.own->permissions()) == 0;
  if (asked == own_.end() || as_at_the_start) return true;
  const auto& [topic, partitions, data_tags] = asked->second;
  const auto status = check_own(id, {topic, partitions, data_tags, spi::PropertyList()});
  if (!status) core_.events.raise(Event(status.error()));
  return status.has_value();
}

Status Admission::check_partitions(const EntityId& id, const std::vector<std::string>& partitions) {
  const auto asked = own_.find(id);
  if (asked == own_.end()) return {};
  return check_own(id,
                   {asked->second.topic, partitions, asked->second.data_tags, spi::PropertyList()});
}

void Admission::set_partitions(const EntityId& id, const std::vector<std::string>& partitions) {
  const auto asked = own_.find(id);
  if (asked != own_.end()) asked->second.partitions = partitions;
}

Result<Admission::AnnouncedSecurity> Admission::create_endpoint(const EntityId& id,
                                                                const NewEndpoint& endpoint) {
  forget_endpoint(id);  // an id that is used again may have another topic
  auto& plugin = core_.own->plugins().access_control;
  const auto names = views_of(endpoint.partitions);
  const spi::EndpointRequest request{
      .topic_name = endpoint.topic, .partitions = names, .data_tags = endpoint.data_tags};
  DDSSEC_RETURN_IF_ERROR(
      plugin.check_create_topic(core_.own->permissions(), core_.own->domain_id(), endpoint.topic));
  DDSSEC_RETURN_IF_ERROR(check_own(id, endpoint));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto attributes,
      is_writer(id) ? plugin.datawriter_sec_attributes(core_.own->permissions(), request)
                    : plugin.datareader_sec_attributes(core_.own->permissions(), request));
  auto& on_topic = endpoints_on_[std::string(endpoint.topic)];
  own_.insert_or_assign(
      id, CreationParameters{std::string(endpoint.topic), endpoint.partitions, endpoint.data_tags});
  ++on_topic;
  DDSSEC_RETURN_IF_ERROR(core_.keyring.add_local(id, attributes, {}, endpoint.properties));
  if (core_.governance_change.is_under_way())
    DDSSEC_RETURN_IF_ERROR(add_other_protection(id, endpoint.topic));
  return announced(id);
}

void Admission::forget_endpoint(const EntityId& id) {
  const auto gone = own_.extract(id);
  if (gone.empty()) return;
  const auto on_topic = endpoints_on_.find(gone.mapped().topic);
  if (on_topic == endpoints_on_.end() || --on_topic->second > 0) return;
  core_.own->plugins().access_control.forget_topic(core_.own->permissions(), on_topic->first);
  endpoints_on_.erase(on_topic);
}

Status Admission::add_other_protection(const EntityId& id, std::string_view topic) {
  const auto other = other_attributes(topic);
  if (!other || core_.keyring.phases().endpoints().attributes(id) != nullptr ||
      protection_id(*other) == core_.keyring.phases().endpoints().first_protection_of(id))
    return {};
  return core_.keyring.phases().endpoints().add(id, *other);
}

std::optional<spi::EndpointSecurityAttributes> Admission::other_attributes(
    std::string_view topic) const {
  const auto& other = core_.governance_change.other_governance();
  if (!other) return {};
  return core_.own->plugins().access_control.endpoint_attributes_of(core_.own->permissions(),
                                                                    *other, topic);
}

Result<Admission::AnnouncedSecurity> Admission::announced(const EntityId& id) {
  const auto& attributes = *core_.keyring.attributes(id);
  DDSSEC_ASSIGN_OR_RETURN(const auto ciphers, core_.keyring.required_ciphers(id));
  AnnouncedSecurity out{spi::security_info(attributes), ciphers, attributes.is_key_protected()};
  // An endpoint of Fast DDS without security matches one that announces masks only if these masks
  // require access control.
  if (admits_unauthenticated() && is_open(attributes)) out.info.reset();
  return out;
}

std::optional<Admission::Permission> Admission::admit(const EntityId& local,
                                                      const Endpoint& remote) {
  const auto* attributes = core_.keyring.attributes(local);
  if (attributes == nullptr || !may_still(local)) return std::nullopt;
  // Also while there are no keys for it yet, or no longer (GovernanceTransition::note_revision).
  const auto other = other_attributes(remote.topic);
  const auto permission = admit({*attributes, is_reader(local), other ? &*other : nullptr}, remote);
  if (!core_.governance_change.is_under_way()) return permission;
  auto& second = core_.keyring.phases().endpoints();
  second.set_permitted(
      local, remote.guid,
      permission && permits_under_pending_governance(is_reader(local), *permission, remote));
  second.note_announced(
      local, remote.guid,
      permission && !spi::is_compatible(spi::security_info(*attributes), remote.info));
  return permission;
}

// True if the remote endpoint may do the same once the waiting document is in force. Otherwise it
// gets no keys for the protection that this document demands.
bool Admission::permits_under_pending_governance(bool reads, const Permission& permission,
                                                 const Endpoint& remote) {
  auto& plugin = core_.own->plugins().access_control;
  const auto pending = plugin.pending_governance(core_.own->permissions());
  if (!pending || pending != core_.governance_change.other_governance()) return true;
  const auto* peer = core_.find(remote.guid.prefix);
  const auto* association = peer == nullptr ? nullptr : peer->state.association();
  if (association == nullptr) return false;
  const auto names = views_of(remote.partitions);
  const auto later = plugin.pending_permission(
      association->permissions.handle, reads,
      {.topic_name = remote.topic, .partitions = names, .data_tags = remote.data_tags});
  return later && later->is_relay_only == permission.is_relay_only;
}

std::vector<std::pair<EntityId, std::string>> Admission::own_topics() const {
  std::vector<std::pair<EntityId, std::string>> out;
  for (const auto& [id, asked] : own_) out.emplace_back(id, asked.topic);
  return out;
}

// The topic must not count as in use: the writer may not be allowed to use it, and the names of
// topics in use decide which governance documents are taken.
bool Admission::may_write(const Endpoint& writer) {
  const auto attributes = core_.own->plugins().access_control.unused_topic_attributes(
      core_.own->permissions(), writer.topic);
  if (attributes) return admit({*attributes, true}, writer).has_value();
  core_.raise(attributes.error().with_default_document("topic " + std::string(writer.topic)),
              writer.guid, core_.origin_of_announcement(writer.guid, writer.is_secure));
  return false;
}

std::optional<Admission::Permission> Admission::admit(const Local& local, const Endpoint& remote) {
  const auto* peer = core_.find(remote.guid.prefix);
  const auto* joined = peer == nullptr ? nullptr : peer->state.joined();
  const auto status = joined != nullptr ? check_protection(local, remote, *peer)
                                        : check_open(local.attributes, remote);
  if (!status) {
    core_.raise(status.error().with_default_document("topic " + std::string(remote.topic)),
                remote.guid, core_.origin_of_announcement(remote.guid, remote.is_secure));
    return std::nullopt;
  }
  if (joined == nullptr) return Permission{};
  // check_permissions raises its own event.
  const auto permission = check_permissions(local, joined->association, remote);
  return permission ? std::optional(*permission) : std::nullopt;
}

// DDS-Security 1.2, clause 9.8.8: unauthenticated participants may use topics that have no access
// control and no protection of any kind.
Status Admission::check_open(const spi::EndpointSecurityAttributes& attributes,
                             const Endpoint& remote) const {
  if (is_open(attributes) && admits_unauthenticated()) return {};
  return fail(Code::rtps_peer_not_secured,
              {.expected = "an authenticated participant", .found = remote.guid.to_string()});
}

// While the governance changes, a peer that accepts both protections, as we do, may announce either
// of them.
Status Admission::check_protection(const Local& local, const Endpoint& remote,
                                   const Peer& peer) const {
  if (remote.required_ciphers)
    DDSSEC_RETURN_IF_ERROR(check_ciphers(peer.data.vendor, *remote.required_ciphers));
  const auto status = check_announced(local.attributes, remote);
  const bool may_be_other =
      local.other != nullptr && peer.state.association()->governance.takes_part;
  return !status && may_be_other && check_announced(*local.other, remote) ? Status() : status;
}

Status Admission::check_announced(const spi::EndpointSecurityAttributes& attributes,
                                  const Endpoint& remote) {
  if (attributes.topic.is_discovery_protected && !remote.is_secure)
    return fail(Code::rtps_protection_missing,
                {.expected = "an announcement by secure discovery", .found = "a plain one"});
  const auto own = spi::security_info(attributes);
  if (spi::is_compatible(own, remote.info)) return {};
  return fail(
      Code::rtps_security_info_mismatch,
      {.field = "endpoint_security_info", .expected = text_of(own), .found = text_of(remote.info)});
}

Result<Admission::Permission> Admission::check_permissions(const Local& local,
                                                           const Association& peer,
                                                           const Endpoint& remote) {
  auto& plugin = core_.own->plugins().access_control;
  const auto names = views_of(remote.partitions);
  const spi::EndpointRequest request{
      .topic_name = remote.topic, .partitions = names, .data_tags = remote.data_tags};
  if (local.reads) {
    DDSSEC_RETURN_IF_ERROR(
        plugin.check_remote_datawriter(peer.permissions.handle, core_.own->domain_id(), request));
    return Permission{};
  }
  DDSSEC_ASSIGN_OR_RETURN(
      const auto answer,
      plugin.check_remote_datareader(peer.permissions.handle, core_.own->domain_id(), request));
  return Permission{answer.is_relay_only};
}

}  // namespace ddssec::rtps
