#include "cli/ca/revocation_lists.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "cli/ca/participant_places.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// True if the CA signed the list and has its name. The list's dates are not checked.
bool is_list_of(const pki::Crl& list, const pki::Certificate& ca) {
  return list.is_named_after(ca) && list.check(ca, list.this_update()).has_value();
}

bool is_signed_by_one_of(const pki::Crl& list, const std::vector<pki::Certificate>& cas) {
  return std::ranges::any_of(cas, [&](const auto& ca) { return is_list_of(list, ca); });
}

std::set<std::string> serials_of(const std::vector<pki::Revocation>& entries) {
  std::set<std::string> serials;
  for (const auto& entry : entries) serials.insert(entry.serial);
  return serials;
}

std::pair<pki::CrlNumber, WallTime> order(const pki::Crl& list) {
  return {list.number().value_or(0), list.this_update()};
}

std::string number_and_date(const pki::Crl& list) {
  return fmt::format("list {} of {}", number_text(list), to_string(list.this_update()));
}

}  // namespace

std::string number_text(const pki::Crl& list) { return to_string(list.number().value_or(0)); }

Result<std::vector<pki::Crl>> read_crls(const fs::path& path) {
  if (!path_exists(path)) return std::vector<pki::Crl>();
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(path, pki::kMaxDocumentOctets));
  DDSSEC_ASSIGN_OR_RETURN(auto lists, with_default_document(pki::Crl::all_from(octets), path));
  if (lists.empty())
    return fail(Code::crl_malformed, {.document = path, .note = "there is no list in it"});
  return lists;
}

Result<std::optional<pki::Crl>> present_crl(const CaPaths& ca) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, read_crls(ca.crl));
  if (lists.empty()) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(ca.certificate));
  std::erase_if(lists, [&](const auto& list) { return !is_list_of(list, certificate); });
  const auto newest = std::ranges::max_element(lists, {}, order);
  return newest == lists.end() ? std::nullopt : std::optional(*newest);
}

Result<std::vector<pki::Revocation>> listed_revocations(const CaPaths& ca) {
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, read_crls(ca.crl));
  if (lists.empty()) return std::vector<pki::Revocation>();
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(ca.certificate));
  std::vector<pki::Revocation> out;
  for (const auto& list : lists) {
    if (!list.is_named_after(certificate)) continue;
    DDSSEC_ASSIGN_OR_RETURN(const auto entries, with_default_document(list.revoked(), ca.crl));
    out.insert(out.end(), entries.begin(), entries.end());
  }
  return out;
}

Result<bool> lists_all(const CaPaths& ca, const pki::IssueLog& log) {
  DDSSEC_ASSIGN_OR_RETURN(auto wanted, listed_revocations(ca));
  const auto& logged = log.revocations();
  wanted.insert(wanted.end(), logged.begin(), logged.end());
  if (wanted.empty()) return true;
  DDSSEC_ASSIGN_OR_RETURN(const auto present, present_crl(ca));
  if (!present) return false;
  DDSSEC_ASSIGN_OR_RETURN(const auto revoked, with_default_document(present->revoked(), ca.crl));
  const auto serials = serials_of(revoked);
  return std::ranges::all_of(wanted, [&](const auto& one) { return serials.contains(one.serial); });
}

namespace {

// The basis of the next list: all lists of the CA that were found.
class FormerLists {
 public:
  // `before` is the CA's certificate in its folder. While the CA is rotated, that is the old one.
  FormerLists(const OpenCa& ca, const pki::Certificate& before)
      : ca_(ca.certificate()), before_(before) {}

  // The CA's own file is trusted, because only its owner can write it.
  Status add_own(const fs::path& file) {
    DDSSEC_ASSIGN_OR_RETURN(const auto crls, read_crls(file));
    for (const auto& list : crls)
      if (list.is_named_after(ca_) || list.is_named_after(before_))
        DDSSEC_RETURN_IF_ERROR(add(list));
    return {};
  }

  // Adds the lists in a participant's file. An error in that file does not concern the CA.
  void add_of_participant(const fs::path& file) {
    const auto lists = read_crls(file);
    if (!lists) return;
    for (const auto& list : *lists)
      if (seen_.insert(list.pem()).second && is_genuine(list)) static_cast<void>(add(list));
  }

  // Adds the lists in a file that the command line names.
  Status add_named(const fs::path& file) {
    DDSSEC_ASSIGN_OR_RETURN(const auto lists, read_crls(file));
    if (lists.empty()) return fail(Code::file_not_found, {.document = file});
    bool is_any = false;
    for (const auto& list : lists) {
      if (!is_genuine(list)) continue;
      DDSSEC_RETURN_IF_ERROR(add(list));
      is_any = true;
    }
    if (is_any) return {};
    return fail(Code::crl_signature_invalid, {.document = file,
                                              .expected = "a list signed by " + ca_.subject(),
                                              .found = "a list of " + lists.front().issuer()});
  }

