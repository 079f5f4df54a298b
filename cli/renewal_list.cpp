#include "cli/renewal_list.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/documents.hpp"
#include "cli/inputs.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "governance/write.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Its signature is not checked: the participants do that. Empty: it says nothing.
std::optional<ListedDocument> look_into(const Bytes& file) {
  const auto form = pki::examine_document(file);
  if (form.ambiguous) return std::nullopt;
  auto document = governance::read_permissions(form.unverified_text, form.first_line);
  if (!document || document->grants.empty()) return std::nullopt;
  ListedDocument out{.file = file, .grants = std::move(document->grants)};
  for (const auto& grant : out.grants) {
    out.begin = std::max(out.begin, grant.validity.not_before);
    out.end = std::max(out.end, grant.validity.not_after);
  }
  return out;
}

std::vector<ListedDocument> documents_of(const pki::RenewalList& list) {
  std::vector<ListedDocument> out;
  for (const auto& file : list.permissions)
    if (auto one = look_into(file)) out.push_back(*std::move(one));
  return out;
}

// Each domain that `former` says something of, `next` does, too.
bool covers(const governance::Grant& next, const governance::Grant& former) {
  if (former.default_allow && !next.default_allow) return false;
  return std::ranges::all_of(former.rules, [&](const auto& rule) {
    return std::ranges::find(next.rules, rule.domains, &governance::Rule::domains) !=
           next.rules.end();
  });
}

bool replaces(const ListedDocument& next, const ListedDocument& former) {
  if (next.begin < former.begin) return false;
  return std::ranges::all_of(former.grants, [&](const auto& old) {
    return std::ranges::any_of(next.grants, [&](const auto& grant) {
      return grant.subject_name == old.subject_name &&
             grant.subject_is_expression == old.subject_is_expression && covers(grant, old);
    });
  });
}

// Of PEM text.
std::size_t size_in_list(const Bytes& file) {
  constexpr std::size_t kAround = 80, kLine = 64;
  const auto text = (file.size() + 2) / 3 * 4;
  return text + text / kLine + kAround;
}

// The octets that the certificates take.
std::size_t keep_what_is_read(std::vector<pki::Certificate>& certificates) {
  std::size_t octets = 0;
  auto first = certificates.end();
  for (std::size_t count = 0; first != certificates.begin() && count < pki::kMostRenewals;
       ++count) {
    const auto more = std::prev(first)->pem().size();
    if (octets + more > pki::kMostRenewalListOctets) break;
    octets += more;
    --first;
  }
  certificates.erase(certificates.begin(), first);
  return octets;
}

// Permissions that have ended leave first, longest ago first, and then those at the front. True:
// some left that have not ended.
bool keep_what_is_read(std::vector<ListedDocument>& documents, std::size_t octets, WallTime now) {
  for (const auto& one : documents) octets += size_in_list(one.file);
  bool out = false;
  while (!documents.empty() &&
         (documents.size() > pki::kMostRenewals || octets > pki::kMostRenewalListOctets)) {
    auto first = std::ranges::min_element(documents, {}, &ListedDocument::end);
    if (first->end > now) {
      first = documents.begin();
      out = true;
    }
    octets -= size_in_list(first->file);
    documents.erase(first);
  }
  return out;
}

struct Merged {
  pki::RenewalList list = {};
  bool is_cut_short = false;
};

// `former` without what `next` replaces and certificates that have ended, and then `next`.
Merged merged(const pki::RenewalList& former, const pki::RenewalList& next, WallTime now) {
  Merged out;
  const auto is_replaced = [&](const pki::Certificate& old) {
    return std::ranges::find(next.certificates, old.subject_digest(),
                             &pki::Certificate::subject_digest) != next.certificates.end();
  };
  auto& certificates = out.list.certificates;
  for (const auto& old : former.certificates)
    if (old.not_after() > now && !is_replaced(old)) certificates.push_back(old);
  for (const auto& one : next.certificates)
    if (one.not_after() > now) certificates.push_back(one);
  const auto later = documents_of(next);
  std::vector<ListedDocument> documents;
  for (auto& old : documents_of(former))
    if (std::ranges::none_of(later, [&](const auto& one) { return replaces(one, old); }))
      documents.push_back(std::move(old));
  documents.insert(documents.end(), later.begin(), later.end());
  out.is_cut_short = keep_what_is_read(documents, keep_what_is_read(certificates), now);
  for (auto& one : documents) out.list.permissions.push_back(std::move(one.file));
  return out;
}

Error cut_short(const fs::path& file) {
  return Error(
      Code::file_too_large,
      {.document = file,
       .expected = fmt::format("at most {} certificates, {} permissions documents and {} "
                               "octets, as participants read",
                               pki::kMostRenewals, pki::kMostRenewals, pki::kMostRenewalListOctets),
       .found = "more: permissions that came first were left out",
       .hint = "give each participant a document with its own grant only; a participant "
               "that starts again no longer knows of those that were left out: to take "
               "rights away for good, revoke the certificate"});
}

// Whether both say something of one domain, whatever the tags are.
bool meet_in_a_domain(const governance::Grant& a, const governance::Grant& b) {
  const auto says = [](const governance::Grant& grant, DomainId id) {
    return grant.default_allow || std::ranges::any_of(grant.rules, [id](const auto& rule) {
             return governance::DomainSet{.ranges = rule.domains.ranges}.contains(id);
           });
  };
  for (DomainId id = 0; id <= governance::kHighestDomainId; ++id)
    if (says(a, id) && says(b, id)) return true;
  return false;
}

