#include "rtps/discovery/endpoint_data.hpp"

#include "rtps/discovery/parameter_table.hpp"
#include "rtps/discovery/security_parameters.hpp"
#include "wire/entity_ids.hpp"
#include "wire/submessage.hpp"
#include "wire/vendor.hpp"

namespace ddssec::rtps {
namespace {

// The data as read, before it is checked.
struct Announced {
  EndpointData data;
  std::optional<Guid> participant;
  bool has_reliability = false;
};

using Row = ParameterRow<Announced>;

template <class E>
Status read_enum(Reader& reader, E& value, E greatest) {
  DDSSEC_ASSIGN_OR_RETURN(const auto number, reader.read<std::uint32_t>());
  if (number > static_cast<std::uint32_t>(greatest)) return fail(Code::rtps_parameter_invalid);
  value = static_cast<E>(number);
  return {};
}

template <class E>
void write_enum(SpanWriter& out, E value) {
  out.write(static_cast<std::uint32_t>(value));
}

// Durations in QoS policies must not be negative.
Status read_duration_into(Reader& reader, Duration& value) {
  DDSSEC_ASSIGN_OR_RETURN(value, read_duration(reader));
  if (value < kDurationZero) return fail(Code::rtps_parameter_invalid);
  return {};
}

Status read_history(Reader& reader, History& value) {
  DDSSEC_RETURN_IF_ERROR(read_enum(reader, value.kind, HistoryKind::keep_all));
  DDSSEC_ASSIGN_OR_RETURN(value.depth, reader.read<std::int32_t>());
  return {};
}
void write_history(SpanWriter& out, const History& value) {
  write_enum(out, value.kind);
  out.write(value.depth);
}

Status read_limits(Reader& reader, ResourceLimits& value) {
  DDSSEC_ASSIGN_OR_RETURN(value.max_samples, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(value.max_instances, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(value.max_samples_per_instance, reader.read<std::int32_t>());
  return {};
}
void write_limits(SpanWriter& out, const ResourceLimits& value) {
  out.write(value.max_samples);
  out.write(value.max_instances);
  out.write(value.max_samples_per_instance);
}

template <ParameterId id, auto member>
constexpr Row text_row(bool required) {
  return {id,
          [](Reader& r, Announced& a) -> Status {
            DDSSEC_ASSIGN_OR_RETURN(a.data.*member, read_bounded_string(r, kMaxNameLength));
            return {};
          },
          [](SpanWriter& w, const Announced& a) {
            const ParameterScope scope(w, id);
            write_text(w, a.data.*member);
          },
          false, required};
}

template <ParameterId id, auto member>
constexpr Row opaque_row() {
  return {id,
          [](Reader& r, Announced& a) -> Status {
            DDSSEC_ASSIGN_OR_RETURN(a.data.qos.*member, read_opaque(r));
            return {};
          },
          [](SpanWriter& w, const Announced& a) {
            if ((a.data.qos.*member).empty()) return;
            const ParameterScope scope(w, id);
            write_opaque(w, a.data.qos.*member);
          }};
}

template <ParameterId id, auto member>
constexpr Row duration_row() {
  return {id, [](Reader& r, Announced& a) { return read_duration_into(r, a.data.qos.*member); },
          [](SpanWriter& w, const Announced& a) {
            if (a.data.qos.*member == Qos{}.*member) return;
            const ParameterScope scope(w, id);
            write_time(w, a.data.qos.*member);
          }};
}

template <ParameterId id, auto member, auto greatest>
constexpr Row enum_row() {
  return {id, [](Reader& r, Announced& a) { return read_enum(r, a.data.qos.*member, greatest); },
          [](SpanWriter& w, const Announced& a) {
            const ParameterScope scope(w, id);
            write_enum(w, a.data.qos.*member);
          }};
}

template <ParameterId id, auto member>
constexpr Row number_row() {
  return {id,
          [](Reader& r, Announced& a) -> Status {
            DDSSEC_ASSIGN_OR_RETURN(a.data.qos.*member, r.read<std::int32_t>());
            return {};
          },
          [](SpanWriter& w, const Announced& a) {
            if (a.data.qos.*member == 0) return;
            const ParameterScope scope(w, id);
            w.write(a.data.qos.*member);
          }};
}

template <ParameterId id, auto member>
constexpr Row locator_row() {
  return {id, [](Reader& r, Announced& a) { return read_locator_into(r, a.data.*member); },
          [](SpanWriter& w, const Announced& a) { write_locators(w, id, a.data.*member); }, true};
}

Status read_reliability(Reader& r, Announced& a) {
  auto& value = a.data.qos.reliability;
  DDSSEC_RETURN_IF_ERROR(read_enum(r, value.kind, ReliabilityKind::reliable));
  if (value.kind < ReliabilityKind::best_effort) return fail(Code::rtps_parameter_invalid);
  a.has_reliability = true;
  return read_duration_into(r, value.max_blocking_time);
}

Status read_partition(Reader& r, Announced& a) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, r.read_count(4));
  if (count > kMaxPartitions) return fail(Code::length_out_of_range);
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto name, read_bounded_string(r, kMaxNameLength));
    a.data.qos.partition.push_back(std::move(name));
  }
  return {};
}

