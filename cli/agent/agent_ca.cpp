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

// The request comes from the participant, which must not get another name or, without --rekey,
// another key. Returns the folder to record for the new certificate.
Result<fs::path> check_renewable(const RenewalRequest& request, const pki::Certificate& old,
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
  return recorded_folder(old, folder, ca.paths, log);
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

struct ExtensionByCa {
  Bytes permissions = {};             // empty if those in place last as long as the certificate
  std::optional<Error> problem = {};  // the reason why the renewal list was not written
};

Result<ExtensionByCa> extended_by_ca(const Bytes& old_octets, const pki::Certificate& renewed,
                                     const fs::path& file, CaOpener& opener,
                                     const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("permissions"));
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(ca.paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier,
                          pki::DocumentVerifier::make(std::move(certificates)));
  DDSSEC_ASSIGN_OR_RETURN(const auto document,
                          with_default_document(verifier.verify(old_octets, now), file));
  DDSSEC_RETURN_IF_ERROR(check_moved(ca.paths, document.signer(), file));
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          with_default_document(own_permissions(document, renewed, now), file));
  DDSSEC_RETURN_IF_ERROR(check_current(document, file, ca));
  if (old.grant.validity.not_after >= renewed.not_after()) return ExtensionByCa{};
  if (old.has_ended)
    return fail(
        Code::grant_expired,
        {.document = file,
         .found = "an end on " + to_string(old.grant.validity.not_after),
         .note = "rights that have ended are not given again unasked",
         .hint = fmt::format("give them again: ddssec identity renew {} --ca CA --permissions "
                             "--ended-permissions; then start the participant again",
                             file.parent_path().string())});
  const auto xml = to_xml(extended(old, renewed, renewed.not_after()));
  DDSSEC_ASSIGN_OR_RETURN(auto out, sign_permissions(ca.authority, xml, now, context.random));
  DDSSEC_RETURN_IF_ERROR(log_signed(ca, as_bytes(xml), file, now, old.text));
  RenewalListAdditions listed;
  listed.add(ca.paths, out, file);
  const auto written = listed.write(now);
  return ExtensionByCa{std::move(out), written ? std::nullopt : std::optional(written.error())};
}

}  // namespace

Result<RenewalAnswer> renew_by_ca(const RenewalRequest& request, const fs::path& folder,
                                  const Arguments& arguments, const Context& context) {
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  DDSSEC_ASSIGN_OR_RETURN(const auto home, check_renewable(request, old, folder, ca, arguments));
  const auto extended_until_end_of = [&](const pki::Certificate& certificate) {
    return extended_by_ca(request.permissions, certificate, home / "permissions.p7s", opener,
                          context);
  };
  const auto renewed = issue(request, old, ca, arguments, context);
  if (!renewed) {
    if (request.permissions.empty() || !has_no_later_end(renewed.error()))
      return std::unexpected(renewed.error());
    auto extended = extended_until_end_of(old);
    if (!extended || extended->permissions.empty()) return std::unexpected(renewed.error());
    return RenewalAnswer{.certificate = old.pem(),
                         .permissions = std::move(extended->permissions),
                         .problem = std::move(extended->problem)};
  }
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(log_issued(
      ca.paths,
      pki::IssueLog::issued_line(*renewed, home.string(), context.clock.calendar_seconds())));
  RenewalListAdditions listed;
  listed.add(ca.paths, *renewed);
  RenewalAnswer out{renewed->pem()};
  // The certificate is logged already, and a list that cannot be written does not undo that.
  if (const auto written = listed.write(context.clock.calendar_seconds()); !written)
    out.problem = written.error();
  if (request.permissions.empty()) return out;
  auto permissions = extended_until_end_of(*renewed);
  if (permissions) {
    out.permissions = std::move(permissions->permissions);
    if (permissions->problem) out.problem = std::move(permissions->problem);
  } else {
    out.problem = std::move(permissions).error();
  }
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
  return check_not_on(verifier, certificate, file);
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
                       bool is_rekeying) {
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  const auto key = is_rekeying ? pki::RequestedKey::any : pki::RequestedKey::same;
  DDSSEC_RETURN_IF_ERROR(check_renewal_request(as_bytes(request.request), old, key));
  const auto& trust = trusted.trust;
  if (trust.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(check_trust_file(trust));
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(trust));
  for (const auto& ca : certificates)
    if (old.is_issued_by(ca)) return check_not_on_lists(trusted, old, std::move(certificates));
  return fail(Code::issuer_unknown,
              {.document = trust,
               .expected = "the certificate in the folder to be of a CA in this file",
               .found = "one of " + old.issuer()});
}

}  // namespace ddssec::cli
