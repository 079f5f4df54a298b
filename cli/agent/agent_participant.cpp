#include "cli/agent/agent_participant.hpp"

#include <algorithm>
#include <fcntl.h>
#include <sys/stat.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/agent/agent_ca.hpp"
#include "cli/agent/agent_response.hpp"
#include "cli/agent/agent_schedule.hpp"
#include "cli/agent/files_in_place.hpp"
#include "cli/agent/renewed_subject.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/signed_permissions.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/chain.hpp"
#include "pki/participant_folder.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The paths of the files in the open folder, written with the folder's name.
pki::ParticipantFolder files_in(const fs::path& folder) {
  auto out = pki::participant_folder(path_in_held_folder(folder));
  for (auto* path : {&out.identity_ca, &out.certificate, &out.key, &out.permissions_ca,
                     &out.governance, &out.permissions, &out.crl, &out.renewals, &out.properties})
    *path = folder / path->filename();
  out.folder = folder;
  return out;
}

// Returns the mode for the successor of a file: its own without rights that no document needs.
Result<unsigned> mode_of(const fs::path& file, unsigned mask) {
  struct stat status {};
  const int folder = folder_descriptor(file.parent_path());
  if (::fstatat(folder, file.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
    return unwritable_error(file, errno);
  if (!S_ISREG(status.st_mode))
    return fail(Code::would_overwrite, {.document = file, .note = "it is not a plain file"});
  return (status.st_mode & mask) | 0600U;
}

// A participant, as read from its folder.
struct Participant {
  const AgentTask& task;
  const Context& context;
  pki::ParticipantFolder files;
  FilesInPlace in_place;  // the files that decide what the CA is asked for
  pki::Certificate certificate;
  // Signed by the folder's permissions CA. Empty: they are not to be extended.
  Bytes permissions = {};
  std::optional<WallTime> permissions_end = {};

  WallTime now() const { return context.clock.calendar_seconds(); }
};

// A permissions document with a grant for this participant.
struct Permissions {
  governance::Grant grant;
  std::string text;
};

Result<Permissions> verified_permissions(const Participant& self, BytesView octets) {
  const auto& files = self.files;
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(files.permissions_ca));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier,
                          pki::DocumentVerifier::make(std::move(certificates)));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      with_default_document(verifier.verify(octets, self.now()), files.permissions));
  DDSSEC_ASSIGN_OR_RETURN(
      auto own, with_default_document(own_permissions(document, self.certificate, self.now()),
                                      files.permissions));
  std::string text(as_text(document.content()));
  std::erase(text, '\r');
  return Permissions{std::move(own.grant), std::move(text)};
}

// Permissions that cannot be read are not extended; `doctor` says why they cannot.
void read_permissions_of(Participant& self) {
  if (!self.task.takes_permissions || !path_exists(self.files.permissions)) return;
  auto octets = read_file(self.files.permissions, pki::kMaxSentPermissionsOctets);
  if (!octets) return;
  const auto found = verified_permissions(self, *octets);
  if (!found) return;
  self.permissions = *std::move(octets);
  self.permissions_end = found->grant.validity.not_after;
}

Result<pki::Certificate> certificate_to_renew(const fs::path& file) {
  auto out = read_certificate(file);
  if (out || out.error().code() != Code::file_not_found) return out;
  return fail(
      Code::file_not_found,
      {.document = file,
       .note = "there is no certificate to renew",
       .hint = "name the folder of a participant, or issue its certificate: ddssec identity "
               "issue NAME --ca CA -o FOLDER"});
}

Result<Participant> read_participant(const AgentTask& task, const LockedFolder* locked,
                                     const Context& context) {
  DDSSEC_RETURN_IF_ERROR(hold_folder(task.folder));
  if (locked != nullptr)
    DDSSEC_RETURN_IF_ERROR(locked->check_same(folder_descriptor(task.folder), task.folder));
  DDSSEC_ASSIGN_OR_RETURN(const auto owner,
                          check_folder(folder_descriptor(task.folder), task.folder));
  DDSSEC_RETURN_IF_ERROR(switch_to_owner(owner));
  DDSSEC_RETURN_IF_ERROR(finish_interrupted(path_in_held_folder(task.folder)));
  auto files = files_in(task.folder);
  if (files.certificate.extension() == ".p11")
    return fail(Code::key_in_token, {.document = files.certificate,
                                     .note = "the certificate is in a token, not in a file"});
  std::vector<fs::path> judged = {files.certificate, files.key};
  if (task.takes_permissions) judged.push_back(files.permissions);
  const FilesInPlace in_place(judged);
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, certificate_to_renew(files.certificate));
  Participant out{task, context, std::move(files), in_place, std::move(certificate)};
  read_permissions_of(out);
  return out;
}

