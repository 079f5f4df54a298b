#include "cli/agent/agent_documents.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/agent/files_in_place.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/signed_permissions.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

// How often the hook is asked, so that a revocation reaches the participant soon.
constexpr seconds kAskAgain{600};
constexpr seconds kMinRetry{2};
constexpr seconds kMaxRetry{300};

// The permissions that a CA of the folder has signed for this participant.
struct Rights {
  governance::Validity validity;  // up to the end of the last grant, which may be planned for later
  bool are_in_force;
  std::optional<WallTime> signing_time;
  std::string text;
};

Result<Rights> rights_in(const DocumentsTask& task, BytesView octets) {
  const auto& file = task.files.permissions;
  DDSSEC_ASSIGN_OR_RETURN(auto cas, read_certificates(task.files.permissions_ca));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::DocumentVerifier::make(std::move(cas)));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      with_default_document(verifier.verify(octets, task.clock.calendar_seconds()), file));
  const auto now = task.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(
      const auto own, with_default_document(permissions_of(document, task.certificate, now), file));
  std::string text(as_text(document.content()));
  std::erase(text, '\r');
  const auto begin = own.grant.validity.not_before;
  return Rights{.validity = {begin, own.last_end},
                .are_in_force = begin <= now && !own.has_ended,
                .signing_time = document.signing_time(),
                .text = std::move(text)};
}

std::optional<Rights> rights_in_place(const DocumentsTask& task) {
  if (!path_exists(task.files.permissions)) return std::nullopt;
  const auto octets = read_file(task.files.permissions, pki::kMaxSentPermissionsOctets);
  if (!octets) return std::nullopt;
  auto rights = rights_in(task, *octets);
  return rights ? std::optional(*std::move(rights)) : std::nullopt;
}

// Permissions are due when two thirds of their validity are over, from their signature on if that
// came after their begin: otherwise permissions that begin long ago would be due again at once.
// Permissions that cannot be read are due now.
WallTime due_time(const DocumentsTask& task, const std::optional<Rights>& rights) {
  const auto now = task.clock.calendar_seconds();
  if (!rights) return now;
  const auto& time = rights->validity;
  const auto signed_at = rights->signing_time.value_or(time.not_before);
  const auto begin = signed_at <= now ? std::max(time.not_before, signed_at) : time.not_before;
  return begin + (time.not_after - begin) * 2 / 3;
}

std::unexpected<Error> no_new_permissions_error(const DocumentsTask& task,
                                                const std::optional<Rights>& former) {
  return fail(tool_code::no_new_permissions,
              {.document = task.files.permissions,
               .found = former ? "permissions that end on " + to_string(former->validity.not_after)
                               : "no permissions that can be used"});
}

std::unexpected<Error> older_permissions_error(const DocumentsTask& task, const std::string& what,
                                               WallTime limit, WallTime found) {
  return fail(tool_code::renewal_goes_back, {.document = task.files.permissions,
                                             .expected = what + to_string(limit),
                                             .found = to_string(found)});
}

Status check_follows(const DocumentsTask& task, const Rights& next,
                     const std::optional<Rights>& former) {
  if (!next.are_in_force)
    return fail(Code::grant_expired,
                {.document = task.files.permissions,
                 .expected = "permissions that are valid now",
                 .found = fmt::format("{} to {}", to_string(next.validity.not_before),
                                      to_string(next.validity.not_after))});
  if (!former) return {};
  if (next.validity.not_before < former->validity.not_before)
    return older_permissions_error(task, "a begin not before ", former->validity.not_before,
                                   next.validity.not_before);
  if (next.validity.not_after <= former->validity.not_after)
    return older_permissions_error(task, "an end after ", former->validity.not_after,
                                   next.validity.not_after);
  if (!former->signing_time) return {};
  if (!next.signing_time)
    return fail(tool_code::renewal_goes_back,
                {.document = task.files.permissions,
                 .expected = "a document that says when it was signed, as the one in place does"});
  if (*next.signing_time < *former->signing_time)
    return older_permissions_error(task, "a signing time not before ", *former->signing_time,
                                   *next.signing_time);
  return {};
}

