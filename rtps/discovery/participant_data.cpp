#include "rtps/discovery/participant_data.hpp"

#include "rtps/discovery/parameter_table.hpp"
#include "rtps/discovery/security_parameters.hpp"
#include "rtps/qos/qos.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {
namespace {

using ParticipantRow = ParameterRow<ParticipantData>;

Status read_property_list(Reader& reader, PropertyList& out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read_count(8));
  if (count > kMaxProperties) return fail(Code::length_out_of_range);
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto name, read_bounded_string(reader, kMaxOpaqueOctets));
    DDSSEC_ASSIGN_OR_RETURN(auto value, read_bounded_string(reader, kMaxOpaqueOctets));
    out.push_back({std::move(name), std::move(value)});
  }
  return {};  // binary properties may follow; they are not needed
}

void write_property_list(SpanWriter& out, const PropertyList& properties) {
  const auto count = std::ranges::count_if(properties, &Property::propagate);
  if (count == 0) return;
  const ParameterScope scope(out, pid::kPropertyList);
  out.write(static_cast<std::uint32_t>(count));
  for (const auto& property : properties) {
    if (!property.propagate) continue;
    write_text(out, property.name);
    write_text(out, property.value);
  }
}

// Reads the parameter of Cyclone DDS: a version, flags, three words, and "HOST/VERSION/OS/CPU". Any
// other content is ignored.
Status read_vendor_version(Reader& reader, ParticipantData& data) {
  constexpr std::size_t kFixedPart = 20, kMaxText = 512, kMaxVersion = 32;
  if (!reader.skip(kFixedPart)) return {};
  const auto text = read_bounded_string(reader, kMaxText);
  if (!text) return {};
  const auto begin = text->find('/');
  const auto end = begin == text->npos ? text->npos : text->find('/', begin + 1);
  if (end != text->npos && end - begin <= kMaxVersion)
    data.vendor_version = text->substr(begin + 1, end - begin - 1);
  return {};
}

// Helpers for the table: each creates the row of one parameter.
template <ParameterId id, auto member>
constexpr ParticipantRow participant_locator_row() {
  return {id, [](Reader& r, ParticipantData& d) { return read_locator_into(r, d.*member); },
          [](SpanWriter& w, const ParticipantData& d) { write_locators(w, id, d.*member); }, true};
}

