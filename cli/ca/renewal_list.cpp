#include "cli/ca/renewal_list.hpp"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <ranges>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/tool_code.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/files.hpp"
#include "governance/grant_extension.hpp"
#include "governance/read.hpp"
#include "pki/key_digests.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using governance::Grant;

// A permissions document of a list, read without checking its signature.
struct ListedDocument {
  Bytes file;
  std::vector<Grant> grants = {};  // grants that name their subject
  WallTime end = {};               // the end of the last grant
};

// Participants check the signature, so it is not checked here. Empty if no grant names a subject.
std::optional<ListedDocument> read_unverified_entry(BytesView file) {
  const auto form = pki::examine_document(file);
  if (form.ambiguous) return std::nullopt;
  auto document = governance::read_permissions(form.unverified_text, form.first_line);
  if (!document) return std::nullopt;
  ListedDocument out{.file = to_bytes(file), .grants = std::move(document->grants)};
  std::erase_if(out.grants, [](const auto& grant) { return grant.subject_is_expression; });
  for (const auto& grant : out.grants) out.end = std::max(out.end, grant.validity.not_after);
  return out.grants.empty() ? std::nullopt : std::optional(std::move(out));
}

// True if `next` makes `former` superfluous. A document that begins in the future does not: the
// former one stays until then.
bool replaces(const ListedDocument& next, const ListedDocument& former, WallTime now) {
  return std::ranges::all_of(former.grants, [&](const auto& old) {
    return std::ranges::any_of(next.grants, [&](const auto& grant) {
      return grant.validity.not_after >= old.validity.not_after &&
             grant.validity.not_before <= std::max(now, old.validity.not_before) &&
             governance::give_same_rights(grant, old);
    });
  });
}

// The size of the file as PEM text, in octets.
std::size_t size_in_list(const Bytes& file) {
  constexpr std::size_t kAround = 80, kLine = 64;
  const auto text = (file.size() + 2) / 3 * 4;
  return text + text / kLine + kAround;
}

// The entries of a list, limited to what participants read. Older entries come first.
class Entries {
 public:
  // Adds what has not ended. Permissions that name no subject are left out.
  void add(const pki::RenewalList& list, WallTime now) {
    for (const auto& one : list.certificates)
      if (one.not_after() > now) add(one);
    for (const auto& file : list.permissions) {
      auto next = read_unverified_entry(file);
      if (!next || next->end <= now) continue;
      std::erase_if(documents_, [&](const auto& old) { return replaces(*next, old, now); });
      documents_.push_back(*std::move(next));
    }
  }

  // Removes entries until the list is within the limits of participants.
  void shorten() {
    std::size_t octets = 0;
    for (const auto& one : certificates_) octets += one.pem().size();
    for (const auto& one : documents_) octets += size_in_list(one.file);
    const auto is_too_long = [&](std::size_t left) {
      return left > pki::kMaxRenewals || octets > pki::kMaxRenewalListOctets;
    };
    std::set<const ListedDocument*> dropped;
    if (is_too_long(documents_.size()))
      for (const auto* const least : in_order_of_removal()) {
        if (!is_too_long(documents_.size() - dropped.size())) break;
        octets -= size_in_list(least->file);
        for (const auto& grant : least->grants) left_out_.insert(grant.subject_name);
        dropped.insert(least);
      }
    std::erase_if(documents_, [&](const auto& one) { return dropped.contains(&one); });
    while (certificates_.size() > pki::kMaxRenewals || octets > pki::kMaxRenewalListOctets) {
      const auto least = std::ranges::min_element(certificates_, {}, &pki::Certificate::not_after);
      octets -= least->pem().size();
      left_out_.insert(least->subject());
      certificates_.erase(least);
    }
  }

  pki::RenewalList list() const {
    pki::RenewalList out{.certificates = certificates_};
    for (const auto& one : documents_) out.permissions.push_back(one.file);
    return out;
  }
  // The subjects whose entries were removed.
  const std::set<std::string>& left_out() const { return left_out_; }

