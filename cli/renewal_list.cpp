#include "cli/renewal_list.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "cli/inputs.hpp"
#include "governance/read.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Its signature is not checked: the participants do that. Empty: it says nothing.
std::optional<ListedDocument> look_into(const Bytes& file) {
  const auto form = pki::examine_document(file);
  if (form.ambiguous) return std::nullopt;
  const auto document = governance::read_permissions(form.unverified_text, form.first_line);
  if (!document || document->grants.empty()) return std::nullopt;
  ListedDocument out{.file = file};
  for (const auto& grant : document->grants) {
    out.subjects.push_back(grant.subject_name);
    out.end = std::max(out.end, grant.validity.not_after);
  }
  return out;
}

std::vector<ListedDocument> documents_of(const pki::RenewalList& list, WallTime now) {
  std::vector<ListedDocument> out;
  for (const auto& file : list.permissions)
    if (auto one = look_into(file); one && one->end > now) out.push_back(*std::move(one));
  return out;
}

bool is_for_none_but(const ListedDocument& former, const ListedDocument& next) {
  return std::ranges::all_of(former.subjects, [&](const auto& subject) {
    return std::ranges::find(next.subjects, subject) != next.subjects.end();
  });
}

template <class Entry>
void keep_last(std::vector<Entry>& entries) {
  if (entries.size() <= pki::kMostRenewals) return;
  entries.erase(entries.begin(), entries.end() - static_cast<std::ptrdiff_t>(pki::kMostRenewals));
}

// `former` without what `next` replaces and what has ended, and then `next`.
pki::RenewalList merged(const pki::RenewalList& former, const pki::RenewalList& next,
                        WallTime now) {
  pki::RenewalList out;
  const auto is_replaced = [&](const pki::Certificate& old) {
    return std::ranges::find(next.certificates, old.subject_digest(),
                             &pki::Certificate::subject_digest) != next.certificates.end();
  };
  for (const auto& old : former.certificates)
    if (old.not_after() > now && !is_replaced(old)) out.certificates.push_back(old);
  for (const auto& one : next.certificates)
    if (one.not_after() > now) out.certificates.push_back(one);
  const auto later = documents_of(next, now);
  for (const auto& old : documents_of(former, now))
    if (std::ranges::none_of(later, [&](const auto& one) { return is_for_none_but(old, one); }))
      out.permissions.push_back(old.file);
  for (const auto& one : later) out.permissions.push_back(one.file);
  keep_last(out.certificates);
  keep_last(out.permissions);
  return out;
}

// What is there of CAs that the folder has: the others have no effect.
pki::RenewalList of_trusted(pki::RenewalList list, const pki::ParticipantFolder& files,
                            WallTime now) {
  const auto identity_cas = read_certificates(files.identity_ca);
  std::erase_if(list.certificates, [&](const auto& one) {
    return !identity_cas || std::ranges::none_of(*identity_cas, [&](const auto& ca) {
      return one.is_issued_by(ca);
    });
  });
  auto permissions_cas = read_certificates(files.permissions_ca);
  if (!permissions_cas) {
    list.permissions.clear();
    return list;
  }
  const auto verifier = pki::DocumentVerifier::make(*std::move(permissions_cas));
  std::erase_if(list.permissions,
                [&](const auto& one) { return !verifier || !verifier->verify(one, now); });
  return list;
}

// The CAs' own lists have what is still to count of them.
pki::RenewalList without_those_of(const std::vector<pki::Certificate>& cas, pki::RenewalList list,
                                  WallTime now) {
  if (cas.empty()) return list;
  std::erase_if(list.certificates, [&](const auto& one) {
    return std::ranges::any_of(cas, [&](const auto& ca) { return one.is_issued_by(ca); });
  });
  const auto verifier = pki::DocumentVerifier::make(cas);
  std::erase_if(list.permissions,
                [&](const auto& one) { return verifier && verifier->verify(one, now); });
  return list;
}

}  // namespace

Result<pki::RenewalList> read_renewals(const fs::path& file) {
  if (!is_there(file)) return pki::RenewalList{};
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMostRenewalListOctets));
  auto list = pki::RenewalList::parse(octets);
  return list ? *std::move(list) : pki::RenewalList{};
}

void NewlyListed::add(const CaPaths& ca, const pki::Certificate& renewed) {
  files_[ca.renewals].certificates.push_back(renewed);
}

void NewlyListed::add(const CaPaths& ca, BytesView signed_permissions) {
  files_[ca.renewals].permissions.push_back(to_bytes(signed_permissions));
}

Status NewlyListed::write(WallTime now) const {
  for (const auto& [file, entries] : files_) {
    DDSSEC_ASSIGN_OR_RETURN(const auto former, read_renewals(file));
    const auto list = merged(former, entries, now);
    if (list.is_empty()) continue;
    DDSSEC_ASSIGN_OR_RETURN(const auto text, list.text());
    Replacement out;
    DDSSEC_RETURN_IF_ERROR(out.put_public(file, text));
    DDSSEC_RETURN_IF_ERROR(out.commit_each());
  }
  return {};
}

Result<pki::RenewalList> renewals_of(const fs::path& given, const pki::Crl* revoked) {
  const auto identity = ca_paths(given, "identity").renewals;
  const auto permissions = ca_paths(given, "permissions").renewals;
  DDSSEC_ASSIGN_OR_RETURN(auto out, read_renewals(identity));
  if (permissions != identity) {
    DDSSEC_ASSIGN_OR_RETURN(auto more, read_renewals(permissions));
    std::ranges::move(more.permissions, std::back_inserter(out.permissions));
  }
  if (revoked == nullptr) return out;
  DDSSEC_ASSIGN_OR_RETURN(const auto entries, revoked->revoked());
  std::set<std::string> serials;
  for (const auto& entry : entries) serials.insert(entry.serial);
  std::erase_if(out.certificates, [&](const auto& one) { return serials.contains(one.serial()); });
  return out;
}

Status put_renewals(Replacement& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what) {
  DDSSEC_ASSIGN_OR_RETURN(auto former, read_renewals(files.renewals));
  former = without_those_of(what.cas, of_trusted(std::move(former), files, what.now), what.now);
  const auto list = merged(former, of_trusted(what.entries, files, what.now), what.now);
  if (list.is_empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto text, list.text());
  const auto present = read_file(files.renewals, pki::kMostRenewalListOctets);
  if (present && as_text(*present) == text) return {};
  return out.put_public(files.renewals, text);
}

std::string in_words(const pki::RenewalList& list) {
  return fmt::format("{} certificate{} and {} permissions document{}", list.certificates.size(),
                     list.certificates.size() == 1 ? "" : "s", list.permissions.size(),
                     list.permissions.size() == 1 ? "" : "s");
}

}  // namespace ddssec::cli