std::string rights_in(governance::Grant grant) {
  grant.name = grant.subject_name = "X";
  grant.subject_is_expression = grant.subject_has_line_breaks = false;
  grant.validity = {};
  return governance::to_xml(governance::Permissions{.grants = {std::move(grant)}});
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

// The CAs' own lists have the certificates that are still to count of them. Permissions stay: they
// take rights away, also when the CA's list was lost.
pki::RenewalList without_those_of(const std::vector<pki::Certificate>& cas, pki::RenewalList list) {
  std::erase_if(list.certificates, [&](const auto& one) {
    return std::ranges::any_of(cas, [&](const auto& ca) { return one.is_issued_by(ca); });
  });
  return list;
}

std::vector<governance::Grant> grants_of(const std::vector<governance::Grant>& all,
                                         const pki::Certificate& certificate) {
  std::vector<governance::Grant> out;
  const auto subject = pki::SubjectName::of(certificate);
  std::ranges::copy_if(all, std::back_inserter(out),
                       [&](const auto& grant) { return governance::is_for(grant, subject); });
  return out;
}

// Empty: no CA of the file signed it.
std::optional<WallTime> signing_time(const CaPaths& ca, const ListedDocument& document) {
  auto cas = read_certificates(ca.certificate);
  if (!cas) return std::nullopt;
  const auto verifier = pki::DocumentVerifier::make(*cas);
  if (!verifier) return std::nullopt;
  // Also by a certificate that has ended.
  for (const auto& one : *cas)
    if (const auto proof =
            verifier->verify(document.file, one.not_after() - std::chrono::seconds(1)))
      return proof->signed_at().value_or(WallTime::min());
  return std::nullopt;
}

// No entries if the file does not exist.
Result<pki::RenewalList> read_renewals(const fs::path& file) {
  if (!is_there(file)) return pki::RenewalList{};
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMostRenewalListOctets));
  return named(pki::RenewalList::parse(octets), file);
}

// A damaged list is not taken for an empty one: then it would give back what it took away.
Result<pki::RenewalList> read_list_of_ca(const fs::path& file) {
  auto list = read_renewals(file);
  if (list) return list;
  auto details = list.error().details();
  details.hint =
      "put a copy of the file into its place, such as renewed.pem of a participant's folder; if it "
      "is removed, participants that start again no longer know of rights that it took away";
  return fail(list.error().code(), std::move(details));
}

Status add_to(const fs::path& file, const pki::RenewalList& entries, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto former, read_list_of_ca(file));
  const auto [list, is_cut_short] = merged(former, entries, now);
  if (list.is_empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto text, list.text());
  Replacement out;
  DDSSEC_RETURN_IF_ERROR(out.put_public(file, text));
  DDSSEC_RETURN_IF_ERROR(out.commit_each());
  if (is_cut_short) return std::unexpected(cut_short(file));
  return {};
}

}  // namespace

void NewlyListed::add(const CaPaths& ca, const pki::Certificate& renewed) {
  files_[ca.renewals].certificates.push_back(renewed);
}

void NewlyListed::add(const CaPaths& ca, BytesView signed_permissions) {
  files_[ca.renewals].permissions.push_back(to_bytes(signed_permissions));
}

Status NewlyListed::write(WallTime now) const {
  Status out;
  for (const auto& [file, entries] : files_)
    if (auto status = add_to(file, entries, now); out && !status) out = std::move(status);
  return out;
}

Status check_not_replaced(const CaPaths& ca, const PermissionsAgain& again) {
  DDSSEC_ASSIGN_OR_RETURN(const auto list, read_list_of_ca(ca.renewals));
  const auto old = governance::read_permissions(again.text, 1);
  if (list.permissions.empty() || !old) return {};
  const auto own = grants_of(old->grants, again.certificate);
  const auto time = again.signed_at.value_or(WallTime::min());
  for (const auto& document : documents_of(list)) {
    const auto signed_at = signing_time(ca, document);
    if (!signed_at) continue;
    for (const auto& later : grants_of(document.grants, again.certificate))
      for (const auto& grant : own)
        if (!later.subject_is_expression && meet_in_a_domain(later, grant) &&
            rights_in(later) != rights_in(grant) &&
            std::pair(later.validity.not_before, *signed_at) >
                std::pair(grant.validity.not_before, time))
          return fail(tool_code::document_superseded,
                      {.document = again.file,
                       .expected = "the rights of the last document for " +
                                   again.certificate.subject() + " in " + ca.renewals.string(),
                       .found = "other rights",
                       .hint = "put the later document into its place; if this one is meant after "
                               "all, sign its XML anew: ddssec permissions sign; without "
                               "--permissions only the certificate is renewed"});
  }
  return {};
}

Result<pki::RenewalList> renewals_of(const fs::path& given, const pki::Crl* revoked) {
  const auto identity = ca_paths(given, "identity").renewals;
  const auto permissions = ca_paths(given, "permissions").renewals;
  DDSSEC_ASSIGN_OR_RETURN(auto out, read_list_of_ca(identity));
  if (permissions != identity) {
    DDSSEC_ASSIGN_OR_RETURN(auto more, read_list_of_ca(permissions));
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
  auto former = read_renewals(files.renewals).value_or(pki::RenewalList{});
  former = without_those_of(what.cas, of_trusted(std::move(former), files, what.now));
  const auto list = merged(former, of_trusted(what.entries, files, what.now), what.now).list;
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