void write_partition(SpanWriter& w, const Announced& a) {
  if (a.data.qos.partition.empty()) return;
  const ParameterScope scope(w, pid::kPartition);
  w.write(static_cast<std::uint32_t>(a.data.qos.partition.size()));
  for (const auto& name : a.data.qos.partition) write_text(w, name);
}

Status read_data_tags(Reader& r, Announced& a) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, r.read_count(8));
  if (count > kMaxDataTags) return fail(Code::length_out_of_range);
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto name, read_bounded_string(r, kMaxNameLength));
    DDSSEC_ASSIGN_OR_RETURN(auto value, read_bounded_string(r, kMaxNameLength));
    a.data.qos.data_tags.push_back({std::move(name), std::move(value)});
  }
  return {};
}

void write_data_tags(SpanWriter& w, const Announced& a) {
  if (a.data.qos.data_tags.empty()) return;
  const ParameterScope scope(w, pid::kDataTags);
  w.write(static_cast<std::uint32_t>(a.data.qos.data_tags.size()));
  for (const auto& tag : a.data.qos.data_tags) {
    write_text(w, tag.name);
    write_text(w, tag.value);
  }
}

Status read_representation(Reader& r, Announced& a) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, r.read_count(2));
  if (count > 8) return fail(Code::length_out_of_range);
  if (count == 0) return {};  // the same as an absent parameter
  a.data.qos.data_representation.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto representation, r.read<std::int16_t>());
    a.data.qos.data_representation.push_back(static_cast<DataRepresentation>(representation));
  }
  return {};
}

void write_representation(SpanWriter& w, const Announced& a) {
  if (a.data.qos.data_representation == Qos{}.data_representation) return;
  const ParameterScope scope(w, pid::kDataRepresentation);
  w.write(static_cast<std::uint32_t>(a.data.qos.data_representation.size()));
  for (auto entry : a.data.qos.data_representation) w.write(static_cast<std::int16_t>(entry));
}

Status read_presentation(Reader& r, Announced& a) {
  auto& value = a.data.qos.presentation;
  DDSSEC_RETURN_IF_ERROR(read_enum(r, value.scope, PresentationScope::group));
  DDSSEC_ASSIGN_OR_RETURN(const auto coherent_access, r.read<std::uint8_t>());
  value.coherent_access = coherent_access != 0;
  DDSSEC_ASSIGN_OR_RETURN(const auto ordered_access, r.read<std::uint8_t>());
  value.ordered_access = ordered_access != 0;
  return {};
}

Status read_liveliness(Reader& r, Announced& a) {
  DDSSEC_RETURN_IF_ERROR(read_enum(r, a.data.qos.liveliness.kind, LivelinessKind::manual_by_topic));
  return read_duration_into(r, a.data.qos.liveliness.lease_duration);
}

// ddssec's own parameter has the minimal TypeObjects after a mark that a parameter of another
// vendor with the same id would not have.
constexpr std::array<std::uint8_t, 8> kTypeObjectsMark = {'d', 'd', 's', 's', 'e', 'c', 'T', 'O'};

// An announcement with a malformed type is not refused: the names decide then.
Status read_type_information(Reader& r, Announced& a) {
  if (r.endian() == Endian::little && r.remaining() <= kMaxTypeInformation)
    a.data.type.information = to_bytes(r.rest());
  return {};
}