 private:
  // An older list may be added after a newer one. If subject and key are the same, the certificate
  // that ends last stays.
  void add(const pki::Certificate& one) {
    const auto former =
        std::ranges::find(certificates_, one.subject_digest(), &pki::Certificate::subject_digest);
    if (former == certificates_.end())
      certificates_.push_back(one);
    else if (former->not_after() <= one.not_after() || !has_key_of(*former, one))
      *former = one;
  }
  static bool has_key_of(const pki::Certificate& a, const pki::Certificate& b) {
    return pki::key_digest(a) == pki::key_digest(b);
  }
  // The order in which documents are removed: first those whose subjects all have later ones, then
  // those that end first.
  std::vector<const ListedDocument*> in_order_of_removal() const {
    std::set<std::string_view> later;
    std::vector<std::pair<bool, const ListedDocument*>> order;
    for (const auto& document : std::views::reverse(documents_)) {
      const bool is_former = std::ranges::all_of(
          document.grants, [&](const auto& grant) { return later.contains(grant.subject_name); });
      order.emplace_back(!is_former, &document);
      for (const auto& grant : document.grants) later.insert(grant.subject_name);
    }
    std::ranges::reverse(order);
    std::ranges::stable_sort(order, {}, [](const auto& one) {
      return std::pair(one.first, one.first ? one.second->end : WallTime());
    });
    std::vector<const ListedDocument*> out;
    for (const auto& [is_last, document] : order) out.push_back(document);
    return out;
  }

  std::vector<pki::Certificate> certificates_;
  std::vector<ListedDocument> documents_;
  std::set<std::string> left_out_;
};

Entries entries_of(const pki::RenewalList& former, const pki::RenewalList& next, WallTime now) {
  Entries out;
  out.add(former, now);
  out.add(next, now);
  out.shorten();
  return out;
}

Error too_long_error(const fs::path& file, const std::set<std::string>& left_out) {
  constexpr std::size_t kMax = 4;
  std::vector<std::string> shown(left_out.begin(), left_out.end());
  const auto more = shown.size() > kMax ? shown.size() - kMax : 0;
  shown.resize(shown.size() - more);
  return Error(
      Code::file_too_large,
      {.document = file,
       .expected = fmt::format("at most {} certificates, {} permissions documents and {} "
                               "octets, as participants read",
                               pki::kMaxRenewals, pki::kMaxRenewals, pki::kMaxRenewalListOctets),
       .found = fmt::format("more: entries of {}{} were left out", fmt::join(shown, "; "),
                            more == 0 ? "" : fmt::format(" and {} more", more)),
       .hint = "give each participant a document with its own grant only; peers of the "
               "participants named authenticate again when the former documents end"});
}

Error list_begun_anew_error(const fs::path& file, const Error& why) {
  return Error(Code::renewal_list_malformed,
               {.document = file,
                .expected = "a renewal list",
                .found = why.message(),
                .note = "a new list was begun",
                .hint = "nothing to do for participants that are renewed from now on; for the "
                        "others, renew them again before their former documents end, or put a copy "
                        "of the former list into the file's place"});
}

// Returns an empty list if the file does not exist.
Result<pki::RenewalList> read_renewals(const fs::path& file) {
  if (!path_exists(file)) return pki::RenewalList{};
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxRenewalListOctets));
  return with_default_document(pki::RenewalList::parse(octets), file);
}

Status add_to(const fs::path& file, const pki::RenewalList& next, WallTime now) {
  const auto former = read_renewals(file);
  const auto entries = entries_of(former.value_or(pki::RenewalList{}), next, now);
  const auto list = entries.list();
  if (list.is_empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto text, list.text());
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(out.put_public(file, text));
  DDSSEC_RETURN_IF_ERROR(out.commit_each());
  if (!former) return std::unexpected(list_begun_anew_error(file, former.error()));
  if (!entries.left_out().empty()) return std::unexpected(too_long_error(file, entries.left_out()));
  return {};
}

// Adds the remedy for an unreadable list of the CA: the user may remove it, because each
// participant's folder keeps its own entries.
Error with_hint_for_ca(const Error& error) {
  auto details = error.details();
  details.hint =
      "remove it, or put a copy of the former one into its place; the next renewal begins a new "
      "list, and the participants' folders keep the entries that they have";
  return Error(error.code(), std::move(details));
}

// The largest numbers of remembered drafts and verdicts. A draft may have some MiB.
constexpr std::size_t kMaxDrafts = 4;
constexpr std::size_t kMaxVerdicts = 100'000;

Sha256Digest digest_of(std::initializer_list<BytesView> parts) {
  Bytes all;
  for (const auto part : parts) {
    const auto one = sha256(part);
    all.insert(all.end(), one.begin(), one.end());
  }
  return sha256(all);
}

Bytes fingerprints_of(const Result<std::vector<pki::Certificate>>& cas) {
  Bytes out;
  for (const auto& ca : cas.value_or(std::vector<pki::Certificate>{}))
    out.insert(out.end(), ca.fingerprint().begin(), ca.fingerprint().end());
  return out;
}

// The CAs in a folder.
class TrustOfFolder {
 public:
  TrustOfFolder(const pki::ParticipantFolder& files, const RenewalsForFolder& what)
      : what_(what),
        identity_cas_(read_certificates(files.identity_ca)),
        permissions_cas_(read_certificates(files.permissions_ca)),
        identity_digest_(fingerprints_of(identity_cas_)),
        permissions_digest_(fingerprints_of(permissions_cas_)) {}

