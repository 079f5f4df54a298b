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
  return a.allow == b.allow && a.domains == b.domains && equal(a.publish, b.publish) &&
         equal(a.subscribe, b.subscribe) && equal(a.relay, b.relay);
}

std::tuple<WallTime, WallTime, WallTime> order(const ListedPermissions::Found& one) {
  const auto& validity = one.grant->grant().validity;
  return {validity.not_before, one.document->signed_at(), validity.not_after};
}

}  // namespace

bool give_the_same(const governance::Grant& a, const governance::Grant& b) {
  return a.default_allow == b.default_allow &&
         std::ranges::equal(a.rules, b.rules,
                            [](const auto& x, const auto& y) { return say_the_same(x, y); });
}

bool is_later(const ListedPermissions::Found& found, const ListedPermissions::Found& former) {
  const auto [begin, time, end] = order(found);
  const auto [former_begin, former_time, former_end] = order(former);
  if (begin != former_begin) return begin > former_begin;
  if (time != former_time) return time > former_time;
  return end > former_end && give_the_same(found.grant->grant(), former.grant->grant());
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

std::optional<ListedPermissions::Found> ListedPermissions::latest(const Question& question) const {
  std::optional<Found> out;
  for (const auto& document : documents_of(question)) {
    auto grant = document->grant_for(question.subject, question.shown, question.domain,
                                     question.tag, question.now);
    if (!grant) continue;
    Found found{document, *std::move(grant)};
    if (!out || order(*out) < order(found)) out = std::move(found);
  }
  return out;
}

}  // namespace ddssec::access_control
