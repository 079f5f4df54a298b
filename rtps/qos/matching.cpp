#include "rtps/qos/matching.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace ddssec::rtps {
namespace {

template <std::size_t N, class E>
std::string name(const std::array<std::string_view, N>& names, E value) {
  const auto index = static_cast<std::size_t>(value);
  return index < N ? std::string(names[index]) : fmt::format("{}", index);
}

constexpr std::array<std::string_view, 3> kReliability = {"0", "BEST_EFFORT", "RELIABLE"};
constexpr std::array<std::string_view, 4> kDurability = {"VOLATILE", "TRANSIENT_LOCAL", "TRANSIENT",
                                                         "PERSISTENT"};
constexpr std::array<std::string_view, 3> kLiveliness = {"AUTOMATIC", "MANUAL_BY_PARTICIPANT",
                                                         "MANUAL_BY_TOPIC"};
constexpr std::array<std::string_view, 2> kOwnership = {"SHARED", "EXCLUSIVE"};
constexpr std::array<std::string_view, 2> kOrder = {"BY_RECEPTION_TIMESTAMP",
                                                    "BY_SOURCE_TIMESTAMP"};
constexpr std::array<std::string_view, 3> kScope = {"INSTANCE", "TOPIC", "GROUP"};
constexpr std::array<std::string_view, 3> kRepresentation = {"XCDR1", "XML", "XCDR2"};

// Compares nanoseconds, so that the result does not depend on how a peer rounds fractions.
bool exceeds(const Duration& offered, const Duration& requested) {
  return offered.to_nanoseconds() > requested.to_nanoseconds();
}

std::string yes_or_no(bool value) { return value ? "true" : "false"; }

std::string representations(const std::vector<DataRepresentation>& list) {
  std::vector<std::string> names;
  for (auto entry : list) names.push_back(name(kRepresentation, entry));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string partitions(const std::vector<std::string>& list) {
  if (list.empty()) return "\"\"";
  return fmt::format("\"{}\"", fmt::join(list, "\", \""));
}

bool has_wildcard(std::string_view text) { return text.find_first_of("*?[") != text.npos; }

bool one_matches(std::string_view a, std::string_view b) {
  if (has_wildcard(a)) return !has_wildcard(b) && glob_match(a, b);
  return has_wildcard(b) ? glob_match(b, a) : a == b;
}

// The set after a '[': whether it contains `c`, and its size. Without a ']' the '[' is an ordinary
// character.
struct SetMatch {
  bool contains;
  std::size_t size;
};
std::optional<SetMatch> match_set(std::string_view set, char c) {
  const bool negated = !set.empty() && (set[0] == '!' || set[0] == '^');
  const std::size_t begin = negated ? 1 : 0;
  bool found = false;
  for (std::size_t i = begin; i < set.size(); ++i) {
    if (set[i] == ']' && i > begin) return SetMatch{found != negated, i + 1};
    if (i + 2 < set.size() && set[i + 1] == '-' && set[i + 2] != ']') {
      found = found || (set[i] <= c && c <= set[i + 2]);
      i += 2;
    } else {
      found = found || set[i] == c;
    }
  }
  return std::nullopt;
}

// Returns how many pattern characters match the one text character, 0 if none does. `may_close`
// means that there is a ']' late enough to end a set that begins here. Otherwise each '[' would
// cause a useless search to the end.
std::size_t match_one(std::string_view pattern, char c, bool may_close) {
  if (pattern.empty()) return 0;
  if (pattern[0] == '?') return 1;
  if (pattern[0] == '[' && may_close) {
    if (const auto set = match_set(pattern.substr(1), c)) return set->contains ? 1 + set->size : 0;
  }
  if (pattern[0] == '\\' && pattern.size() > 1) return pattern[1] == c ? 2 : 0;
  return pattern[0] == c ? 1 : 0;
}

}  // namespace

bool glob_match(std::string_view pattern, std::string_view text) {
  const auto last_close = pattern.rfind(']');
  const auto may_close = [&](std::size_t at) {
    return last_close != pattern.npos && last_close > at + 1;
  };
  std::size_t p = 0, t = 0, star = pattern.npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = ++p;
      resume = t;
    } else if (const auto used = match_one(pattern.substr(p), text[t], may_close(p))) {
      p += used;
      ++t;
    } else if (star != pattern.npos) {
      p = star;
      t = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == pattern.npos;
}

bool partitions_match(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  static const std::vector<std::string> kDefault = {""};
  const auto& left = a.empty() ? kDefault : a;
  const auto& right = b.empty() ? kDefault : b;
  return std::ranges::any_of(left, [&](const auto& one) {
    return std::ranges::any_of(right, [&](const auto& other) { return one_matches(one, other); });
  });
}

std::optional<QosMismatch> mismatch(const Qos& offered, const Qos& requested) {
  using Id = QosPolicyId;
  if (offered.reliability.kind < requested.reliability.kind)
    return QosMismatch{Id::reliability, "RELIABILITY.kind",
                       name(kReliability, offered.reliability.kind),
                       name(kReliability, requested.reliability.kind)};
  if (offered.durability < requested.durability)
    return QosMismatch{Id::durability, "DURABILITY.kind", name(kDurability, offered.durability),
                       name(kDurability, requested.durability)};
  const auto& have = offered.presentation;
  const auto& want = requested.presentation;
  if (have.scope < want.scope)
    return QosMismatch{Id::presentation, "PRESENTATION.access_scope", name(kScope, have.scope),
                       name(kScope, want.scope)};
  if (want.coherent_access && !have.coherent_access)
    return QosMismatch{Id::presentation, "PRESENTATION.coherent_access", yes_or_no(false),
                       yes_or_no(true)};
  if (want.ordered_access && !have.ordered_access)
    return QosMismatch{Id::presentation, "PRESENTATION.ordered_access", yes_or_no(false),
                       yes_or_no(true)};
  if (exceeds(offered.deadline, requested.deadline))
    return QosMismatch{Id::deadline, "DEADLINE.period", to_string(offered.deadline),
                       to_string(requested.deadline)};
  if (exceeds(offered.latency_budget, requested.latency_budget))
    return QosMismatch{Id::latency_budget, "LATENCY_BUDGET.duration",
                       to_string(offered.latency_budget), to_string(requested.latency_budget)};
  if (offered.ownership != requested.ownership)
    return QosMismatch{Id::ownership, "OWNERSHIP.kind", name(kOwnership, offered.ownership),
                       name(kOwnership, requested.ownership)};
  if (offered.liveliness.kind < requested.liveliness.kind)
    return QosMismatch{Id::liveliness, "LIVELINESS.kind",
                       name(kLiveliness, offered.liveliness.kind),
                       name(kLiveliness, requested.liveliness.kind)};
  if (exceeds(offered.liveliness.lease_duration, requested.liveliness.lease_duration))
    return QosMismatch{Id::liveliness, "LIVELINESS.lease_duration",
                       to_string(offered.liveliness.lease_duration),
                       to_string(requested.liveliness.lease_duration)};
  if (offered.destination_order < requested.destination_order)
    return QosMismatch{Id::destination_order, "DESTINATION_ORDER.kind",
                       name(kOrder, offered.destination_order),
                       name(kOrder, requested.destination_order)};
  // The writer uses its first representation, which the reader must support (XTypes 7.6.3.1.1).
  if (offered.data_representation.empty() ||
      std::ranges::find(requested.data_representation, offered.data_representation.front()) ==
          requested.data_representation.end())
    return QosMismatch{Id::data_representation, "DATA_REPRESENTATION",
                       representations(offered.data_representation),
                       representations(requested.data_representation)};
  if (!partitions_match(offered.partition, requested.partition))
    return QosMismatch{Id::partition, "PARTITION", partitions(offered.partition),
                       partitions(requested.partition)};
  return std::nullopt;
}

std::string remedy(const QosMismatch& mismatch) {
  using Id = QosPolicyId;
  const auto& [id, policy, offered, requested] = mismatch;
  if (id == Id::partition) return "give the publisher and the subscriber a partition in common";
  if (id == Id::type_consistency_enforcement)
    return "use one type on both sides, or loosen TYPE_CONSISTENCY_ENFORCEMENT of the reader";
  if (id == Id::data_representation)
    return "add the writer's first representation to the reader's DATA_REPRESENTATION";
  const bool is_time =
      id == Id::deadline || id == Id::latency_budget || policy.ends_with("lease_duration");
  if (is_time)
    return fmt::format("shorten the writer's {} to {} or lengthen the reader's to {}", policy,
                       requested, offered);
  return fmt::format("set {} of the writer to {}, or of the reader to {}", policy, requested,
                     offered);
}

}  // namespace ddssec::rtps