  bool has_permissions_ca() const { return permissions_cas_.has_value(); }
  Sha256Digest digest_with(BytesView list) const {
    const auto has_ca = to_bytes(as_bytes(has_permissions_ca() ? "1" : "0"));
    return digest_of({list, identity_digest_, permissions_digest_, has_ca});
  }

  // The entries that CAs of the folder signed, because the others have no effect there. Without a
  // permissions CA, permissions cannot be judged and stay.
  pki::RenewalList trusted(pki::RenewalList list) {
    std::erase_if(list.certificates, [&](const auto& one) {
      return !known({identity_digest_, one.fingerprint()}, [&] {
        const auto is_issuer = [&](const auto& ca) { return one.is_issued_by(ca); };
        return identity_cas_ && std::ranges::any_of(*identity_cas_, is_issuer);
      });
    });
    if (!has_permissions_ca()) return list;
    std::erase_if(list.permissions, [&](const auto& one) {
      return !known({permissions_digest_, one}, [&] { return is_signed(one); });
    });
    return list;
  }

 private:
  template <class Judge>
  bool known(std::initializer_list<BytesView> key, Judge&& judge) {
    auto& all = what_.known.trusted;
    const auto digest = digest_of(key);
    if (const auto found = all.find(digest); found != all.end()) return found->second;
    if (all.size() >= kMaxVerdicts) all.clear();
    return all[digest] = judge();
  }
  bool is_signed(BytesView file) {
    if (!verifier_) verifier_ = pki::DocumentVerifier::make(*permissions_cas_);
    return *verifier_ && (*verifier_)->verify(file, what_.now);
  }

  const RenewalsForFolder& what_;
  const Result<std::vector<pki::Certificate>> identity_cas_, permissions_cas_;
  const Bytes identity_digest_, permissions_digest_;
  std::optional<Result<pki::DocumentVerifier>> verifier_;
};

Result<KnownRenewals::Draft> draft_of(TrustOfFolder& trust, const Result<Bytes>& present,
                                      const RenewalsForFolder& what) {
  const auto list_in = [](BytesView file) {
    return pki::RenewalList::parse(file).value_or(pki::RenewalList{});
  };
  // Entries only extend rights, so none is removed because another list lacks it.
  auto former = trust.trusted(present ? list_in(*present) : pki::RenewalList{});
  std::erase_if(former.certificates, [&](const auto& one) {
    return what.revoked.contains(one.serial()) &&
           std::ranges::any_of(what.cas, [&](const auto& ca) { return one.is_issued_by(ca); });
  });
  auto next = trust.trusted(what.entries);
  if (!trust.has_permissions_ca()) next.permissions.clear();
  const auto entries = entries_of(former, next, what.now);
  const auto list = entries.list();
  DDSSEC_ASSIGN_OR_RETURN(auto text, list.text());
  return KnownRenewals::Draft{std::move(text), list.is_empty(), entries.left_out()};
}

// Puts the list without the entries of `member` for which `is_foreign` is true, if there are any.
template <class Entries, class IsForeign>
Status put_without(FileTransaction& out, const fs::path& renewals,
                   Entries pki::RenewalList::*member, const IsForeign& is_foreign) {
  auto list = read_renewals(renewals);
  if (!list || std::erase_if((*list).*member, is_foreign) == 0) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto text, list->text());
  return out.put_public(renewals, text);
}

}  // namespace

void RenewalListAdditions::add(const CaPaths& ca, const pki::Certificate& renewed) {
  files_[ca.renewals].certificates.push_back(renewed);
}

void RenewalListAdditions::add(const CaPaths& ca, BytesView signed_permissions,
                               const fs::path& file) {
  if (read_unverified_entry(signed_permissions))
    files_[ca.renewals].permissions.push_back(to_bytes(signed_permissions));
  else
    add_notice(Error(tool_code::permissions_unlisted, {.document = file}));
}

Status RenewalListAdditions::write(WallTime now) const {
  Status out;
  for (const auto& [file, entries] : files_)
    if (auto status = add_to(file, entries, now); out && !status) out = std::move(status);
  return out;
}

std::vector<Grant> listed_grants(const CaPaths& ca, WallTime now) {
  std::vector<Grant> out;
  for (const auto& file : read_renewals(ca.renewals).value_or(pki::RenewalList{}).permissions)
    if (auto document = read_unverified_entry(file))
      std::ranges::copy_if(document->grants, std::back_inserter(out),
                           [&](const auto& grant) { return grant.validity.not_after > now; });
  return out;
}

