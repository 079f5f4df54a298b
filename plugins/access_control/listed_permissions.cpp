#include "plugins/access_control/listed_permissions.hpp"

#include <algorithm>

namespace ddssec::access_control {
namespace {

/// Subjects that are remembered; a host has fewer peers.
constexpr std::size_t kMaxSubjects = 4096;

bool say_the_same(const governance::Criteria& a, const governance::Criteria& b) {
  return a.topics == b.topics && a.partitions == b.partitions && a.data_tags == b.data_tags;
}

bool say_the_same(const governance::Rule& a, const governance::Rule& b) {
  const auto equal = [](const auto& of_a, const auto& of_b) {
    return std::ranges::equal(of_a, of_b,
                              [](const auto& x, const auto& y) { return say_the_same(x, y); });
  };
  return a.allow == b.allow && equal(a.publish, b.publish) && equal(a.subscribe, b.subscribe) &&
         equal(a.relay, b.relay);
}

std::vector<const governance::Rule*> rules_for(const governance::Grant& grant, DomainId domain,
                                               std::string_view tag) {
  std::vector<const governance::Rule*> out;
  for (const auto& rule : grant.rules)
    if (rule.domains.contains(domain, tag)) out.push_back(&rule);
  return out;
}

}  // namespace

bool give_the_same(const governance::Grant& a, const governance::Grant& b, DomainId domain,
                   std::string_view tag) {
  return a.default_allow == b.default_allow &&
         std::ranges::equal(rules_for(a, domain, tag), rules_for(b, domain, tag),
                            [](const auto* x, const auto* y) { return say_the_same(*x, *y); });
}

// A certificate is valid up to and including its last second.
WallTime end_of(const GrantOfDocument& one) {
  return std::min(one.grant->grant().validity.not_after,
                  one.document->signer_not_after() + std::chrono::seconds(1));
}

ListedPermissions::Documents ListedPermissions::documents_for(const Presented& presented) const {
  const std::lock_guard lock(mutex_);
  if (const auto known = of_subject_.find(presented.shown); known != of_subject_.end())
    return known->second;
  Documents out;
  std::ranges::copy_if(documents_, std::back_inserter(out), [&](const auto& document) {
    return document->has_grant_for(presented.subject);
  });
  if (of_subject_.size() >= kMaxSubjects) of_subject_.clear();
  of_subject_.emplace(presented.shown, out);
  return out;
}

std::optional<GrantOfDocument> ListedPermissions::extension_of(const Presented& presented,
                                                               const PermissionsCa& ca,
                                                               WallTime now) const {
  const auto& [subject, shown, domain, tag, former] = presented;
  std::optional<GrantOfDocument> out;
  for (const auto& document : documents_for(presented)) {
    if (!ca.holds(document->signer())) continue;
    auto grant = document->grant_for(subject, shown, domain, tag, now);
    if (!grant || (*grant)->grant().subject_is_expression ||
        !give_the_same((*grant)->grant(), former, domain, tag))
      continue;
    GrantOfDocument found{document, *std::move(grant)};
    if (!out || end_of(*out) < end_of(found)) out = std::move(found);
  }
  return out;
}

}  // namespace ddssec::access_control