Status read_type_objects(Reader& r, Announced& a) {
  const auto octets = r.rest();
  const auto mark = kTypeObjectsMark.size();
  if (octets.size() > mark && octets.size() - mark <= kMaxTypeObjects &&
      std::ranges::equal(octets.first(mark), kTypeObjectsMark))
    a.data.type.objects = to_bytes(octets.subspan(mark));
  return {};
}

// Reads the kind and then five booleans. Older versions of the policy end earlier. Older OpenDDS
// versions count the kinds from 1, so that their ALLOW_TYPE_COERCION is 2.
Status read_type_consistency(Reader& r, Announced& a) {
  auto& value = a.data.qos.type_consistency;
  DDSSEC_ASSIGN_OR_RETURN(const auto kind, r.read<std::uint16_t>());
  if (kind > 2) return fail(Code::rtps_parameter_invalid);
  if (kind == 0) value.kind = TypeConsistencyKind::disallow_type_coercion;
  for (auto* flag :
       {&value.ignore_sequence_bounds, &value.ignore_string_bounds, &value.ignore_member_names,
        &value.prevent_type_widening, &value.force_type_validation}) {
    if (r.remaining() == 0) break;
    DDSSEC_ASSIGN_OR_RETURN(const auto octet, r.read<std::uint8_t>());
    *flag = octet != 0;
  }
  return {};
}

void write_type_consistency(SpanWriter& w, const Announced& a) {
  const auto& value = a.data.qos.type_consistency;
  if (value == TypeConsistency{} || !is_reader(a.data.guid.entity)) return;
  const ParameterScope scope(w, pid::kTypeConsistencyEnforcement);
  w.write(static_cast<std::uint16_t>(value.kind));
  for (const bool flag :
       {value.ignore_sequence_bounds, value.ignore_string_bounds, value.ignore_member_names,
        value.prevent_type_widening, value.force_type_validation})
    w.write(std::uint8_t{flag});
}

Status read_durability_service(Reader& r, Announced& a) {
  auto& value = a.data.qos.durability_service;
  DDSSEC_RETURN_IF_ERROR(read_duration_into(r, value.cleanup_delay));
  DDSSEC_RETURN_IF_ERROR(read_history(r, value.history));
  DDSSEC_RETURN_IF_ERROR(read_limits(r, value.limits));
  // An inconsistent policy, such as a history of 0 samples, is replaced by the default.
  if (!check_consistency(value)) value = {};
  return {};
}