Result<unsigned> mode_of(const fs::path& file) {
  constexpr unsigned kNew = 0644;
  struct stat status {};
  const int folder = folder_descriptor(file.parent_path());
  if (::fstatat(folder, file.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
    return errno == ENOENT ? Result<unsigned>(kNew) : unwritable_error(file, errno);
  if (!S_ISREG(status.st_mode))
    return fail(Code::would_overwrite, {.document = file, .note = "it is not a plain file"});
  return (status.st_mode & kNew) | 0600U;
}

Status put(FileTransaction& out, const fs::path& file, BytesView octets) {
  DDSSEC_ASSIGN_OR_RETURN(const auto mode, mode_of(file));
  return out.put(file, octets, mode);
}

// Fetches documents and notes the outcome of each.
class DocumentFetcher {
 public:
  DocumentFetcher(const DocumentsTask& task, const FetchDocument& fetch)
      : task_(task), fetch_(fetch) {}

  Json run() {
    note(fetch_lists());
    note(fetch_renewals());
    const FilesInPlace in_place({task_.files.permissions});
    auto rights = rights_in_place(task_);
    if (is_due(rights)) {
      // Comes before a problem of the lists: it may be one after which nothing must be tried again.
      const auto status = fetch_permissions(rights, in_place);
      if (!status) members_["problem"] = error_to_json(status.error());
      rights = rights_in_place(task_);
    }
    const auto now = task_.clock.calendar_seconds();
    // Permissions that are still due, or due again at once, are not asked for without a pause.
    const auto due = is_due(rights) ? now + retry(rights) : due_time(task_, rights);
    const auto next = std::clamp(due, now + seconds(1), now + kAskAgain);
    members_["documents_next"] = to_string(next);
    return members_;
  }

 private:
  Result<Bytes> fetch(std::string wanted, std::string request = {}) const {
    return fetch_({std::move(wanted), std::move(request), task_.certificate.pem()});
  }

  bool is_due(const std::optional<Rights>& rights) const {
    return due_time(task_, rights) <= task_.clock.calendar_seconds();
  }

  seconds retry(const std::optional<Rights>& rights) const {
    if (!rights) return kMaxRetry;
    const auto time = rights->validity.not_after - rights->validity.not_before;
    return std::clamp(std::chrono::duration_cast<seconds>(time / 60), kMinRetry, kMaxRetry);
  }

  void note(const Status& status) {
    if (!status && !members_.contains("problem"))
      members_["problem"] = error_to_json(status.error());
  }

  Status note_files(const Result<std::vector<WrittenFile>>& written) {
    if (!written) return std::unexpected(written.error());
    for (const auto& file : *written)
      members_["files"].push_back(
          {{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}});
    return {};
  }

  Status fetch_permissions(const std::optional<Rights>& former, const FilesInPlace& in_place) {
    DDSSEC_ASSIGN_OR_RETURN(auto request, task_.request());
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, fetch("permissions", std::move(request)));
    const auto& file = task_.files.permissions;
    if (octets.empty()) return no_new_permissions_error(task_, former);
    if (octets.size() > pki::kMaxSentPermissionsOctets)
      return fail(Code::file_too_large, {.document = file});
    DDSSEC_ASSIGN_OR_RETURN(const auto next, rights_in(task_, octets));
    DDSSEC_RETURN_IF_ERROR(check_follows(task_, next, former));
    FileTransaction out;
    // Unsigned copy of the same text, for people to read.
    if (const auto plain = fs::path(file).replace_extension("xml"); path_exists(plain))
      DDSSEC_RETURN_IF_ERROR(put(out, plain, as_bytes(next.text)));
    DDSSEC_RETURN_IF_ERROR(put(out, file, octets));
    DDSSEC_RETURN_IF_ERROR(in_place.check_unchanged());
    return note_files(out.commit());
  }

  Status fetch_renewals() {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, fetch("renewals"));
    if (octets.empty()) return {};
    DDSSEC_ASSIGN_OR_RETURN(const auto list, pki::RenewalList::parse(octets));
    FileTransaction out;
    KnownRenewals known;
    DDSSEC_RETURN_IF_ERROR(
        put_renewals(out, task_.files, {list, {}, {}, task_.clock.calendar_seconds(), known}));
    return note_files(out.commit_each());
  }

  // The CA that signed a list; nullptr if no CA of the folder did.
  static const pki::Certificate* signer_of(const pki::Crl& list,
                                           const std::vector<pki::Certificate>& cas) {
    const auto found =
        std::ranges::find_if(cas, [&](const auto& ca) { return list.is_signed_by(ca); });
    return found == cas.end() ? nullptr : &*found;
  }

  Status check_no_older(const pki::Crl& list, const std::vector<pki::Crl>& in_place,
                        const std::vector<pki::Certificate>& cas) const {
    for (const auto& former : in_place) {
      if (!pki::have_common_signer(list, former, cas)) continue;
      const auto older = [&](std::string found) {
        return fail(Code::crl_older, {.document = task_.files.crl,
                                      .expected = "number " + number_text(former) + " or later",
                                      .found = std::move(found)});
      };
      if (!list.may_replace_at(former, task_.clock.calendar_seconds()))
        return older(number_text(list));
      DDSSEC_ASSIGN_OR_RETURN(const auto revoked, list.revoked());
      DDSSEC_ASSIGN_OR_RETURN(const auto before, former.revoked());
      for (const auto& one : before)
        if (std::ranges::find(revoked, one.serial, &pki::Revocation::serial) == revoked.end())
          return older("a list without serial number " + one.serial);
    }
    return {};
  }

  Status fetch_lists() {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, fetch("crl"));
    const auto& file = task_.files.crl;
    if (octets.empty()) return {};
    DDSSEC_ASSIGN_OR_RETURN(auto lists, with_default_document(pki::Crl::all_from(octets), file));
    if (lists.empty())
      return fail(Code::crl_malformed, {.document = file, .note = "the hook wrote no list"});
    DDSSEC_ASSIGN_OR_RETURN(auto cas, read_certificates(task_.files.identity_ca));
    DDSSEC_ASSIGN_OR_RETURN(const auto in_place, read_crls(file));
    for (const auto& list : lists) {
      const auto* ca = signer_of(list, cas);
      if (ca == nullptr)
        return fail(Code::crl_signature_invalid,
                    {.document = file,
                     .expected = "lists that an identity CA of the folder has signed",
                     .found = "one of " + list.issuer()});
      DDSSEC_RETURN_IF_ERROR(
          with_default_document(list.check(*ca, task_.clock.calendar_seconds()), file));
      DDSSEC_RETURN_IF_ERROR(check_no_older(list, in_place, cas));
    }
    const auto is_there_already = [&](const pki::Crl& list) {
      return std::ranges::any_of(in_place,
                                 [&](const auto& one) { return one.pem() == list.pem(); });
    };
    if (std::ranges::all_of(lists, is_there_already)) return {};
    return put_lists(std::move(lists), std::move(cas));
  }

  // If there is a list of the participant's own CA, it comes first.
  Status put_lists(std::vector<pki::Crl> lists, std::vector<pki::Certificate> cas) {
    const auto is_own = [&](const pki::Crl& list) {
      const auto* ca = signer_of(list, cas);
      return ca != nullptr && task_.certificate.is_issued_by(*ca);
    };
    std::ranges::stable_partition(lists, is_own);
    const auto ca = *signer_of(lists.front(), cas);
    const std::vector<pki::Crl> others(lists.begin() + 1, lists.end());
    FileTransaction out;
    DDSSEC_RETURN_IF_ERROR(put_list(out, task_.files.crl,
                                    {lists.front(), ca, "CA", &task_.certificate, std::move(cas),
                                     task_.clock.calendar_seconds(), others}));
    return note_files(out.commit_each());
  }

  const DocumentsTask& task_;
  const FetchDocument& fetch_;
  Json members_ = Json::object();
};

}  // namespace

Json keep_documents(const DocumentsTask& task, const FetchDocument& fetch) {
  return DocumentFetcher(task, fetch).run();
}

}  // namespace ddssec::cli
