#include "cli/agent/agent_ca.hpp"

#include <algorithm>
#include <unistd.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/agent/agent_hook.hpp"
#include "cli/agent/agent_schedule.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/signed_permissions.hpp"
#include "cli/frame/new_file.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/passphrase.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/participant.hpp"
#include "governance/write.hpp"
#include "pki/ocsp_address.hpp"
#include "pki/renewal_request.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

// The new validity is as long as the old one. It begins kBackdated before `now`, but a short one
// begins by at most a ninth of its span earlier: otherwise two thirds of it would be over when it
// is issued.
Result<pki::Validity> next_validity(const Arguments& arguments, const pki::Certificate& old,
                                    WallTime now) {
  if (arguments.has("--days")) return validity(arguments, now);
  const auto span = lifetime(old);
  const auto ahead = span >= 2 * kBackdated ? span - kBackdated : span * 8 / 9;
  const auto backdated = ahead >= kBackdated ? seconds(kBackdated) : ahead / 8;
  return pki::Validity{now - backdated, now + std::max(ahead, seconds(1))};
}

// The new certificate must end after the old one. Otherwise a CA that itself ends soon would be
// asked again on every visit.
Status check_later(const pki::Certificate& renewed, const pki::Certificate& old,
                   const pki::Certificate& ca, WallTime now) {
  if (renewed.not_after() > old.not_after() || is_from_the_future(old, now)) return {};
  if (renewed.not_after() < ca.not_after())
    return fail(tool_code::renewal_goes_back,
                {.expected = "an end after " + to_string(old.not_after()),
                 .found = to_string(renewed.not_after()),
                 .note = "the time of --days ends before the certificate in place, and a "
                         "participant that runs does not take such a one",
                 .hint = "give more --days; or replace the certificate by a shorter one now, with "
                         "ddssec identity renew FOLDER --days N, and restart the participant"});
  return fail(Code::outlives_ca,
              {.expected = "an end after " + to_string(old.not_after()),
               .found = to_string(ca.not_after()) + ", the end of " + ca.subject(),
               .hint = "give the CA a later end: ddssec ca renew"});
}

bool has_no_later_end(const Error& error) {
  return error.code() == tool_code::renewal_goes_back || error.code() == Code::outlives_ca;
}

Result<pki::Certificate> issue(const RenewalRequest& request, const pki::Certificate& old,
                               const OpenCa& ca, const Arguments& arguments,
                               const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, next_validity(arguments, old, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto life,
                          within_ca(validity_after(old, wanted, now), ca.certificate(), true));
  DDSSEC_ASSIGN_OR_RETURN(const auto renewed,
                          ca.authority.sign_request(as_bytes(request.request), life, context.random,
                                                    pki::ocsp_responder_of(old)));
  DDSSEC_RETURN_IF_ERROR(check_later(renewed, old, ca.certificate(), now));
  return renewed;
}

pki::RequestedKey key_of_request(const Arguments& arguments) {
  return arguments.has("--rekey") ? pki::RequestedKey::any : pki::RequestedKey::same;
}

// What the CA's log says for a renewal.
struct LoggedPlace {
  fs::path folder;     // to be recorded for the new certificate
  WallTime last = {};  // when the CA issued or revoked something last
  fs::path log = {};
};

// The request comes from the participant, which must not get another name or, without --rekey,
// another key.
Result<LoggedPlace> check_renewable(const RenewalRequest& request, const pki::Certificate& old,
                                    const fs::path& folder, const OpenCa& ca,
                                    const Arguments& arguments) {
  const auto file = folder / "cert.pem";
  DDSSEC_RETURN_IF_ERROR(
      check_renewal_request(as_bytes(request.request), old, key_of_request(arguments)));
  DDSSEC_RETURN_IF_ERROR(check_issuer(old, ca, file));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca.paths));
  const auto next = arguments.has("--rekey") ? NextKey::fresh : NextKey::same;
  DDSSEC_RETURN_IF_ERROR(check_not_revoked(old, file, ca.paths, log, next));
  DDSSEC_RETURN_IF_ERROR(check_own(old, folder, ca.paths, log, {}));
  return LoggedPlace{recorded_folder(old, folder, ca.paths, log),
                     log.latest_before(WallTime::max()).value_or(WallTime{}), ca.paths.log};
}