constexpr Row kTable[] = {
    {pid::kEndpointGuid,
     [](Reader& r, Announced& a) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(a.data.guid, read_guid(r));
       return {};
     },
     [](SpanWriter& w, const Announced& a) {
       const ParameterScope scope(w, pid::kEndpointGuid);
       w.write_bytes(a.data.guid.octets());
     },
     false, true},
    {pid::kParticipantGuid,
     [](Reader& r, Announced& a) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(a.participant, read_guid(r));
       return {};
     },
     [](SpanWriter& w, const Announced& a) {
       const ParameterScope scope(w, pid::kParticipantGuid);
       w.write_bytes(Guid{a.data.guid.prefix, kEntityIdParticipant}.octets());
     }},
    {pid::kProtocolVersion, [](Reader&, Announced&) { return Status{}; },
     [](SpanWriter& w, const Announced&) {
       const ParameterScope scope(w, pid::kProtocolVersion);
       w.write_bytes(kProtocolVersion.view());
     }},
    {pid::kVendorId, [](Reader&, Announced&) { return Status{}; },
     [](SpanWriter& w, const Announced&) {
       const ParameterScope scope(w, pid::kVendorId);
       w.write_bytes(kVendorDdssec.view());
     }},
    text_row<pid::kTopicName, &EndpointData::topic_name>(true),
    text_row<pid::kTypeName, &EndpointData::type_name>(true),
    {pid::kTypeInformation, read_type_information,
     [](SpanWriter& w, const Announced& a) {
       if (a.data.type.information.empty()) return;
       const ParameterScope scope(w, pid::kTypeInformation);
       w.write_bytes(a.data.type.information);
     }},
    {pid::kTypeObjects, read_type_objects,
     [](SpanWriter& w, const Announced& a) {
       if (a.data.type.objects.empty()) return;
       const ParameterScope scope(w, pid::kTypeObjects);
       w.write_bytes(kTypeObjectsMark);
       w.write_bytes(a.data.type.objects);
     }},
    {pid::kReliability, read_reliability,
     [](SpanWriter& w, const Announced& a) {
       const ParameterScope scope(w, pid::kReliability);
       write_enum(w, a.data.qos.reliability.kind);
       write_time(w, a.data.qos.reliability.max_blocking_time);
     }},
    enum_row<pid::kDurability, &Qos::durability, DurabilityKind::persistent>(),
    {pid::kDurabilityService, read_durability_service,
     [](SpanWriter& w, const Announced& a) {
       const auto& value = a.data.qos.durability_service;
       if (value == DurabilityService{}) return;
       const ParameterScope scope(w, pid::kDurabilityService);
       write_time(w, value.cleanup_delay);
       write_history(w, value.history);
       write_limits(w, value.limits);
     }},
    {pid::kHistory, [](Reader& r, Announced& a) { return read_history(r, a.data.qos.history); },
     [](SpanWriter& w, const Announced& a) {
       const ParameterScope scope(w, pid::kHistory);
       write_history(w, a.data.qos.history);
     }},
    {pid::kResourceLimits,
     [](Reader& r, Announced& a) { return read_limits(r, a.data.qos.resource_limits); },
     [](SpanWriter& w, const Announced& a) {
       if (a.data.qos.resource_limits == ResourceLimits{}) return;
       const ParameterScope scope(w, pid::kResourceLimits);
       write_limits(w, a.data.qos.resource_limits);
     }},
    duration_row<pid::kDeadline, &Qos::deadline>(),
    duration_row<pid::kLatencyBudget, &Qos::latency_budget>(),
    duration_row<pid::kLifespan, &Qos::lifespan>(),
    duration_row<pid::kTimeBasedFilter, &Qos::time_based_filter>(),
    {pid::kLiveliness, read_liveliness,
     [](SpanWriter& w, const Announced& a) {
       if (a.data.qos.liveliness == Liveliness{}) return;
       const ParameterScope scope(w, pid::kLiveliness);
       write_enum(w, a.data.qos.liveliness.kind);
       write_time(w, a.data.qos.liveliness.lease_duration);
     }},
    enum_row<pid::kOwnership, &Qos::ownership, OwnershipKind::exclusive>(),
    number_row<pid::kOwnershipStrength, &Qos::ownership_strength>(),
    enum_row<pid::kDestinationOrder, &Qos::destination_order, DestinationOrderKind::by_source>(),
    {pid::kPresentation, read_presentation,
     [](SpanWriter& w, const Announced& a) {
       const auto& value = a.data.qos.presentation;
       if (value == Presentation{}) return;
       const ParameterScope scope(w, pid::kPresentation);
       write_enum(w, value.scope);
       w.write(std::uint8_t{value.coherent_access});
       w.write(std::uint8_t{value.ordered_access});
     }},
    {pid::kPartition, read_partition, write_partition},
    number_row<pid::kTransportPriority, &Qos::transport_priority>(),
    {pid::kDataRepresentation, read_representation, write_representation},
    {pid::kTypeConsistencyEnforcement, read_type_consistency, write_type_consistency},
    opaque_row<pid::kUserData, &Qos::user_data>(),
    opaque_row<pid::kGroupData, &Qos::group_data>(),
    opaque_row<pid::kTopicData, &Qos::topic_data>(),
    locator_row<pid::kUnicastLocator, &EndpointData::unicast>(),
    locator_row<pid::kMulticastLocator, &EndpointData::multicast>(),
    {pid::kGroupGuid,
     [](Reader& r, Announced& a) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(a.data.group_guid, read_guid(r));
       return {};
     },
     [](SpanWriter& w, const Announced& a) {
       if (!a.data.group_guid) return;
       const ParameterScope scope(w, pid::kGroupGuid);
       w.write_bytes(a.data.group_guid->octets());
     }},
    {pid::kExpectsInlineQos,
     [](Reader& r, Announced& a) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(const auto expects_inline_qos, r.read<std::uint8_t>());
       a.data.expects_inline_qos = expects_inline_qos != 0;
       return {};
     },
     [](SpanWriter& w, const Announced& a) {
       if (!a.data.expects_inline_qos) return;
       const ParameterScope scope(w, pid::kExpectsInlineQos);
       w.write(std::uint8_t{1});
     }},
    {pid::kContentFilterProperty,
     [](Reader& r, Announced& a) -> Status {
       DDSSEC_ASSIGN_OR_RETURN(a.data.content_filter, read_content_filter_property(r));
       return {};
     },
     [](SpanWriter& w, const Announced& a) {
       if (a.data.content_filter) write_content_filter_property(w, *a.data.content_filter);
     }},
    {pid::kDataTags, read_data_tags, write_data_tags},
    {pid::kEndpointSecurityInfo,
     [](Reader& r, Announced& a) { return read_security_info_into(r, a.data.security_info); },
     [](SpanWriter& w, const Announced& a) {
       write_security_info(w, pid::kEndpointSecurityInfo, a.data.security_info);
     }},
    {pid::kEndpointCiphers,
     [](Reader& r, Announced& a) { return read_ciphers_into(r, a.data.required_ciphers); },
     [](SpanWriter& w, const Announced& a) { write_ciphers(w, a.data.required_ciphers); }},
};