WallTime due_by_certificate(const Participant& self) {
  return self.task.known == to_hex(self.certificate.fingerprint()) ? self.task.known_renewal
                                                                   : renewal_time(self.certificate);
}

bool is_certificate_due(const Participant& self) {
  return is_from_the_future(self.certificate, self.now()) || due_by_certificate(self) <= self.now();
}

// If the permissions end before the certificate, the renewal is due as if the certificate ended
// with them. Permissions that have expired are not renewed: the operator must ask for that.
WallTime due_time(const Participant& self) {
  if (is_from_the_future(self.certificate, self.now())) return self.now();
  const auto by_certificate = due_by_certificate(self);
  if (!self.permissions_end || *self.permissions_end <= self.now()) return by_certificate;
  const auto before = self.certificate.not_after() - *self.permissions_end;
  return before.count() > 0 ? by_certificate - before : by_certificate;
}

Json event_of(std::string_view event, const pki::Certificate& certificate, WallTime next) {
  return {{"event", event},
          {"subject", certificate.subject()},
          {"serial", certificate.serial()},
          {"not_after", to_string(certificate.not_after())},
          {"next", to_string(next)}};
}

Result<pki::PrivateKey> present_key(const Participant& self) {
  const auto& files = self.files;
  if (self.task.uses_no_token && files.key.extension() == ".p11")
    return fail(Code::pkcs11_pin_wrong,
                {.document = files.key, .note = "not tried: a token has refused a PIN before"});
  DDSSEC_ASSIGN_OR_RETURN(auto key, read_key(files.key, nullptr));
  DDSSEC_RETURN_IF_ERROR(with_default_document(key.check_fits(self.certificate), files.key));
  return key;
}

Result<pki::PrivateKey> key_for_request(const Participant& self) {
  const auto& files = self.files;
  if (self.task.is_rekeying) {
    if (files.key.extension() == ".p11") return fail(Code::key_in_token, {.document = files.key});
    DDSSEC_ASSIGN_OR_RETURN(const auto present, read_key(files.key, nullptr));
    DDSSEC_RETURN_IF_ERROR(with_default_document(present.check_fits(self.certificate), files.key));
    const auto kind = self.certificate.key_algorithm();
    return pki::PrivateKey::generate(kind.kind, kind.bits);
  }
  return present_key(self);
}

Result<std::string> request_of_present_key(const Participant& self) {
  DDSSEC_ASSIGN_OR_RETURN(const auto key, present_key(self));
  return pki::make_request(key, self.certificate);
}

std::unexpected<Error> unfit_renewal_error(const Participant& self, std::string expected,
                                           std::string found) {
  return fail(tool_code::renewal_unfit, {.document = self.files.certificate,
                                         .expected = std::move(expected),
                                         .found = std::move(found)});
}

Status check_dates(const Participant& self, const pki::Certificate& renewed) {
  const auto& old = self.certificate;
  if (is_from_the_future(old, self.now())) return {};
  ErrorDetails details{.document = self.files.certificate};
  if (renewed.not_before() < old.not_before()) {
    details.expected = "a begin not before " + to_string(old.not_before());
    details.found = to_string(renewed.not_before());
  } else if (renewed.not_after() <= old.not_after()) {
    details.expected = "an end after " + to_string(old.not_after());
    details.found = to_string(renewed.not_after());
  } else {
    return {};
  }
  return fail(tool_code::renewal_goes_back, std::move(details));
}

// An expired list of the folder may lack later revocations, but what it revokes stays revoked.
// verify() does not look for that in an expired list, so the callers use check_not_on() as well.
Result<pki::ChainVerifier> verifier_of(const Participant& self, pki::CrlPolicy policy) {
  const auto& files = self.files;
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, read_certificates(files.identity_ca));
  std::vector<pki::Crl> lists;
  if (path_exists(files.crl)) {
    DDSSEC_ASSIGN_OR_RETURN(lists, read_lists(files.crl));
  }
  return with_default_document(
      pki::ChainVerifier::make(std::move(anchors), std::move(lists), policy), files.identity_ca);
}

