// Communication statuses of DDS 1.4, 2.2.4.1, with additional information for diagnosis.
#pragma once

#include <cstdint>
#include <map>

#include "base/ids.hpp"
#include "rtps/dcps/states.hpp"
#include "rtps/qos/matching.hpp"

namespace ddssec::rtps {

/// StatusKind of DDS 1.4; the bits are those of its IDL.
enum class StatusKind : std::uint32_t {
  inconsistent_topic = 1u << 0,
  offered_deadline_missed = 1u << 1,
  requested_deadline_missed = 1u << 2,
  offered_incompatible_qos = 1u << 5,
  requested_incompatible_qos = 1u << 6,
  sample_lost = 1u << 7,
  sample_rejected = 1u << 8,
  data_on_readers = 1u << 9,
  data_available = 1u << 10,
  liveliness_lost = 1u << 11,
  liveliness_changed = 1u << 12,
  publication_matched = 1u << 13,
  subscription_matched = 1u << 14,
};
using StatusMask = Mask<StatusKind>;
constexpr StatusMask operator|(StatusKind a, StatusKind b) { return StatusMask(a) | b; }
inline constexpr StatusMask kAnyStatus = StatusMask::any();

/// Total count, and the count since the application read the status or a listener was called for
/// it.
struct CountStatus {
  std::int32_t total_count = 0;
  std::int32_t total_count_change = 0;
};

/// INCONSISTENT_TOPIC: remote topics of the same name with another type.
struct InconsistentTopicStatus : CountStatus {};
/// SAMPLE_LOST: samples that will never arrive.
struct SampleLostStatus : CountStatus {};
/// LIVELINESS_LOST: how often the writer did not assert its liveliness within its lease.
struct LivelinessLostStatus : CountStatus {};

/// The limit of RESOURCE_LIMITS that a sample exceeded.
enum class SampleRejectedReason : std::uint8_t {
  not_rejected,
  by_instances_limit,
  by_samples_limit,
  by_samples_per_instance_limit
};
/// SAMPLE_REJECTED: samples that had no room within RESOURCE_LIMITS.
struct SampleRejectedStatus : CountStatus {
  SampleRejectedReason last_reason = SampleRejectedReason::not_rejected;
  InstanceHandle last_instance_handle;
};

/// OFFERED_ and REQUESTED_DEADLINE_MISSED.
struct DeadlineMissedStatus : CountStatus {
  InstanceHandle last_instance_handle;
};

/// OFFERED_ and REQUESTED_INCOMPATIBLE_QOS.
struct IncompatibleQosStatus : CountStatus {
  QosPolicyId last_policy_id = QosPolicyId::invalid;
  std::map<QosPolicyId, std::int32_t> policies;  ///< how often each policy was the reason
  QosMismatch last;                              ///< the policy and both values, as text
  Guid last_remote;                              ///< the endpoint that did not match
};

/// PUBLICATION_MATCHED and SUBSCRIPTION_MATCHED.
struct MatchedStatus : CountStatus {
  std::int32_t current_count = 0;
  std::int32_t current_count_change = 0;
  Guid last_remote;  ///< the endpoint that came or left (last_publication_handle, DDS 1.4)
};

/// LIVELINESS_CHANGED: the matched writers that are alive, and those that are not.
struct LivelinessChangedStatus {
  std::int32_t alive_count = 0;
  std::int32_t not_alive_count = 0;
  std::int32_t alive_count_change = 0;
  std::int32_t not_alive_count_change = 0;
  Guid last_remote;  ///< the writer whose liveliness changed (last_publication_handle, DDS 1.4)
};

}  // namespace ddssec::rtps
