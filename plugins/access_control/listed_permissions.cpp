#include "plugins/access_control/listed_permissions.hpp"

#include <algorithm>
#include <tuple>

namespace ddssec::access_control {
namespace {

/// Subjects that are remembered; a host has fewer peers.
constexpr std::size_t kMostSubjects = 4096;

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

std::tuple<WallTime, WallTime, WallTime> order(const ListedPermissions::Found& one) {
  const auto& validity = one.grant->grant().validity;
  return {validity.not_before, one.document->signed_at(), validity.not_after};
}

}  // namespace

bool give_the_same(const governance::Grant& a, const governance::Grant& b, DomainId domain,
                   std::string_view tag) {
  return a.default_allow == b.default_allow &&
         std::ranges::equal(rules_for(a, domain, tag), rules_for(b, domain, tag),
                            [](const auto* x, const auto* y) { return say_the_same(*x, *y); });
}

bool supersedes(const ListedPermissions::Found& found, const ListedPermissions::Found& former) {
  const auto [begin, time, end] = order(found);
  const auto [former_begin, former_time, former_end] = order(former);
  return found.document != former.document &&
         std::tie(begin, time) > std::tie(former_begin, former_time);
}

bool is_valid(const ListedPermissions::Found& one, WallTime now) {
  return one.grant->grant().validity.contains(now) && one.document->check_signer(now);
}

bool is_later(const ListedPermissions::Found& found, const ListedPermissions::Found& former) {
  return order(found) > order(former);
}

Sha256Digest digest_of_file(std::string_view text) {
  constexpr std::string_view kNone("", 1);
  if (text.ends_with('\0')) text.remove_suffix(1);
  return sha256(as_bytes(text.empty() ? kNone : text));
}

ListedPermissions::ListedPermissions(const std::vector<Entry>& entries) {
  for (const auto& [file, document] : entries)
    if (files_.insert(file).second) documents_.push_back(document);
}

ListedPermissions::Documents ListedPermissions::documents_of(const Question& question) const {
  const std::lock_guard lock(mutex_);
  if (const auto known = of_subject_.find(question.shown); known != of_subject_.end())
    return known->second;
  Documents out;
  std::ranges::copy_if(documents_, std::back_inserter(out), [&](const auto& document) {
    return document->has_grant_for(question.subject);
  });
  if (of_subject_.size() >= kMostSubjects) of_subject_.clear();
  of_subject_.emplace(question.shown, out);
  return out;
}

// A document for other domains is none for this one.
bool ListedPermissions::says_something(const governance::Grant& grant, const Question& question) {
  return grant.default_allow || !rules_for(grant, question.domain, question.tag).empty();
}

std::optional<ListedPermissions::Found> ListedPermissions::latest(const Question& question) const {
  std::optional<Found> out;
  for (const auto& document : documents_of(question)) {
    if (!question.ca.holds(document->signer())) continue;
    auto grant =
        document->begun_grant_for(question.subject, question.domain, question.tag, question.now);
    if (!grant || !says_something(grant->grant(), question)) continue;
    Found found{document, std::move(grant)};
    if (!out || order(*out) < order(found)) out = std::move(found);
  }
  return out;
}

}  // namespace ddssec::access_control
