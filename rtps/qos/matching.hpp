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

/// The reason why a writer and a reader do not match: the policy and both values, as text.
struct QosMismatch {
  QosPolicyId id = QosPolicyId::invalid;
  std::string policy;  ///< for example "RELIABILITY.kind"
  std::string offered;
  std::string requested;
  bool operator==(const QosMismatch&) const = default;
};

/// Returns empty if the writer offers what the reader requests. PARTITION is also reported as a
/// mismatch, although DDS does not count it as "incompatible QoS"; the caller distinguishes it by
/// its id.
std::optional<QosMismatch> mismatch(const Qos& offered, const Qos& requested);

/// Returns a text that describes what to change on which side so that they match.
std::string remedy(const QosMismatch& mismatch);

/// True if any partition of one side matches any of the other. An empty list stands for the
/// partition "". Names with wildcards (*, ?, [set]) match names without; two names with wildcards
/// never match.
bool partitions_match(const std::vector<std::string>& a, const std::vector<std::string>& b);

/// Matches like POSIX fnmatch, but without backtracking into earlier stars. The time is
/// proportional to the product of the lengths of text and pattern.
bool glob_match(std::string_view pattern, std::string_view text);

}  // namespace ddssec::rtps