// Refuses a document that the CA has replaced since: it may give more rights, and each renewal
// would extend it.
Status check_current(const pki::SignedDocument& document, const fs::path& file, const OpenCa& ca) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_signing_log(ca.paths));
  const auto standing = log.standing(document.content(), document.signer(), logged_names(file));
  if (standing == pki::SigningLog::Standing::current) return {};
  const bool is_known = standing == pki::SigningLog::Standing::superseded;
  return fail(
      is_known ? tool_code::document_superseded : tool_code::document_unlogged,
      {.document = file, .expected = "a document that " + ca.paths.signed_log.string() + " has"});
}

// Permissions that the CA may extend.
struct ExtendablePermissions {
  OpenCa ca;
  SignedPermissions old;
  fs::path file;
};

// Rights that had ended when the CA's log was last written have ended, even if the clock was set
// back since.
Status check_not_ended(const SignedPermissions& old, const LoggedPlace& place, const fs::path& file,
                       WallTime now) {
  constexpr std::chrono::minutes kMaxLag{5};
  const auto end = old.grant.validity.not_after;
  const bool is_clock_back = place.last - kMaxLag > now;
  if (!old.has_ended && (!is_clock_back || end > place.last)) return {};
  return fail(
      Code::grant_expired,
      {.document = file,
       .found = "an end on " + to_string(end) +
                (old.has_ended
                     ? ""
                     : fmt::format(", before {}, the latest time in the CA's log {}, and a clock "
                                   "that says {}",
                                   to_string(place.last), place.log.string(), to_string(now))),
       .note = "rights that have ended are not given again unasked",
       .hint = fmt::format(
           "{}give them again: ddssec identity renew {} --ca CA --permissions "
           "--ended-permissions; then start the participant again",
           old.has_ended ? ""
                         : "set the clock; if it is right, that line was written while the clock "
                           "was ahead: ",
           file.parent_path().string())});
}

Result<ExtendablePermissions> extendable_permissions(const RenewalRequest& request,
                                                     const pki::Certificate& certificate,
                                                     const LoggedPlace& place, CaOpener& opener,
                                                     WallTime now) {
  const auto file = place.folder / "permissions.p7s";
  DDSSEC_ASSIGN_OR_RETURN(auto ca, opener.open("permissions"));
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(ca.paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier,
                          pki::DocumentVerifier::make(std::move(certificates)));
  DDSSEC_ASSIGN_OR_RETURN(const auto document,
                          with_default_document(verifier.verify(request.permissions, now), file));
  DDSSEC_RETURN_IF_ERROR(check_moved(ca.paths, document.signer(), file));
  DDSSEC_ASSIGN_OR_RETURN(auto old,
                          with_default_document(own_permissions(document, certificate, now), file));
  DDSSEC_RETURN_IF_ERROR(check_current(document, file, ca));
  DDSSEC_RETURN_IF_ERROR(check_not_ended(old, place, file, now));
  return ExtendablePermissions{std::move(ca), std::move(old), file};
}

// Extends the permissions to the end of the certificate and puts them into the answer, with the
// reason if the renewal list was not written. Those that last as long already stay.
Status extend(const ExtendablePermissions& permissions, const pki::Certificate& certificate,
              const Context& context, RenewalAnswer& answer) {
  const auto& [ca, old, file] = permissions;
  const auto now = context.clock.calendar_seconds();
  if (old.grant.validity.not_after >= certificate.not_after()) return {};
  const auto xml = to_xml(extended(old, certificate, certificate.not_after()));
  DDSSEC_ASSIGN_OR_RETURN(auto out, sign_permissions(ca.authority, xml, now, context.random));
  DDSSEC_RETURN_IF_ERROR(log_signed(ca, as_bytes(xml), file, now, old.text));
  RenewalListAdditions listed;
  listed.add(ca.paths, out, file);
  if (const auto written = listed.write(now); !written) answer.problem = written.error();
  answer.permissions = std::move(out);
  return {};
}

}  // namespace

