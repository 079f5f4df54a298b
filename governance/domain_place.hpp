// A domain rule for lint, with its path in the document. For governance/ only.
#pragma once

#include <cstddef>
#include <string>

#include <fmt/format.h>

#include "base/finding.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// One domain rule, and where it stands.
struct DomainPlace {
  const DomainRule& rule;
  std::string path;

  std::string topic_path(std::size_t index) const {
    return fmt::format("{}/topic_access_rules/topic_rule[{}]", path, index + 1);
  }
  Finding about(Rule id, std::string message) const {
    return {.rule = id, .message = std::move(message), .line = rule.line, .path = path};
  }
  Finding about(Rule id, std::size_t topic, std::string message) const {
    return {.rule = id,
            .message = std::move(message),
            .line = rule.topic_rules[topic].line,
            .path = topic_path(topic)};
  }
};

}  // namespace ddssec::governance