bool extends_any_grant(const governance::Permissions& next, const std::vector<Grant>& former) {
  return std::ranges::none_of(next.grants, &Grant::subject_is_expression) &&
         std::ranges::any_of(next.grants, [&](const auto& grant) {
           return std::ranges::any_of(former, [&](const auto& old) {
             return grant.validity.not_after > old.validity.not_after &&
                    governance::gives_at_least(grant, old);
           });
         });
}

RenewalsOfCas renewals_of(const fs::path& given, const pki::Crl* revoked) {
  RenewalsOfCas out;
  std::set<fs::path> seen;
  for (const auto* const role : {"identity", "permissions"}) {
    const auto paths = ca_paths(given, role);
    if (!path_exists(paths.renewals) || !seen.insert(paths.renewals).second) continue;
    auto list = read_renewals(paths.renewals);
    auto cas = read_certificates(paths.certificate);
    if (!list || !cas) {
      out.problems.push_back(list ? cas.error() : with_hint_for_ca(list.error()));
      continue;
    }
    std::ranges::move(list->certificates, std::back_inserter(out.list.certificates));
    std::ranges::move(list->permissions, std::back_inserter(out.list.permissions));
    std::ranges::move(*cas, std::back_inserter(out.cas));
  }
  auto& serials = out.revoked;
  if (revoked != nullptr) {
    const auto entries = revoked->revoked();
    if (!entries) {
      out.problems.push_back(entries.error());
      out.list.certificates.clear();
      out.cas.clear();
    } else {
      for (const auto& entry : *entries) serials.insert(entry.serial);
    }
  }
  std::erase_if(out.list.certificates,
                [&](const auto& one) { return serials.contains(one.serial()); });
  return out;
}

Status put_renewals(FileTransaction& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what) {
  TrustOfFolder trust(files, what);
  const auto present = read_file(files.renewals, pki::kMaxRenewalListOctets);
  const auto key = trust.digest_with(present ? BytesView(*present) : BytesView{});
  auto& drafts = what.known.drafts;
  if (!drafts.contains(key)) {
    DDSSEC_ASSIGN_OR_RETURN(auto made, draft_of(trust, present, what));
    if (drafts.size() >= kMaxDrafts) drafts.clear();
    drafts.emplace(key, std::move(made));
  }
  const auto& draft = drafts.at(key);
  if (!draft.left_out.empty()) add_notice(too_long_error(files.renewals, draft.left_out));
  if (draft.is_empty && !path_exists(files.renewals)) return {};
  if (present && as_text(*present) == draft.text) return {};
  return out.put_public(files.renewals, draft.text);
}

void refresh_renewals(const fs::path& ca, const pki::ParticipantFolder& files, WallTime now,
                      Report& report) {
  if (!path_exists(files.renewals)) return;
  const auto written = [&]() -> Result<std::vector<WrittenFile>> {
    const auto paths = ca_paths(ca, "identity");
    DDSSEC_ASSIGN_OR_RETURN(const auto crl, present_crl(paths));
    auto renewals = renewals_of(ca, crl ? &*crl : nullptr);
    // Revoked entries of a CA without a list of its own leave the folder, too.
    DDSSEC_ASSIGN_OR_RETURN(auto cas, read_certificates(paths.certificate));
    std::ranges::move(cas, std::back_inserter(renewals.cas));
    KnownRenewals known;
    FileTransaction out;
    DDSSEC_RETURN_IF_ERROR(
        put_renewals(out, files, {renewals.list, renewals.cas, renewals.revoked, now, known}));
    return out.commit_each();
  }();
  if (!written) return report.errors.push_back(written.error());
  if (!written->empty())
    report.text += fmt::format("{}  renewal list, made again without revoked certificates\n",
                               files.renewals.string());
  std::ranges::copy(*written, std::back_inserter(report.files_written));
}

Status remove_certificates_of_others(FileTransaction& out, const fs::path& renewals,
                                     const std::vector<pki::Certificate>& cas) {
  return put_without(out, renewals, &pki::RenewalList::certificates, [&](const auto& one) {
    return std::ranges::none_of(cas, [&](const auto& ca) { return one.is_issued_by(ca); });
  });
}

Status remove_permissions_of_others(FileTransaction& out, const fs::path& renewals,
                                    const std::vector<pki::Certificate>& cas, WallTime now) {
  if (!path_exists(renewals)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::DocumentVerifier::make(cas));
  return put_without(out, renewals, &pki::RenewalList::permissions,
                     [&](const auto& file) { return !verifier.verify(file, now); });
}

bool takes_permissions(const pki::ParticipantFolder& files) {
  return read_certificates(files.permissions_ca).has_value();
}

}  // namespace ddssec::cli