// Says that the error is about the certificate that the CA or the hook answered, not the file.
template <class T>
Result<T> about_answer(Result<T> result, const fs::path& file) {
  if (result) return result;
  auto details = result.error().details();
  details.document = file;
  details.note += details.note.empty() ? "" : "; ";
  details.note += "this is about the certificate that the CA or the hook answered; the file stays";
  if (result.error().code() == Code::issuer_unknown)
    details.hint =
        "let the CA or the hook answer with a certificate of a CA in identity_ca.pem; to change "
        "to another CA, put its certificate into identity_ca.pem first";
  return fail(result.error().code(), std::move(details));
}

Status check_chain(const Participant& self, const pki::Certificate& renewed) {
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, verifier_of(self, pki::CrlPolicy::soft_fail));
  DDSSEC_RETURN_IF_ERROR(
      about_answer(verifier.verify(renewed, self.now()), self.files.certificate));
  // Nor may the one in place be revoked: the issuer of the new one may not know of the list.
  DDSSEC_RETURN_IF_ERROR(check_not_on(verifier, self.certificate, self.files.crl));
  return check_not_on(verifier, renewed, self.files.crl);
}

Result<pki::Certificate> checked(const Participant& self, const std::string& pem,
                                 const pki::PrivateKey& key) {
  const auto& file = self.files.certificate;
  DDSSEC_ASSIGN_OR_RETURN(const auto renewed,
                          about_answer(pki::Certificate::from_pem(as_bytes(pem)), file));
  if (auto other = other_subject(self.certificate, renewed)) {
    other->document = file;
    return fail(tool_code::renewal_unfit, *std::move(other));
  }
  if (renewed.is_ca())
    return unfit_renewal_error(self, "the certificate of a participant", "one of a CA");
  DDSSEC_RETURN_IF_ERROR(about_answer(key.check_fits(renewed), file));
  DDSSEC_RETURN_IF_ERROR(check_chain(self, renewed));
  DDSSEC_RETURN_IF_ERROR(check_dates(self, renewed));
  return renewed;
}

// Puts the key first, as `identity renew` does.
Status put_certificate(const Participant& self, const pki::Certificate& renewed,
                       const pki::PrivateKey& key, FileTransaction& out) {
  const auto& files = self.files;
  if (self.task.is_rekeying) {
    DDSSEC_ASSIGN_OR_RETURN(const auto mode, mode_of(files.key, 0640));
    DDSSEC_ASSIGN_OR_RETURN(const auto pem, key.to_pem());
    DDSSEC_RETURN_IF_ERROR(
        pem.expose([&](BytesView octets) { return out.put(files.key, octets, mode); }));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto mode, mode_of(files.certificate, 0644));
  return out.put(files.certificate, as_bytes(renewed.pem()), mode);
}

Status put_permissions(const Participant& self, const Bytes& octets, FileTransaction& out) {
  const auto& file = self.files.permissions;
  DDSSEC_ASSIGN_OR_RETURN(auto permissions, verified_permissions(self, octets));
  const auto text = std::move(permissions).text;
  const auto plain = fs::path(file).replace_extension("xml");
  if (path_exists(plain)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto mode, mode_of(plain, 0644));
    DDSSEC_RETURN_IF_ERROR(out.put(plain, as_bytes(text), mode));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto mode, mode_of(file, 0644));
  return out.put(file, octets, mode);
}

Json to_json(const std::vector<WrittenFile>& files) {
  Json out = Json::array();
  for (const auto& file : files)
    out.push_back({{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}});
  return out;
}

// Returns when the renewed certificate is to be renewed. If its validity began long ago, that is
// when two thirds of the remaining time are over.
WallTime renewal_from(const pki::Certificate& renewed, WallTime now) {
  return std::max(renewal_time(renewed), now + (renewed.not_after() - now) * 2 / 3);
}

Status put_list_of_ca(const Participant& self, const std::string& renewals) {
  DDSSEC_ASSIGN_OR_RETURN(const auto list, pki::RenewalList::parse(as_bytes(renewals)));
  FileTransaction out;
  KnownRenewals known;
  DDSSEC_RETURN_IF_ERROR(put_renewals(out, self.files, {list, {}, {}, self.now(), known}));
  DDSSEC_RETURN_IF_ERROR(out.commit_each());
  return {};
}

