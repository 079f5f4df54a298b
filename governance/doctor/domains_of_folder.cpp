#include "governance/doctor/domains_of_folder.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "governance/doctor/checks.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::size_t kMaxCharacters = 128;

Domains intersection(const Domains& a, const Domains& b) {
  Domains out;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    const DomainRange both{std::max(i->first, j->first), std::min(i->last, j->last)};
    if (both.first <= both.last) out.push_back(both);
    if (i->last < j->last)
      ++i;
    else
      ++j;
  }
  return out;
}

DomainId domain_of(const Domains& named) {
  return named.empty() || contains(named, 0) ? 0 : named.front().first;
}

// Both lists are in the form of merged(), and so is the result.
Domains common(const Domains& governed, const Domains& granted) {
  if (governed.empty() || granted.empty()) return governed.empty() ? granted : governed;
  auto both = intersection(governed, granted);
  if (!both.empty()) return both;
  const auto one = domain_of(governed);
  return {{one, one}};
}

void append(Domains& out, const DomainSet& domains) {
  for (const auto& range : domains.ranges)
    out.push_back({std::clamp(range.first, 0, kMaxGovernedDomainId),
                   std::min(range.last, kMaxGovernedDomainId)});
}

Domains granted(const LoadedFolder& folder, WallTime now) {
  const auto* grant = grant_of(folder, now);
  if (grant == nullptr) return {};
  if (grant->default_allow) return {{0, kMaxGovernedDomainId}};
  Domains out;
  for (const auto& rule : grant->rules)
    if (rule.allow) append(out, rule.domains);
  return merged(std::move(out));
}

Domains governed(const LoadedFolder& folder) {
  Domains out;
  if (folder.governance.model)
    for (const auto& rule : folder.governance.model->domain_rules) append(out, rule.domains);
  return merged(std::move(out));
}

}  // namespace

Domains merged(Domains ranges) {
  std::ranges::sort(ranges, {}, &DomainRange::first);
  Domains out;
  for (const auto& range : ranges) {
    if (range.last < range.first) continue;
    if (!out.empty() && range.first <= out.back().last + 1)
      out.back().last = std::max(out.back().last, range.last);
    else
      out.push_back(range);
  }
  return out;
}

Domains domains_of(const LoadedFolder& folder, WallTime now) {
  return common(governed(folder), granted(folder, now));
}

std::optional<Contradiction> contradiction_of(const LoadedFolder& folder, WallTime now) {
  Contradiction out{governed(folder), granted(folder, now)};
  if (out.governed.empty() || out.granted.empty()) return std::nullopt;
  if (!intersection(out.governed, out.granted).empty()) return std::nullopt;
  out.line_of_governance = folder.governance.model->domain_rules.front().domains.line;
  const auto& rules = grant_of(folder, now)->rules;
  const auto allows = std::ranges::find(rules, true, &governance::GrantRule::allow);
  out.line_of_permissions = allows == rules.end() ? 0 : allows->domains.line;
  return out;
}

// The governance document is the same for all participants, so the participant's own permissions
// are more likely to be wrong.
MismatchTexts mismatch_texts(const LoadedFolder& folder, WallTime now) {
  const auto found = contradiction_of(folder, now);
  if (!found) return {};
  MismatchTexts out{
      fmt::format("; {}:{} allows only domain {}, and {}:{} covers only {}: the participant can "
                  "start in neither, and the permissions are probably wrong",
                  folder.paths.permissions.string(), found->line_of_permissions,
                  to_text(found->granted), folder.paths.governance.string(),
                  found->line_of_governance, to_text(found->governed)),
      {}};
  if (folder.paths.layout != pki::FolderLayout::sros2)
    out.hint = fmt::format(
        "sign permissions for domain {0}: ddssec permissions new --cert {1} --domain {0} ... "
        "--replace --sign --ca CA -o {2} (name all topics of the participant); or, if the "
        "governance document is wrong, add domain {3} to it and sign it again for all participants",
        found->governed.front().first, folder.paths.certificate.string(),
        std::filesystem::path(folder.paths.permissions).replace_extension("xml").string(),
        to_text(found->granted));
  return out;
}

DomainChoice choose_domain(std::span<const Domains> participants) {
  DomainChoice out;
  for (const auto& domains : participants) out.named = common(out.named, domains);
  out.domain = domain_of(out.named);
  return out;
}

bool contains(const Domains& domains, DomainId id) {
  return std::ranges::any_of(
      domains, [&](const DomainRange& range) { return range.first <= id && id <= range.last; });
}

std::string to_text(const Domains& domains) {
  std::string out;
  for (const auto& range : domains) {
    if (out.size() > kMaxCharacters) return out + ", ...";
    out += out.empty() ? "" : ", ";
    out += range.first == range.last ? std::to_string(range.first)
                                     : fmt::format("{}-{}", range.first, range.last);
  }
  return out;
}

}  // namespace ddssec::governance::doctor
