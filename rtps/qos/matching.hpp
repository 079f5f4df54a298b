// Request-offered matching of DDS 1.4 (2.2.3, table of policies) and XTypes 7.6.3.1.1.
#pragma once

#include <optional>

#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// QosPolicyId_t of DDS 1.4, as statuses report it.
enum class QosPolicyId : std::int32_t {
  invalid = 0,
  durability = 2,
  presentation = 3,
  deadline = 4,
  latency_budget = 5,
  ownership = 6,
  liveliness = 8,
  partition = 10,
  reliability = 11,
  destination_order = 12,
  data_representation = 23,
  type_consistency_enforcement = 24,
};

/// Why a writer and a reader do not match: the policy and both values, for a person.
struct QosMismatch {
  QosPolicyId id = QosPolicyId::invalid;
  std::string policy;  ///< "RELIABILITY.kind"
  std::string offered;
  std::string requested;
  bool operator==(const QosMismatch&) const = default;
};

/// Nothing if the reader gets what it asks for. PARTITION is reported as a mismatch too, although
/// it is no "incompatible QoS" for DDS: the caller tells by the id.
std::optional<QosMismatch> mismatch(const Qos& offered, const Qos& requested);

/// What to change at which side so that they match, for a person.
std::string remedy(const QosMismatch& mismatch);

/// True if any partition of one side fits any of the other; none at all is the partition "". Names
/// with wildcards (*, ?, [set]) match names without; two with wildcards never match.
bool partitions_match(const std::vector<std::string>& a, const std::vector<std::string>& b);

/// POSIX fnmatch without back-tracking into earlier stars: linear in text times pattern.
bool glob_match(std::string_view pattern, std::string_view text);

}  // namespace ddssec::rtps