  pki::CrlNumber next_number() const { return number_.next(); }
  // Uses the date of the list with the highest number, not the latest date: another list may have
  // been made with a clock that was ahead, and this one after it.
  WallTime this_update(WallTime now) const {
    return newest_ ? std::max(now, newest_->this_update()) : now;
  }
  const std::vector<pki::Revocation>& entries() const { return entries_; }

 private:
  bool is_genuine(const pki::Crl& list) const {
    return is_list_of(list, ca_) || is_list_of(list, before_);
  }

  Status add(const pki::Crl& list) {
    DDSSEC_ASSIGN_OR_RETURN(const auto entries, list.revoked());
    entries_.insert(entries_.end(), entries.begin(), entries.end());
    number_ = std::max(number_, list.number().value_or(0));
    // Lists of another key are a separate sequence, so they do not determine the date.
    if (is_list_of(list, ca_) && (!newest_ || order(*newest_) < order(list))) newest_ = list;
    return {};
  }

  pki::Certificate ca_;
  pki::Certificate before_;
  pki::CrlNumber number_;
  std::optional<pki::Crl> newest_;
  std::vector<pki::Revocation> entries_;
  std::set<std::string> seen_;
};

Result<FormerLists> former_lists(const OpenCa& ca, const pki::IssueLog& log,
                                 const std::vector<fs::path>& more) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(ca.paths.certificate));
  FormerLists out(ca, certificate);
  DDSSEC_RETURN_IF_ERROR(out.add_own(ca.paths.crl));
  DDSSEC_ASSIGN_OR_RETURN(const auto places, participant_places(ca.paths, log));
  for (const auto& folder : places.here)
    out.add_of_participant(pki::participant_folder(folder).crl);
  for (const auto& file : more) DDSSEC_RETURN_IF_ERROR(out.add_named(file));
  return out;
}

Result<pki::Crl> following(const OpenCa& ca, const FormerLists& former,
                           std::vector<pki::Revocation> entries, WallTime date, WallTime until) {
  // No entry is later than its list, because a product may read such an entry as a future
  // revocation.
  for (auto& entry : entries) entry.time = std::min(entry.time, date);
  return ca.authority.make_crl({.this_update = date,
                                .next_update = until,
                                .number = former.next_number(),
                                .entries = std::move(entries)});
}

// The log comes first, because it has the original reasons and times.
std::vector<pki::Revocation> all_entries(const pki::IssueLog& log, const FormerLists& former) {
  auto out = log.revocations();
  out.insert(out.end(), former.entries().begin(), former.entries().end());
  return out;
}

}  // namespace

Result<pki::Crl> next_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now, int days,
                          const std::vector<fs::path>& more, ListDate date) {
  DDSSEC_ASSIGN_OR_RETURN(const auto former, former_lists(ca, log, more));
  const auto from = date == ListDate::now ? now : former.this_update(now);
  return following(ca, former, all_entries(log, former), from, from + std::chrono::days(days));
}

Result<pki::Crl> routine_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto former, former_lists(ca, log, {}));
  auto entries = all_entries(log, former);
  const auto from = former.this_update(now);
  const auto until =
      entries.empty() ? ca.certificate().not_after() : from + std::chrono::days(kListDays);
  return following(ca, former, std::move(entries), from, until);
}

Result<pki::Crl> first_crl(const pki::Authority& ca) {
  const auto& certificate = ca.certificate();
  return ca.make_crl({.this_update = certificate.not_before(),
                      .next_update = certificate.not_after(),
                      .number = 1,
                      .entries = {}});
}

std::string list_date_warning(const pki::Crl& crl, WallTime now, const std::string& ca) {
  if (crl.this_update() <= now) return {};
  return fmt::format(
      "the clock of this machine says {}, which is before the list before this one; the new list "
      "is dated {} as well, and no participant takes it earlier. Set the clock, if it is behind. "
      "If it is right, the list before was made under a clock that was ahead: {}\n",
      to_string(now), to_string(crl.this_update()), future_list_hint(ca));
}

std::string future_list_hint(const std::string& ca) {
  return fmt::format(
      "ddssec crl new --ca {0} --date-now makes a list that is dated now and names all that was "
      "revoked; then ddssec crl distribute --ca {0}",
      ca);
}