constexpr ParticipantRow kParticipantTable[] = {
    {pid::kProtocolVersion,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(const auto octets, r.read_bytes(2));
       d.version = ProtocolVersion::from(octets);
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       const ParameterScope scope(w, pid::kProtocolVersion);
       w.write_bytes(d.version.view());
     }},
    {pid::kVendorId,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(const auto octets, r.read_bytes(2));
       d.vendor = VendorId::from(octets);
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       const ParameterScope scope(w, pid::kVendorId);
       w.write_bytes(d.vendor.view());
     }},
    {pid::kAdlinkParticipantVersionInfo, read_vendor_version,
     [](SpanWriter&, const ParticipantData&) {}, true},
    {pid::kParticipantGuid,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.guid, read_guid(r));
       if (d.guid.entity != kEntityIdParticipant) return fail(Code::rtps_parameter_invalid);
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       const ParameterScope scope(w, pid::kParticipantGuid);
       w.write_bytes(d.guid.octets());
     },
     false, true},
    {pid::kDomainId,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.domain_id, r.read<std::uint32_t>());
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       if (!d.domain_id) return;
       const ParameterScope scope(w, pid::kDomainId);
       w.write(*d.domain_id);
     }},
    {pid::kDomainTag,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.domain_tag, read_bounded_string(r, kMaxNameLength));
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       if (d.domain_tag.empty()) return;
       const ParameterScope scope(w, pid::kDomainTag);
       write_text(w, d.domain_tag);
     }},
    {pid::kBuiltinEndpointSet,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.builtin_endpoints, r.read<std::uint32_t>());
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       const ParameterScope scope(w, pid::kBuiltinEndpointSet);
       w.write(d.builtin_endpoints);
     },
     false, true},
    {pid::kParticipantLeaseDuration,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.lease_duration, read_duration(r));
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       const ParameterScope scope(w, pid::kParticipantLeaseDuration);
       write_time(w, d.lease_duration);
     }},
    participant_locator_row<pid::kMetatrafficUnicastLocator,
                            &ParticipantData::metatraffic_unicast>(),
    participant_locator_row<pid::kMetatrafficMulticastLocator,
                            &ParticipantData::metatraffic_multicast>(),
    participant_locator_row<pid::kDefaultUnicastLocator, &ParticipantData::default_unicast>(),
    participant_locator_row<pid::kDefaultMulticastLocator, &ParticipantData::default_multicast>(),
    {pid::kParticipantManualLivelinessCount,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.manual_liveliness_count, r.read<std::int32_t>());
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       if (d.manual_liveliness_count == 0) return;
       const ParameterScope scope(w, pid::kParticipantManualLivelinessCount);
       w.write(d.manual_liveliness_count);
     }},
    {pid::kEntityName,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.entity_name, read_bounded_string(r, kMaxNameLength));
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       if (d.entity_name.empty()) return;
       const ParameterScope scope(w, pid::kEntityName);
       write_text(w, d.entity_name);
     }},
    {pid::kUserData,
     [](Reader& r, ParticipantData& d) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(d.user_data, read_opaque(r));
       return {};
     },
     [](SpanWriter& w, const ParticipantData& d) {
       if (d.user_data.empty()) return;
       const ParameterScope scope(w, pid::kUserData);
       write_opaque(w, d.user_data);
     }},
    {pid::kPropertyList,
     [](Reader& r, ParticipantData& d) { return read_property_list(r, d.properties); },
     [](SpanWriter& w, const ParticipantData& d) { write_property_list(w, d.properties); }},
    {pid::kIdentityToken,
     [](Reader& r, ParticipantData& d) { return read_token_into(r, d.identity_token); },
     [](SpanWriter& w, const ParticipantData& d) {
       write_token(w, pid::kIdentityToken, d.identity_token);
     }},
    {pid::kPermissionsToken,
     [](Reader& r, ParticipantData& d) { return read_token_into(r, d.permissions_token); },
     [](SpanWriter& w, const ParticipantData& d) {
       write_token(w, pid::kPermissionsToken, d.permissions_token);
     }},
    {pid::kParticipantSecurityInfo,
     [](Reader& r, ParticipantData& d) { return read_security_info_into(r, d.security_info); },
     [](SpanWriter& w, const ParticipantData& d) {
       write_security_info(w, pid::kParticipantSecurityInfo, d.security_info);
     }},
    {pid::kParticipantCiphers,
     [](Reader& r, ParticipantData& d) { return read_ciphers_into(r, d.ciphers); },
     [](SpanWriter& w, const ParticipantData& d) { write_ciphers(w, d.ciphers); }},
};

}  // namespace

void write_parameter_list(SpanWriter& out, const ParticipantData& data) {
  write_parameters<ParticipantData>(kParticipantTable, out, data);
}

void write_payload(SpanWriter& out, const ParticipantData& data) {
  write_pl_cdr_encapsulation(out);
  write_parameter_list(out, data);
}

Result<ParticipantData> read_participant_list(BytesView list, Endian endian) {
  return read_parameters<ParticipantData>(kParticipantTable, list, endian);
}

Result<ParticipantData> read_participant_data(BytesView payload) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_pl_cdr(payload));
  return read_participant_list(opened.body, opened.endian);
}

Result<Guid> read_participant_key(BytesView payload) {
  return read_guid_key(payload, pid::kParticipantGuid);
}

void write_participant_key(SpanWriter& out, const Guid& guid) {
  write_guid_key(out, pid::kParticipantGuid, guid);
}

bool is_of_domain(const ParticipantData& data, DomainId domain_id, std::string_view domain_tag) {
  const auto own = static_cast<std::uint32_t>(domain_id);
  return data.domain_id.value_or(own) == own && data.domain_tag == domain_tag;
}

}  // namespace ddssec::rtps