Result<RenewalAnswer> renew_by_ca(const RenewalRequest& request, const fs::path& folder,
                                  const Arguments& arguments, const Context& context) {
  const auto now = context.clock.calendar_seconds();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  DDSSEC_ASSIGN_OR_RETURN(const auto place, check_renewable(request, old, folder, ca, arguments));
  // Judged before a certificate is logged, which would be of no use if only they are due.
  std::optional<Result<ExtendablePermissions>> permissions;
  if (!request.permissions.empty())
    permissions = extendable_permissions(request, old, place, opener, now);
  if (permissions && !*permissions && request.is_only_for_permissions)
    return std::unexpected(permissions->error());
  const auto renewed = issue(request, old, ca, arguments, context);
  if (!renewed) {
    RenewalAnswer out{.certificate = old.pem()};
    if (permissions && *permissions && has_no_later_end(renewed.error()))
      DDSSEC_RETURN_IF_ERROR(extend(**permissions, old, context, out));
    if (out.permissions.empty()) return std::unexpected(renewed.error());
    return out;
  }
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(
      log_issued(ca.paths, pki::IssueLog::issued_line(*renewed, place.folder.string(), now)));
  RenewalListAdditions listed;
  listed.add(ca.paths, *renewed);
  RenewalAnswer out{renewed->pem()};
  // The certificate is logged already, and a list that cannot be written does not undo that.
  if (const auto written = listed.write(now); !written) out.problem = written.error();
  if (!permissions) return out;
  const auto status = *permissions ? extend(**permissions, *renewed, context, out)
                                   : Status(std::unexpected(permissions->error()));
  if (!status) out.problem = status.error();
  return out;
}

RenewalListOfCa renewal_list_of_ca(const Arguments& arguments) {
  constexpr auto kMax = kMaxAgentLine / 2;
  const fs::path given = arguments.text("--ca");
  const auto identity = ca_paths(given, "identity");
  const auto crl = present_crl(identity);
  const auto renewals = renewals_of(given, crl && *crl ? &**crl : nullptr);
  RenewalListOfCa out;
  if (!renewals.problems.empty()) out.problem = renewals.problems.front();
  if (renewals.list.is_empty()) return out;
  auto text = renewals.list.text();
  if (!text) {
    out.problem = text.error();
  } else if (text->size() < kMax) {
    out.text = *std::move(text);
  } else {
    out.problem = Error(
        Code::file_too_large,
        {.document = identity.renewals,
         .expected = fmt::format("at most {} octets for the lists of both CAs together", kMax),
         .found = std::to_string(text->size()),
         .note = "the agent puts the list into no folder",
         .hint = "put it there after each renewal: ddssec crl distribute --ca " + given.string()});
  }
  return out;
}

namespace {

// False if the passphrase must be typed or can be read only once: it is then kept for the renewal.
bool can_be_read_again(const Arguments& arguments) {
  std::error_code ignored;
  if (arguments.has("--passphrase-file"))
    return !fs::exists(arguments.text("--passphrase-file"), ignored) ||
           fs::is_regular_file(arguments.text("--passphrase-file"), ignored);
  return arguments.has("--passphrase-env") || (::isatty(STDIN_FILENO) == 0 && !writes_nothing());
}

Status check_passphrase(const fs::path& key, const Arguments& arguments) {
  if (key.extension() == ".p11" || !path_exists(key)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const bool encrypted, is_encrypted(key));
  if (!encrypted) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto secret, passphrase(arguments));
  DDSSEC_RETURN_IF_ERROR(read_key(key, &secret));
  return {};
}

}  // namespace

Status check_passphrase(const Arguments& arguments) {
  if (!can_be_read_again(arguments)) return {};
  const fs::path given = arguments.text("--ca");
  DDSSEC_RETURN_IF_ERROR(check_passphrase(ca_paths(given, "identity").key, arguments));
  if (!arguments.has("--permissions")) return {};
  return check_passphrase(ca_paths(given, "permissions").key, arguments);
}

