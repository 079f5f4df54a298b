#include "plugins/access_control/listed_permissions.hpp"

#include <algorithm>

#include "governance/grant_extension.hpp"

namespace ddssec::access_control {
namespace {

// The largest number of subjects that are remembered; a host has fewer peers.
constexpr std::size_t kMaxSubjects = 4096;

}  // namespace

bool give_same_rights(const governance::Grant& a, const governance::Grant& b, DomainId domain,
                      std::string_view tag) {
  return a.default_allow == b.default_allow &&
         governance::have_same_rules(governance::rules_for(a, domain, tag),
                                     governance::rules_for(b, domain, tag));
}

bool gives_at_least(const governance::Grant& next, const governance::Grant& former, DomainId domain,
                    std::string_view tag) {
  const auto next_rules = governance::rules_for(next, domain, tag);
  const auto former_rules = governance::rules_for(former, domain, tag);
  return governance::gives_at_least({next_rules, next.default_allow},
                                    {former_rules, former.default_allow});
}

// The same second does not count as earlier.
bool is_signed_later(const PermissionsDocument& next, const PermissionsDocument& former) {
  const auto since = former.signing_time(), time = next.signing_time();
  return !since || (time && *time >= *since);
}

// A certificate is valid up to and including its last second.
WallTime end_of(const GrantOfDocument& one) {
  return std::min(one.grant->grant().validity.not_after,
                  one.document->signer_not_after() + std::chrono::seconds(1));
}

ListedPermissions::Documents ListedPermissions::documents_for(
    const PresentedPermissions& presented) const {
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

std::optional<GrantOfDocument> ListedPermissions::extension_of(
    const PresentedPermissions& presented, const PermissionsCa& ca, WallTime now) const {
  const auto& [subject, shown, domain, tag, former_document, former, by] = presented;
  std::optional<GrantOfDocument> out;
  for (const auto& document : documents_for(presented)) {
    if (!ca.holds(document->signer())) continue;
    auto grant = document->grant_for(subject, shown, domain, tag, now);
    if (!grant || (*grant)->grant().subject_is_expression) continue;
    const auto& next = (*grant)->grant();
    // Permissions with fewer rights that were signed later are not extended by the former, wider
    // ones.
    const bool may_give_more =
        by == ExtendingRights::at_least_the_same && is_signed_later(*document, former_document);
    if (!give_same_rights(next, former, domain, tag) &&
        (!may_give_more || !gives_at_least(next, former, domain, tag)))
      continue;
    GrantOfDocument found{document, *std::move(grant)};
    if (!out || end_of(*out) < end_of(found)) out = std::move(found);
  }
  return out;
}

}  // namespace ddssec::access_control
