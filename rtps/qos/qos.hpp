// The quality-of-service policies of DDS 1.4, 2.2.3, that discovery carries, with their defaults.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/property.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// The kinds of the policies of DDS 1.4, 2.2.3, and of XTypes 1.3, 7.6.3. The numbers are those on
/// the wire (RTPS 9.6.3.2).
enum class ReliabilityKind : std::uint32_t { best_effort = 1, reliable = 2 };
enum class DurabilityKind : std::uint32_t { volatile_, transient_local, transient, persistent };
enum class HistoryKind : std::uint32_t { keep_last, keep_all };
enum class LivelinessKind : std::uint32_t { automatic, manual_by_participant, manual_by_topic };
enum class OwnershipKind : std::uint32_t { shared, exclusive };
enum class DestinationOrderKind : std::uint32_t { by_reception, by_source };
enum class PresentationScope : std::uint32_t { instance, topic, group };
enum class TypeConsistencyKind : std::uint16_t { disallow_type_coercion, allow_type_coercion };
enum class DataRepresentation : std::int16_t { xcdr1 = 0, xml = 1, xcdr2 = 2 };

inline constexpr std::int32_t kLengthUnlimited = -1;

/// RELIABILITY. A reliable writer that cannot keep a sample waits for at most max_blocking_time, by
/// default 100 ms.
struct Reliability {
  ReliabilityKind kind = ReliabilityKind::best_effort;
  Duration max_blocking_time{{0, 0x1999999a}};
  bool operator==(const Reliability&) const = default;
};
/// LIVELINESS: how, and at least how often, a writer asserts that it is alive.
struct Liveliness {
  LivelinessKind kind = LivelinessKind::automatic;
  Duration lease_duration = kDurationInfinite;
  bool operator==(const Liveliness&) const = default;
};
/// HISTORY: how many samples of each instance are kept. `depth` counts for KEEP_LAST only.
struct History {
  HistoryKind kind = HistoryKind::keep_last;
  std::int32_t depth = 1;
  bool operator==(const History&) const = default;
};
/// RESOURCE_LIMITS: how much a writer or a reader may hold.
struct ResourceLimits {
  std::int32_t max_samples = kLengthUnlimited;
  std::int32_t max_instances = kLengthUnlimited;
  std::int32_t max_samples_per_instance = kLengthUnlimited;
  bool operator==(const ResourceLimits&) const = default;
};
/// DURABILITY_SERVICE: what a service keeps of a TRANSIENT or PERSISTENT writer (ddssec-keeper),
/// and how long it keeps an instance that is disposed and has no writers.
struct DurabilityService {
  Duration cleanup_delay = kDurationZero;
  History history;
  ResourceLimits limits;
  bool operator==(const DurabilityService&) const = default;
};
/// How long a reader keeps the samples of an instance that has no writers, or is disposed.
struct ReaderDataLifecycle {
  Duration autopurge_nowriter_samples_delay = kDurationInfinite;
  Duration autopurge_disposed_samples_delay = kDurationInfinite;
  bool operator==(const ReaderDataLifecycle&) const = default;
};
/// PRESENTATION: whether sets of samples become visible together (coherent_access) and in order
/// (ordered_access), and within which scope.
struct Presentation {
  PresentationScope scope = PresentationScope::instance;
  bool coherent_access = false;
  bool ordered_access = false;
  bool operator==(const Presentation&) const = default;
};

/// TYPE_CONSISTENCY_ENFORCEMENT of a reader (XTypes 7.6.3.4): which writers' types it accepts. Only
/// kind and force_type_validation have an effect without ALLOW_TYPE_COERCION.
struct TypeConsistency {
  TypeConsistencyKind kind = TypeConsistencyKind::allow_type_coercion;
  bool ignore_sequence_bounds = true;
  bool ignore_string_bounds = true;
  bool ignore_member_names = false;
  bool prevent_type_widening = false;  ///< refuse writers whose type has more members
  /// Refuse types that cannot be compared; otherwise their names decide.
  bool force_type_validation = false;
  bool operator==(const TypeConsistency&) const = default;
};

/// The policies of a reader or a writer, including those of the topic, publisher and subscriber
/// that discovery announces with it. A default-constructed object has the defaults of a reader.
struct Qos {
  Reliability reliability;
  DurabilityKind durability = DurabilityKind::volatile_;
  DurabilityService durability_service;
  History history;
  ResourceLimits resource_limits;
  Duration deadline = kDurationInfinite;
  Duration latency_budget = kDurationZero;
  Duration lifespan = kDurationInfinite;
  Liveliness liveliness;
  OwnershipKind ownership = OwnershipKind::shared;
  std::int32_t ownership_strength = 0;
  DestinationOrderKind destination_order = DestinationOrderKind::by_reception;
  Presentation presentation;
  std::vector<std::string> partition;
  Duration time_based_filter = kDurationZero;
  std::int32_t transport_priority = 0;
  std::vector<DataRepresentation> data_representation = {DataRepresentation::xcdr1};
  TypeConsistency type_consistency;  ///< for readers only
  Bytes user_data, topic_data, group_data;
  /// PROPERTY (DDS-Security 1.2, clause 7.3.21), for the plugins of ddssec; not announced.
  PropertyList properties;
  /// DATA_TAGS (DDS-Security 1.2, clause 7.3.21), to which <data_tags> in the permissions refer.
  /// Announced only if discovery of the topic is protected.
  PropertyList data_tags;
  ReaderDataLifecycle reader_data_lifecycle;  ///< not announced
  /// WRITER_DATA_LIFECYCLE: unregistering an instance, or deleting the writer, also disposes the
  /// instance. Not announced.
  bool autodispose_unregistered_instances = true;
  bool operator==(const Qos&) const = default;

  bool is_reliable() const { return reliability.kind == ReliabilityKind::reliable; }
};

/// Returns the defaults of DDS 1.4 for readers: RELIABILITY is BEST_EFFORT.
inline Qos default_reader_qos() { return {}; }
/// Returns the defaults of DDS 1.4 for writers: RELIABILITY is RELIABLE.
inline Qos default_writer_qos() {
  Qos qos;
  qos.reliability.kind = ReliabilityKind::reliable;
  return qos;
}

/// The largest numbers of partitions of one endpoint, and of characters of a name (DDS 1.4,
/// 2.2.3.13).
inline constexpr std::size_t kMaxPartitions = 64;
inline constexpr std::size_t kMaxNameLength = 256;
/// The largest number of data tags of one endpoint.
inline constexpr std::size_t kMaxDataTags = 64;

/// Refuses a change of a policy that must not change once an entity is enabled (DDS 1.4, 2.2.3,
/// "changeable"). The error names the policy. Errors: rtps_immutable_policy.
Status check_mutable(const Qos& from, const Qos& to);

/// Refuses contradictory policies (DDS 1.4, 2.2.3: "inconsistent"). The error names policy and
/// values. Errors: rtps_qos_inconsistent.
Status check_consistency(const Qos& qos);
Status check_consistency(const DurabilityService& service);

}  // namespace ddssec::rtps