// A list that cannot be written does not undo a renewal.
void keep_renewals(const Participant& self, const std::string& renewals, Json& event) {
  if (renewals.empty()) return;
  const auto status = put_list_of_ca(self, renewals);
  if (!status && !event.contains("problem")) event["problem"] = error_to_json(status.error());
}

// Keeps what peers want to see beside the certificate in the folder: the OCSP response, and the
// renewal list (`renewals`; if it is empty, that of the task).
void keep_for_peers(const Participant& self, const pki::Certificate& certificate,
                    const std::string& renewals, Json& event) {
  keep_response({self.files, certificate, self.now(), self.task.responders}, event);
  keep_renewals(self, renewals.empty() ? self.task.renewals : renewals, event);
}

Json renewed_event(const Participant& self, const pki::Certificate& certificate, WallTime next,
                   const RenewalAnswer& answer, const std::vector<WrittenFile>& files) {
  auto event = event_of("renewed", certificate, next);
  event["rekeyed"] = false;
  event["permissions_extended"] = !answer.permissions.empty();
  event["restart_needed"] = self.certificate.not_after() <= self.now();
  event["files"] = to_json(files);
  event["sha256"] = to_hex(certificate.fingerprint());
  if (answer.problem) event["problem"] = error_to_json(*answer.problem);
  return event;
}

Result<std::vector<WrittenFile>> commit(const Participant& self, FileTransaction& out) {
  DDSSEC_RETURN_IF_ERROR(self.in_place.check_unchanged());
  return out.commit();
}

// The CA has no certificate with a later end, for example because the CA itself ends then. Without
// this, the permissions would end before the certificate although the CA can extend them.
Result<Json> extend_permissions(const Participant& self, const AgentServices& agent,
                                const RenewalAnswer& answer) {
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(put_permissions(self, answer.permissions, out));
  DDSSEC_ASSIGN_OR_RETURN(const auto files, commit(self, out));
  auto event = renewed_event(self, self.certificate, due_by_certificate(self), answer, files);
  agent.report_renewed(event);
  keep_for_peers(self, self.certificate, answer.renewals, event);
  return event;
}

Result<Json> renew(const Participant& self, const AgentServices& agent) {
  DDSSEC_RETURN_IF_ERROR(mode_of(self.files.certificate, 0));  // before the CA is asked
  DDSSEC_ASSIGN_OR_RETURN(const auto key, key_for_request(self));
  DDSSEC_ASSIGN_OR_RETURN(auto pem, pki::make_request(key, self.certificate));
  // Checked before the CA issues anything, because a CA behind a hook may not know of the list.
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, verifier_of(self, pki::CrlPolicy::soft_fail));
  DDSSEC_RETURN_IF_ERROR(check_not_on(verifier, self.certificate, self.files.crl));
  const RenewalRequest request{.request = std::move(pem),
                               .certificate = self.certificate.pem(),
                               .permissions = self.permissions,
                               .lifetime = lifetime(self.certificate),
                               .is_only_for_permissions = !is_certificate_due(self)};
  DDSSEC_ASSIGN_OR_RETURN(const auto answer, agent.ask(request));
  // If only the permissions are due and cannot be extended, the certificate is not renewed alone:
  // that would be repeated on every visit.
  if (answer.permissions.empty() && answer.problem && request.is_only_for_permissions)
    return std::unexpected(*answer.problem);
  if (answer.certificate == request.certificate && !answer.permissions.empty())
    return extend_permissions(self, agent, answer);
  DDSSEC_ASSIGN_OR_RETURN(const auto renewed, checked(self, answer.certificate, key));
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(put_certificate(self, renewed, key, out));
  if (!answer.permissions.empty())
    DDSSEC_RETURN_IF_ERROR(put_permissions(self, answer.permissions, out));
  DDSSEC_ASSIGN_OR_RETURN(const auto files, commit(self, out));
  auto event = renewed_event(self, renewed, renewal_from(renewed, self.now()), answer, files);
  event["rekeyed"] = self.task.is_rekeying;
  agent.report_renewed(event);
  keep_for_peers(self, renewed, answer.renewals, event);
  return event;
}

// A key in a token is not tried, because each trial needs the PIN.
Status check_key(const Participant& self) {
  if (self.files.key.extension() == ".p11") return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto key, read_key(self.files.key, nullptr));
  return with_default_document(key.check_fits(self.certificate), self.files.key);
}