Result<std::vector<pki::Crl>> read_lists(const fs::path& file) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxDocumentOctets));
  return with_default_document(pki::Crl::all_from(octets), file);
}

Status check_not_on(const pki::ChainVerifier& verifier, const pki::Certificate& certificate,
                    const fs::path& file) {
  if (!verifier.is_on_any_list(certificate)) return {};
  return fail(Code::certificate_revoked,
              {.document = file,
               .found = fmt::format("{}, serial {}", certificate.subject(), certificate.serial())});
}

namespace {

// Runs in the agent's own process, with a list that the owner of the folder cannot remove.
Status check_not_on_lists(const TrustedRequesters& trusted, const pki::Certificate& certificate,
                          std::vector<pki::Certificate> cas) {
  const auto file = lists_file(trusted);
  if (file.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(check_trust_file(file));
  DDSSEC_ASSIGN_OR_RETURN(auto lists, read_lists(file));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto verifier,
      with_default_document(
          pki::ChainVerifier::make(std::move(cas), std::move(lists), pki::CrlPolicy::soft_fail),
          trusted.trust));
  DDSSEC_RETURN_IF_ERROR(check_not_on(verifier, certificate, file));
  if (trusted.last.empty()) return {};
  // The owner of the folder may have put back an earlier certificate than the one that was revoked.
  DDSSEC_ASSIGN_OR_RETURN(const auto last, pki::Certificate::from_pem(as_bytes(trusted.last)));
  return check_not_on(verifier, last, file);
}

// A CA's lists need not name a revoked certificate any more once it has expired.
Status check_not_expired(const TrustedRequesters& trusted, const pki::Certificate& certificate,
                         WallTime now) {
  if (trusted.may_have_expired || now < certificate.not_after()) return {};
  return fail(Code::certificate_expired,
              {.found = "an end on " + to_string(certificate.not_after()),
               .note = "revocation lists may not name it any more",
               .hint = "if it was not revoked, issue a new certificate by hand; if the hook itself "
                       "refuses revoked ones, the option --expired lets the agent ask it"});
}

}  // namespace

Status check_owner(const FolderOwner& owner, const Arguments& arguments,
                   const std::filesystem::path& folder) {
  const bool is_foreign = owner.user != ::geteuid();
  ErrorDetails details{.document = folder, .found = fmt::format("a folder of user {}", owner.user)};
  if (is_foreign && arguments.has("--rekey")) {
    details.expected = "a folder of the agent's own user, with --rekey";
    details.hint = "leave out --rekey: then a request shows that it comes from the present key";
  } else if (is_foreign && arguments.has("--hook") && !arguments.has("--trust")) {
    details.expected = "--trust FILE, with a hook for folders of other users";
    details.hint = "name the identity CA's certificate, in a file that only you can write";
  } else {
    return {};
  }
  return fail(tool_code::folder_untrusted, std::move(details));
}

fs::path lists_file(const TrustedRequesters& trusted) {
  if (!trusted.lists.empty() || trusted.trust.empty()) return trusted.lists;
  const auto beside = fs::path(trusted.trust).replace_filename("crl.pem");
  return path_exists(beside) ? beside : fs::path();
}

Status check_requester(const RenewalRequest& request, const TrustedRequesters& trusted,
                       bool is_rekeying, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  const auto key = is_rekeying ? pki::RequestedKey::any : pki::RequestedKey::same;
  DDSSEC_RETURN_IF_ERROR(check_renewal_request(as_bytes(request.request), old, key));
  const auto& trust = trusted.trust;
  if (trust.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(check_trust_file(trust));
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(trust));
  const auto is_issuer = [&](const auto& ca) { return old.is_issued_by(ca); };
  if (std::ranges::none_of(certificates, is_issuer))
    return fail(Code::issuer_unknown,
                {.document = trust,
                 .expected = "the certificate in the folder to be of a CA in this file",
                 .found = "one of " + old.issuer()});
  DDSSEC_RETURN_IF_ERROR(check_not_on_lists(trusted, old, std::move(certificates)));
  return check_not_expired(trusted, old, now);
}

}  // namespace ddssec::cli