Result<std::optional<pki::Crl>> list_for_newcomers(const CaPaths& paths, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto newest, present_crl(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, read_certificate(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto places, participant_places(paths, log));
  for (const auto& folder : places.here) {
    const auto lists = read_crls(pki::participant_folder(folder).crl);
    if (!lists) continue;  // a fault in it does not concern the new participant
    for (const auto& list : *lists)
      if ((!newest || order(*newest) < order(list)) && is_list_of(list, ca)) newest = list;
  }
  const bool is_over = newest && newest->next_update() && *newest->next_update() <= now;
  return is_over ? std::nullopt : newest;
}

namespace {

// A file whose content is no list is replaced. A file that cannot be read at all is an error.
Result<std::vector<pki::Crl>> lists_to_replace(const fs::path& file) {
  auto lists = read_crls(file);
  if (lists) return lists;
  const auto code = lists.error().code();
  const bool is_damaged = code == Code::crl_malformed || code == Code::crl_is_delta;
  return is_damaged ? std::vector<pki::Crl>() : std::move(lists);
}

// True if the trusted certificates form a chain from the participant to the CA.
bool is_under(const pki::Certificate& participant, const ListForFolder& what) {
  const auto* at = &participant;
  for (std::size_t steps = 0; steps <= what.trusted.size(); ++steps) {
    if (at->is_issued_by(what.ca)) return true;
    const auto above = std::ranges::find_if(
        what.trusted, [&](const auto& ca) { return !(ca == *at) && at->is_issued_by(ca); });
    if (above == what.trusted.end()) return false;
    at = &*above;
  }
  return false;
}

std::unexpected<Error> newer_list_error(const fs::path& file, const pki::Crl& former,
                                        const ListForFolder& what, const std::string& lacks) {
  return fail(
      Code::crl_older,
      {.document = file,
       .expected = number_and_date(former) + " or later",
       .found = number_and_date(what.list) + lacks,
       .note = "the CA's folder is older than its participants': it came back from a backup, or it "
               "is a copy. The list that is there stays",
       .hint = fmt::format("ddssec crl new --ca {} --from {} makes a list that names what both "
                           "name; then ddssec crl distribute --ca {}",
                           what.ca_folder, file.string(), what.ca_folder)});
}

Status check_follows(const fs::path& file, const pki::Crl& former, const ListForFolder& what) {
  if (!what.list.may_replace_at(former, what.now)) return newer_list_error(file, former, what, "");
  DDSSEC_ASSIGN_OR_RETURN(const auto revoked, what.list.revoked());
  const auto serials = serials_of(revoked);
  DDSSEC_ASSIGN_OR_RETURN(const auto revocations, with_default_document(former.revoked(), file));
  for (const auto& one : revocations)
    if (!serials.contains(one.serial))
      return newer_list_error(file, former, what, ", which lacks serial number " + one.serial);
  return {};
}

bool is_replaced_by_one_of(const pki::Crl& former, const std::vector<pki::Crl>& lists,
                           const std::vector<pki::Certificate>& cas) {
  return std::ranges::any_of(
      lists, [&](const auto& list) { return pki::have_common_signer(list, former, cas); });
}

// Compares keys, because another trusted CA may have the same name.
bool is_of_issuer(const pki::Crl& list, const ListForFolder& what) {
  const auto is_by = [&](const pki::Certificate& ca) {
    return is_list_of(list, ca) && what.participant->is_issued_by(ca);
  };
  return is_by(what.ca) || std::ranges::any_of(what.trusted, is_by);
}

// Stock products read only the first list of a file.
Status put_own_first(std::vector<pki::Crl>& lists, const fs::path& file,
                     const ListForFolder& what) {
  if (what.participant == nullptr) return {};
  const auto is_own = [&](const auto& list) { return is_of_issuer(list, what); };
  std::ranges::stable_partition(lists, is_own);
  if (is_own(lists.front())) return {};
  const auto issuer = what.participant->issuer();
  return fail(Code::crl_missing,
              {.document = file,
               .expected = "a list of " + issuer + " before one of " + what.ca.subject(),
               .note = "with the second alone the participant would authenticate no peer",
               .hint = "first ddssec crl distribute --ca with the folder of " + issuer});
}

}  // namespace

Status put_list(FileTransaction& out, const fs::path& file, const ListForFolder& what) {
  const bool is_trusted = std::ranges::find(what.trusted, what.ca) != what.trusted.end();
  if (what.participant != nullptr && !is_trusted && !is_under(*what.participant, what))
    return fail(Code::issuer_unknown, {.document = file.parent_path() / "cert.pem",
                                       .expected = "one that " + what.ca.subject() + " issued",
                                       .found = "one of " + what.participant->issuer()});
  std::vector<pki::Crl> lists{what.list};
  lists.insert(lists.end(), what.beside.begin(), what.beside.end());
  DDSSEC_ASSIGN_OR_RETURN(const auto former_lists, lists_to_replace(file));
  for (const auto& former : former_lists) {
    if (is_replaced_by_one_of(former, what.beside, what.trusted)) continue;
    if (is_list_of(former, what.ca))
      DDSSEC_RETURN_IF_ERROR(check_follows(file, former, what));
    else if (is_signed_by_one_of(former, what.trusted))
      lists.push_back(former);
  }
  DDSSEC_RETURN_IF_ERROR(put_own_first(lists, file, what));
  std::string text;
  for (const auto& list : lists) text += list.pem();
  return out.put_public(file, text);
}

}  // namespace ddssec::cli