Status check_permissions(const Participant& self) {
  const auto& file = self.files.permissions;
  if (!self.task.takes_permissions || !path_exists(file)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxSentPermissionsOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions, verified_permissions(self, octets));
  const auto end = permissions.grant.validity.not_after;
  if (end > self.now()) return {};
  return fail(
      Code::grant_expired,
      {.document = file,
       .found = "an end on " + to_string(end),
       .note = "the participant cannot start, and rights that have ended are not given "
               "again unasked",
       .hint = fmt::format("give them again: ddssec identity renew {} --ca CA --permissions "
                           "--ended-permissions; then start the participant again",
                           self.files.folder.string())});
}

// Judges the certificate as the participant does when it starts.
Status check_certificate(const Participant& self) {
  const auto& files = self.files;
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, verifier_of(self, pki::CrlPolicy::hard_fail));
  if (const auto chain = verifier.verify(self.certificate, self.now()); !chain) {
    const auto code = chain.error().code();
    const bool is_about_list = code >= Code::crl_missing && code <= Code::crl_signature_invalid;
    return std::unexpected(
        chain.error().with_default_document(is_about_list ? files.crl : files.certificate));
  }
  return check_not_on(verifier, self.certificate, files.crl);
}

// Warns in the last sixth of a list's time, as a participant does. Comes last, to hide no problem.
Status check_lists_last(const Participant& self) {
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, verifier_of(self, pki::CrlPolicy::hard_fail));
  DDSSEC_ASSIGN_OR_RETURN(const auto chain, verifier.verify(self.certificate, self.now()));
  const auto end = chain.crl_next_update();
  if (!end || *end <= self.now()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, read_lists(self.files.crl));
  const auto list = std::ranges::find(lists, end, &pki::Crl::next_update);
  if (list == lists.end() || self.now() <= *end - (*end - list->this_update()) / 6) return {};
  return fail(Code::crl_ends_soon,
              {.document = self.files.crl, .field = "nextUpdate", .found = to_string(*end)});
}

// With faulty files the participant does not start, and the next renewal fails.
Status check_fit(const Participant& self) {
  DDSSEC_RETURN_IF_ERROR(check_key(self));
  DDSSEC_RETURN_IF_ERROR(check_certificate(self));
  return check_permissions(self);
}

Json not_renewed(const Participant& self, WallTime due) {
  auto event = event_of(due > self.now() ? "current" : "due", self.certificate, due);
  if (const auto fit = check_fit(self); !fit) event["problem"] = error_to_json(fit.error());
  return event;
}

// Without the renewal list, sessions with renewed participants would end. Without the OCSP
// response, peers would refuse this one. Their errors matter less than that of the renewal.
Result<Json> after_failure(const Participant& self, const AgentServices& agent,
                           const Error& error) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  agent.report_failed(error);
  auto kept = event_of("current", self.certificate, self.now());
  keep_for_peers(self, self.certificate, {}, kept);
  Json out = error_line(error);
  for (const auto* name : {"files", "ocsp_silent"})
    if (kept.contains(name)) out[name] = kept[name];
  return out;
}

}  // namespace

Result<Json> maintain_folder(const AgentTask& task, const LockedFolder* locked,
                             const AgentServices& agent, const Context& context) {
  ::umask(022);
  DDSSEC_ASSIGN_OR_RETURN(const auto self, read_participant(task, locked, context));
  // Documents are fetched first, so that a new revocation list can stop the renewal of a
  // certificate that it revokes.
  if (task.fetches_documents && !task.is_dry_run)
    agent.report_documents(keep_documents(
        {self.files, self.certificate, context.clock, [&] { return request_of_present_key(self); }},
        agent.fetch));
  const auto due = due_time(self);
  if (task.is_only_for_list) {
    auto event = event_of("current", self.certificate, due);
    keep_renewals(self, task.renewals, event);
    return event;
  }
  if (due > self.now() || task.is_waiting) {
    auto event = not_renewed(self, due);
    if (!task.is_dry_run) keep_for_peers(self, self.certificate, {}, event);
    if (const auto lists = check_lists_last(self); !lists && !event.contains("problem"))
      event["problem"] = error_to_json(lists.error());
    return event;
  }
  if (task.is_dry_run) return not_renewed(self, due);
  auto event = renew(self, agent);
  return event ? event : after_failure(self, agent, event.error());
}

}  // namespace ddssec::cli
