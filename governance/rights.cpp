#include "governance/rights.hpp"

namespace ddssec::governance {
namespace {

std::vector<Text> texts_of(const std::vector<std::string>& expressions) {
  std::vector<Text> out;
  out.reserve(expressions.size());
  for (const auto& expression : expressions) out.push_back({expression, 0});
  return out;
}

std::vector<Criteria> criteria_of(const std::vector<std::string>& topics,
                                  const std::vector<std::string>& partitions) {
  if (topics.empty()) return {};
  Criteria out{.topics = texts_of(topics)};
  if (!partitions.empty()) out.partitions = texts_of(partitions);
  return {out};
}

}  // namespace

Grant grant_of(std::string name, const pki::Certificate& certificate, const Rights& rights,
               Validity validity) {
  enum class Kind : std::uint8_t { deny, allow };
  const auto rule = [&](Kind kind, const auto& publish, const auto& subscribe,
                        const std::vector<std::string>& partitions) {
    return GrantRule{.allow = kind == Kind::allow,
                     .domains = {.ranges = rights.domains},
                     .publish = criteria_of(publish, partitions),
                     .subscribe = criteria_of(subscribe, partitions)};
  };
  const std::vector<std::string> none;
  Grant grant{.name = std::move(name), .subject_name = certificate.subject(), .validity = validity};
  if (!rights.deny_publish.empty() || !rights.deny_subscribe.empty()) {
    // The first rule for a domain decides which participants join it (DDS-Security 1.2 table 70).
    grant.rules.push_back(rule(Kind::allow, none, none, {}));
    grant.rules.push_back(rule(Kind::deny, rights.deny_publish, rights.deny_subscribe, {}));
  }
  // The schema requires a rule. A rule without topics only lets the participant join.
  grant.rules.push_back(rule(Kind::allow, rights.publish, rights.subscribe, rights.partitions));
  return grant;
}

}  // namespace ddssec::governance
