// What the tests of comparing permissions share.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "governance/compare/permissions_diff.hpp"

namespace ddssec::governance::of_permissions {

inline WallTime at(int seconds) { return WallTime(std::chrono::seconds(seconds)); }

/// Returns a rule about publishing in domain 0.
inline GrantRule rule(bool allow, std::vector<Text> topics) {
  GrantRule rule{.allow = allow};
  rule.domains.ranges = {{0, 0}};
  rule.publish = {{.topics = std::move(topics)}};
  return rule;
}
inline GrantRule allow(std::vector<Text> topics) { return rule(true, std::move(topics)); }
inline GrantRule deny(std::vector<Text> topics) { return rule(false, std::move(topics)); }
/// Returns a rule that lets the participant join, and nothing more.
inline GrantRule join() { return {.allow = true, .domains = {.ranges = {{0, 0}}}}; }

inline Permissions document(std::vector<GrantRule> rules) {
  Grant grant{.name = "g", .subject_name = "CN=talker,O=Acme", .validity = {at(100), at(200)}};
  grant.rules = std::move(rules);
  grant.line = 3;
  Permissions permissions;
  permissions.grants = {grant};
  return permissions;
}

inline Grant grant_for(std::string subject, std::vector<GrantRule> rules) {
  auto grant = document(std::move(rules)).grants[0];
  grant.subject_name = std::move(subject);
  return grant;
}

inline const std::vector<GrantRule> kCmdDenied = {join(), deny({{"rt/cmd*"}}), allow({{"rt/*"}})};
inline const std::vector<GrantRule> kAll = {allow({{"rt/*"}})};

}  // namespace ddssec::governance::of_permissions
