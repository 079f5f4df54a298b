#include "plugins/cyclonedds/value_translation.hpp"

#include <algorithm>
#include <array>

namespace ddssec::cyclonedds {
namespace {

bool has(std::uint32_t mask, std::uint32_t flag) { return (mask & flag) != 0; }

// Returns 0 for a mask without its valid bit, which adds nothing to the booleans (DDS-Security 1.2,
// clause 10.4.2.4).
std::uint32_t valid_or_nothing(std::uint32_t mask) {
  return has(mask, spi::kMaskIsValid) ? mask : 0;
}

// The names of data about an entity that libddssec_access_control passes to libddssec_cryptography.
// The host passes the attributes from one to the other without reading their properties; other
// cryptography plugins ignore them.
using NoProperties = DDS_Security_PropertySeq;
constexpr std::string_view kBuiltinEndpoint = "org.ddssec.builtin_endpoint";
constexpr std::string_view kClosedReader = "org.ddssec.closed_reader";
constexpr std::string_view kStandardCiphersOnly = "org.ddssec.standard_ciphers_only";
constexpr std::string_view kAllDiscoveryProtected = "org.ddssec.all_discovery_protected";

// Makes properties that live as long as the library. The C type has no const; nothing writes to
// them.
template <const std::string_view&... names>
DDS_Security_PropertySeq markers() {
  static char value[] = "true";
  static DDS_Security_Property_t properties[] = {
      {const_cast<char*>(names.data()), value, false}...};
  return {sizeof...(names), sizeof...(names), properties};
}
DDS_Security_PropertySeq builtin_endpoint() { return markers<kBuiltinEndpoint>(); }
DDS_Security_PropertySeq closed_reader() { return markers<kClosedReader>(); }
DDS_Security_PropertySeq of_participant(bool standard_ciphers_only, bool all_discovery_protected) {
  if (standard_ciphers_only && all_discovery_protected)
    return markers<kStandardCiphersOnly, kAllDiscoveryProtected>();
  if (standard_ciphers_only) return markers<kStandardCiphersOnly>();
  return all_discovery_protected ? markers<kAllDiscoveryProtected>() : NoProperties{};
}

bool has(const DDS_Security_PropertySeq& properties, std::string_view name) {
  const auto list = elements_of(properties);
  return list && std::ranges::any_of(*list, [&](const auto& property) {
           return property.name != nullptr && property.name == name;
         });
}

}  // namespace

Result<BytesView> octets_from(const DDS_Security_OctetSeq* octets) {
  if (octets == nullptr) return fail(Code::null_argument);
  return elements_of(*octets);
}

Guid guid_from(const DDS_Security_GUID_t& guid) {
  const std::array<std::uint8_t, 4> entity = {guid.entityId.entityKey[0],
                                              guid.entityId.entityKey[1],
                                              guid.entityId.entityKey[2], guid.entityId.entityKind};
  return {.prefix = GuidPrefix::from(guid.prefix), .entity = EntityId::from(entity)};
}

DDS_Security_GUID_t to_c(const Guid& guid) {
  DDS_Security_GUID_t out{};
  std::ranges::copy(guid.prefix.octets, out.prefix);
  std::copy_n(guid.entity.octets.begin(), 3, out.entityId.entityKey);
  out.entityId.entityKind = guid.entity.octets[3];
  return out;
}

DDS_Security_ParticipantSecurityAttributes to_c(const spi::ParticipantSecurityAttributes& a) {
  const bool only_standard = (a.allowed_ciphers & ~spi::kStandardCiphers) == 0;
  return {.allow_unauthenticated_participants = a.allow_unauthenticated_participants,
          .is_access_protected = a.is_access_protected,
          .is_rtps_protected = a.is_rtps_protected(),
          .is_discovery_protected = a.is_discovery_protected(),
          .is_liveliness_protected = a.is_liveliness_protected(),
          .plugin_participant_attributes = spi::plugin_mask(a),
          .ac_endpoint_properties = of_participant(only_standard, a.is_all_discovery_protected)};
}

DDS_Security_TopicSecurityAttributes to_c(const spi::TopicSecurityAttributes& a) {
  return {.is_read_protected = a.is_read_protected,
          .is_write_protected = a.is_write_protected,
          .is_discovery_protected = a.is_discovery_protected,
          .is_liveliness_protected = a.is_liveliness_protected};
}

DDS_Security_EndpointSecurityAttributes to_c(const spi::EndpointSecurityAttributes& a) {
  return {.is_read_protected = a.topic.is_read_protected,
          .is_write_protected = a.topic.is_write_protected,
          .is_discovery_protected = a.topic.is_discovery_protected,
          .is_liveliness_protected = a.topic.is_liveliness_protected,
          .is_submessage_protected = a.is_submessage_protected(),
          .is_payload_protected = a.is_payload_protected(),
          .is_key_protected = a.is_key_protected(),
          .plugin_endpoint_attributes = spi::plugin_mask(a),
          .ac_endpoint_properties = a.is_builtin ? builtin_endpoint() : NoProperties{}};
}

DDS_Security_EndpointSecurityAttributes closed_reader_attributes() {
  DDS_Security_EndpointSecurityAttributes out{};
  out.is_submessage_protected = true;
  out.plugin_endpoint_attributes = spi::kMaskIsValid;
  out.ac_endpoint_properties = closed_reader();
  return out;
}

spi::ParticipantSecurityAttributes attributes_from(
    const DDS_Security_ParticipantSecurityAttributes& a) {
  const auto mask = valid_or_nothing(a.plugin_participant_attributes);
  return {
      .allow_unauthenticated_participants = a.allow_unauthenticated_participants != 0,
      .is_access_protected = a.is_access_protected != 0,
      .rtps = spi::protection_kind(
          {.is_protected = a.is_rtps_protected != 0,
           .is_encrypted =
               has(mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_RTPS_ENCRYPTED),
           .is_origin_authenticated =
               has(mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_RTPS_AUTHENTICATED)}),
      .discovery = spi::protection_kind(
          {.is_protected = a.is_discovery_protected != 0,
           .is_encrypted =
               has(mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_DISCOVERY_ENCRYPTED),
           .is_origin_authenticated = has(
               mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_DISCOVERY_AUTHENTICATED)}),
      .liveliness = spi::protection_kind(
          {.is_protected = a.is_liveliness_protected != 0,
           .is_encrypted =
               has(mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_LIVELINESS_ENCRYPTED),
           .is_origin_authenticated = has(
               mask, DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_LIVELINESS_AUTHENTICATED)}),
      .allowed_ciphers = has(a.ac_endpoint_properties, kStandardCiphersOnly) ? spi::kStandardCiphers
                                                                             : spi::kAllCiphers,
      .is_all_discovery_protected = has(a.ac_endpoint_properties, kAllDiscoveryProtected)};
}

spi::EndpointSecurityAttributes attributes_from(const DDS_Security_EndpointSecurityAttributes& a) {
  if (has(a.ac_endpoint_properties, kClosedReader)) return {};
  const auto mask = valid_or_nothing(a.plugin_endpoint_attributes);
  return {
      .topic = {.is_read_protected = a.is_read_protected != 0,
                .is_write_protected = a.is_write_protected != 0,
                .is_discovery_protected = a.is_discovery_protected != 0,
                .is_liveliness_protected = a.is_liveliness_protected != 0},
      .submessage = spi::protection_kind(
          {.is_protected = a.is_submessage_protected != 0,
           .is_encrypted =
               has(mask, DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_SUBMESSAGE_ENCRYPTED),
           .is_origin_authenticated = has(
               mask,
               DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_SUBMESSAGE_ORIGIN_AUTHENTICATED)}),
      .payload = spi::protection_kind(
          {.is_protected = a.is_payload_protected != 0,
           .is_encrypted =
               has(mask, DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_PAYLOAD_ENCRYPTED)}),
      .is_builtin = has(a.ac_endpoint_properties, kBuiltinEndpoint)};
}

Result<EndpointQuestion> EndpointQuestion::from(const char* topic_name,
                                                const DDS_Security_PartitionQosPolicy* partition,
                                                const DDS_Security_DataTags* data_tags) {
  if (topic_name == nullptr) return fail(Code::null_argument, {.field = "topic name"});
  EndpointQuestion question;
  question.topic_name_ = topic_name;
  if (partition != nullptr) {
    DDSSEC_ASSIGN_OR_RETURN(const auto elements, elements_of(partition->name));
    for (const char* name : elements) {
      if (name == nullptr) return fail(Code::null_argument, {.field = "partition"});
      question.partitions_.emplace_back(name);
    }
  }
  if (data_tags != nullptr) {
    DDSSEC_ASSIGN_OR_RETURN(const auto elements, elements_of(data_tags->tags));
    for (const auto& tag : elements) {
      if (tag.name == nullptr || tag.value == nullptr)
        return fail(Code::null_argument, {.field = "data tag"});
      question.data_tags_.push_back({tag.name, tag.value});
    }
  }
  return question;
}

Result<spi::SharedSecret> shared_secret_from(DDS_Security_SharedSecretHandle handle) {
  const auto* layout = reinterpret_cast<const SharedSecretLayout*>(handle);
  if (layout == nullptr || layout->shared_secret == nullptr || layout->shared_secret_size <= 0)
    return fail(Code::foreign_shared_secret);
  const auto size = static_cast<std::size_t>(layout->shared_secret_size);
  if (size > spi::SharedSecretOctets::capacity) return fail(Code::foreign_shared_secret);
  spi::SharedSecret secret;
  DDSSEC_ASSIGN_OR_RETURN(secret.secret,
                          spi::SharedSecretOctets::copy_of({layout->shared_secret, size}));
  std::ranges::copy(layout->challenge1, secret.challenge1.begin());
  std::ranges::copy(layout->challenge2, secret.challenge2.begin());
  if (const auto* const ours = ExtendedSharedSecret::of(*layout)) {
    secret.peer_ciphers = ours->peer_ciphers;
    secret.peer_builtin_endpoints = ours->peer_builtin_endpoints;
    const auto prefix = GuidPrefix::from(ours->peer_prefix);
    if (!prefix.is_zero()) secret.peer_prefix = prefix;
    const auto own = GuidPrefix::from(BytesView(ours->own_guid).first(GuidPrefix::size));
    if (!own.is_zero()) secret.own_prefix = own;
  }
  return secret;
}

}  // namespace ddssec::cyclonedds
