// Governance documents to compare.
#pragma once

#include "governance/model.hpp"

namespace ddssec::governance {

using Kind = ProtectionKind;

inline TopicRule topic(std::string expression, Kind data = Kind::encrypt, int line = 0) {
  TopicRule rule;
  rule.topic_expression = std::move(expression);
  rule.data_protection_kind = data;
  rule.line = line;
  return rule;
}

/// Returns a document with one domain rule for domain 0, in which every flag is set and every kind
/// is SIGN.
inline Governance document(std::vector<TopicRule> topics) {
  DomainRule rule;
  rule.domains.ranges = {{0, 0}};
  rule.discovery_protection_kind = Kind::sign;
  rule.liveliness_protection_kind = Kind::sign;
  rule.rtps_protection_kind = Kind::sign;
  rule.topic_rules = std::move(topics);
  rule.line = 2;
  Governance governance;
  governance.domain_rules = {rule};
  return governance;
}

inline Governance plain() {
  auto governance = document({topic("*", Kind::sign)});
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::sign;
  return governance;
}

}  // namespace ddssec::governance