Result<EndpointData> read_endpoint(BytesView payload, bool (*is_kind)(const EntityId&),
                                   ReliabilityKind default_reliability) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_pl_cdr(payload));
  DDSSEC_ASSIGN_OR_RETURN(auto announced,
                          read_parameters<Announced>(kTable, opened.body, opened.endian));
  auto& data = announced.data;
  if (!is_kind(data.guid.entity)) return fail(Code::rtps_parameter_invalid);
  const Guid owner{data.guid.prefix, kEntityIdParticipant};
  if (announced.participant && *announced.participant != owner)
    return fail(Code::rtps_parameter_invalid);
  if (!announced.has_reliability) data.qos.reliability.kind = default_reliability;
  // A publisher belongs to the same participant, and no other participant takes part in its sets.
  // So the GUID of another participant's publisher is dropped.
  if (data.group_guid && data.group_guid->prefix != data.guid.prefix) data.group_guid.reset();
  // Only readers have this policy (XTypes 7.6.3.4); it is ignored in a writer's announcement.
  if (!is_reader(data.guid.entity)) data.qos.type_consistency = {};
  return std::move(data);
}

std::size_t octets_of(const std::vector<std::string>& texts) {
  std::size_t out = 0;
  for (const auto& text : texts) out += sizeof(text) + text.capacity();
  return out;
}

}  // namespace

std::size_t octets_of(const EndpointData& data) {
  auto out = sizeof(data) + data.topic_name.capacity() + data.type_name.capacity();
  for (const auto* octets : {&data.type.information, &data.type.objects, &data.qos.user_data,
                             &data.qos.topic_data, &data.qos.group_data})
    out += octets->capacity();
  out += octets_of(data.qos.partition);
  for (const auto& tag : data.qos.data_tags)
    out += sizeof(tag) + tag.name.capacity() + tag.value.capacity();
  out += (data.unicast.capacity() + data.multicast.capacity()) * sizeof(Locator);
  if (const auto& filter = data.content_filter)
    out += filter->content_filtered_topic_name.capacity() + filter->related_topic_name.capacity() +
           filter->filter_class_name.capacity() + filter->filter.expression.capacity() +
           octets_of(filter->filter.parameters);
  return out;
}

void write_payload(SpanWriter& out, const EndpointData& data) {
  write_pl_cdr_encapsulation(out);
  write_parameters<Announced>(kTable, out, Announced{data, {}, true});
}

Result<EndpointData> read_publication_data(BytesView payload) {
  return read_endpoint(payload, is_writer, ReliabilityKind::reliable);
}

Result<EndpointData> read_subscription_data(BytesView payload) {
  return read_endpoint(payload, is_reader, ReliabilityKind::best_effort);
}

Result<Guid> read_endpoint_key(BytesView payload) {
  return read_guid_key(payload, pid::kEndpointGuid);
}

void write_endpoint_key(SpanWriter& out, const Guid& guid) {
  write_guid_key(out, pid::kEndpointGuid, guid);
}

}  // namespace ddssec::rtps
