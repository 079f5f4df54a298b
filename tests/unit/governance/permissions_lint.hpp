// What the lint tests of permissions share: documents of one grant, and their findings.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "governance/lint.hpp"
#include "governance/profile.hpp"
#include "governance/rights.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {

inline const pki::Certificate& certificate() {
  static const auto made = make_leaf(pki::make_ca(), "CN=talker,O=A\\, B,C=DE").certificate;
  return made;
}

inline Rights rights(std::vector<std::string> publish, std::vector<std::string> subscribe = {}) {
  return {.domains = {{0, 0}}, .publish = std::move(publish), .subscribe = std::move(subscribe)};
}

inline Grant grant_for(const Rights& rights) {
  return grant_of("talker", certificate(), rights,
                  {certificate().not_before(), certificate().not_after()});
}

/// Writes the document and reads it again, so that it has line numbers.
inline Permissions read_again(const Permissions& document) {
  auto again = permissions_from(to_xml(document));
  EXPECT_TRUE(again) << again.error().to_sentence();
  return *std::move(again);
}
inline Permissions with(const Rights& rights) {
  return read_again({.grants = {grant_for(rights)}});
}
inline Permissions changed(const std::function<void(Grant&)>& change,
                           const Rights& base = rights({"a"})) {
  auto grant = grant_for(base);
  change(grant);
  return read_again({.grants = {std::move(grant)}});
}

inline GrantRule rule(bool allow, std::vector<std::string> publish,
                      std::vector<std::string> subscribe = {}) {
  auto out = grant_for(rights(std::move(publish), std::move(subscribe))).rules.at(0);
  out.allow = allow;
  return out;
}
inline Permissions with_rules(std::vector<GrantRule> rules) {
  return changed([&](Grant& grant) { grant.rules = std::move(rules); });
}

/// Returns the findings except PERM026, which many short documents of these tests would have.
inline std::vector<Finding> lint_but_joining(const Permissions& document,
                                             const PermissionsUse& use = {}) {
  auto found = lint(document, use);
  std::erase_if(found, [](const Finding& f) { return f.rule == ddssec::Rule::PERM026; });
  return found;
}

/// Returns the only finding of the whole document.
inline Finding only(const Permissions& document, const PermissionsUse& use = {}) {
  const auto found = lint_but_joining(document, use);
  EXPECT_EQ(found.size(), 1u);
  for (const auto& finding : found) {
    EXPECT_TRUE(finding.path.starts_with("/dds/permissions")) << finding.path;
    EXPECT_GT(finding.line, 0);
    if (found.size() > 1) ADD_FAILURE() << info(finding.rule).id << ' ' << finding.message;
  }
  return found.empty() ? Finding{ddssec::Rule::end_, ""} : found.front();
}

}  // namespace ddssec::governance
