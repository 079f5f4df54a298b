// identity renew: replaces a certificate by one with a new validity.
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/granted_domains.hpp"
#include "cli/documents/signed_permissions.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/participant.hpp"
#include "cli/participant/running_participant.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Reads permissions only if the permissions CA of --ca signed them. The CA's certificate in the
// folder does not count, because the participant controls it.
Result<SignedPermissions> permissions_in(const pki::ParticipantFolder& files, const fs::path& ca,
                                         const pki::Certificate& certificate, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto proof, verified(files.permissions, ca, now));
  return with_default_document(own_permissions(proof, certificate, now), files.permissions);
}

// Empty if --ca has only an identity CA.
fs::path permissions_ca(const Arguments& arguments) {
  const fs::path given = arguments.text("--ca");
  auto out = ca_paths(given, "permissions").certificate;
  return path_exists(out) && out != ca_paths(given, "identity").certificate ? out : fs::path();
}

// Returns the permissions to report. Empty if the CA did not sign them.
std::optional<SignedPermissions> permissions_seen(const pki::ParticipantFolder& files,
                                                  const Arguments& arguments,
                                                  const pki::Certificate& certificate,
                                                  WallTime now) {
  const auto ca = permissions_ca(arguments);
  if (!path_exists(files.permissions) || ca.empty()) return std::nullopt;
  auto out = permissions_in(files, ca, certificate, now);
  return out ? std::optional(*std::move(out)) : std::nullopt;
}

// A participant with another CA in its folder would not accept what this CA signs.
Status check_same_ca(const pki::ParticipantFolder& files, const OpenCa& ca) {
  if (!path_exists(files.permissions_ca)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto trusted, read_certificates(ca.paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificates, read_certificates(files.permissions_ca));
  for (const auto& one : certificates)
    if (std::ranges::find(trusted, one) == trusted.end())
      return fail(Code::smime_signer_not_permissions_ca,
                  {.document = files.permissions_ca,
                   .expected = ca.certificate().subject() + " of " + ca.paths.certificate.string(),
                   .found = one.subject() + ", another certificate",
                   .hint = "find out how it came into the folder; then put the CA's own file in "
                           "its place, and look at permissions.p7s: ddssec permissions show"});
  return {};
}

// A right that has expired may have been left to expire intentionally.
Status check_not_ended(const SignedPermissions& old, const pki::ParticipantFolder& files,
                       const Arguments& arguments) {
  if (!old.has_ended || arguments.has("--ended-permissions")) return {};
  return fail(Code::grant_expired,
              {.document = files.permissions,
               .found = "an end on " + date(old.grant.validity.not_after),
               .note = "rights that have ended are not given again unasked",
               .hint = "ddssec permissions new makes new ones; --ended-permissions extends these "
                       "anyway; without --permissions only the certificate is renewed"});
}

// The folder's owner may have put back an older document that gives more. The agent makes the same
// check.
Status check_not_superseded(const pki::ParticipantFolder& files, const OpenCa& ca, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto proof, verified(files.permissions, ca.paths.certificate, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_signing_log(ca.paths));
  if (log.standing(proof.content(), proof.signer(), logged_names(files.permissions)) !=
      pki::SigningLog::Standing::superseded)
    return {};
  return fail(
      tool_code::document_superseded,
      {.document = files.permissions,
       .expected = "the last document that " + ca.paths.signed_log.string() + " has",
       .hint = "put the later document into its place; if this one is meant after all, sign "
               "its XML again: ddssec permissions sign; without --permissions only the "
               "certificate is renewed"});
}

// One renewal: the files in the folder, and those that replace them.
struct Renewal {
  const Arguments& arguments;
  const Context& context;
  fs::path path;  // the path of the certificate
  pki::ParticipantFolder files;
  pki::Certificate old;
  fs::path recorded = {};                             // the folder that the CA's log records
  std::optional<SignedPermissions> permissions = {};  // those in the folder, if the CA signed them

  WallTime now() const { return context.clock.calendar_seconds(); }
  bool is_rekeying() const { return arguments.has("--rekey"); }
};

// The facts that both results contain.
struct RenewalFacts {
  bool renewed;
  fs::path file;
  CertificateFacts certificate;  // the certificate that is in the file now

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&RenewalFacts::renewed>(), field<&RenewalFacts::file>()),
                          fields_within(&RenewalFacts::certificate));
  }
};

struct RenewedIdentity {
  RenewalFacts facts;
  bool rekeyed;
  std::optional<WallTime> permissions_until = {};
  bool permissions_extended = false, permissions_had_ended = false;

  static constexpr auto fields() {
    using Self = RenewedIdentity;
    return std::tuple_cat(
        fields_within(&Self::facts),
        std::tuple(field<&Self::rekeyed>(), field<&Self::permissions_until>({"null: none"})));
  }
  std::string text() const {
    const auto& [renewed, file, certificate] = facts;
    return fmt::format("{}  {}  {}expires {}\n", file.string(), certificate.subject,
                       rekeyed ? "with a new key, " : "", date(certificate.not_after)) +
           permissions_text();
  }

 private:
  std::string permissions_text() const {
    const auto end = facts.certificate.not_after;
    if (permissions_extended) return fmt::format("permissions extended to {}\n", date(end));
    if (!permissions_until || *permissions_until >= end) return {};
    return fmt::format("permissions {} {}\n  {}\n",
                       permissions_had_ended ? "expired and the participant cannot start, since"
                                             : "end before it, on",
                       date(*permissions_until) == date(end)
                           ? fmt::format("{}, and the certificate on {}",
                                         to_string(*permissions_until), to_string(end))
                           : date(*permissions_until),
                       permissions_had_ended ? "--permissions --ended-permissions gives them again"
                                             : "--permissions extends them as well");
  }
};

struct UnchangedIdentity {
  static constexpr std::string_view kWhen = "not needed";
  RenewalFacts facts;

  static constexpr auto fields() { return fields_within(&UnchangedIdentity::facts); }
  std::string text() const {
    return fmt::format("{}  not needed: expires {}\n", facts.file.string(),
                       date(facts.certificate.not_after));
  }
};

using IdentityRenewal = Answer<std::variant<RenewedIdentity, UnchangedIdentity>>;

Result<governance::Permissions> put_extended(FileTransaction& out, const Renewal& job,
                                             const pki::Certificate& renewed, const OpenCa& ca,
                                             Report& report) {
  const auto& files = job.files;
  const auto now = job.now();
  DDSSEC_RETURN_IF_ERROR(check_same_ca(files, ca));
  DDSSEC_RETURN_IF_ERROR(check_moved(ca.paths, files.permissions, now));
  DDSSEC_RETURN_IF_ERROR(check_not_superseded(files, ca, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          permissions_in(files, ca.paths.certificate, renewed, now));
  DDSSEC_RETURN_IF_ERROR(check_not_ended(old, files, job.arguments));
  auto document = extended(old, renewed, renewed.not_after());
  const auto xml = to_xml(document);
  DDSSEC_ASSIGN_OR_RETURN(const auto octets,
                          sign_permissions(ca.authority, xml, now, job.context.random));
  const auto plain = fs::path(files.permissions).replace_extension("xml");
  if (path_exists(plain)) DDSSEC_RETURN_IF_ERROR(out.put_public(plain, xml));
  DDSSEC_RETURN_IF_ERROR(out.put(files.permissions, octets, 0644));
  DDSSEC_RETURN_IF_ERROR(
      log_signed(ca, as_bytes(xml), job.recorded / files.permissions.filename(), now, old.text));
  RenewalListAdditions listed;
  listed.add(ca.paths, octets, files.permissions);
  if (const auto written = listed.write(now); !written) report.errors.push_back(written.error());
  return document;
}

std::string topics_in_words(const std::vector<governance::Criteria>& criteria) {
  constexpr std::size_t kMax = 4;
  std::vector<std::string> topics;
  for (const auto& one : criteria)
    for (const auto& topic : one.topics) topics.push_back(topic.text);
  auto out = fmt::format(
      "{}", fmt::join(topics.begin(), topics.begin() + std::min(kMax, topics.size()), ", "));
  return topics.size() > kMax ? fmt::format("{} and {} more", out, topics.size() - kMax) : out;
}

// One line about the document that the CA has just signed.
std::string signed_in_words(const governance::Permissions& document, const fs::path& folder) {
  const auto& grant = document.grants.front();
  std::string out;
  for (const auto& rule : grant.rules)
    for (const auto& [verb, criteria] :
         {std::pair("publish", &rule.publish), std::pair("subscribe", &rule.subscribe)})
      if (!criteria->empty() && out.size() < 200)
        out += fmt::format("{}{} {} {}", out.empty() ? "" : "; ", rule.allow ? "allow" : "deny",
                           verb, topics_in_words(*criteria));
  return fmt::format("  signed for {}: {}{}default {}; all of it: ddssec permissions show {}\n",
                     grant.subject_name, out, out.empty() ? "" : "; ",
                     grant.default_allow ? "ALLOW" : "DENY", folder.string());
}

std::unexpected<Error> unfit_key_error(const pki::ParticipantFolder& files,
                                       const pki::Certificate& certificate, std::string found) {
  return fail(Code::key_mismatch,
              {.document = files.key,
               .expected = fmt::format("the key of {}, which {} certifies", certificate.subject(),
                                       files.certificate.string()),
               .found = std::move(found),
               .hint = "put back the key or the certificate that belongs to the other; if the key "
                       "is lost: ddssec identity issue --replace"});
}

// Checks the key only if it is in the folder and not encrypted. A folder that came back from a
// device may contain another participant's certificate.
Status check_fits_key(const pki::ParticipantFolder& files, const pki::Certificate& certificate) {
  if (files.key.extension() == ".p11" || !path_exists(files.key)) return {};
  const auto encrypted = is_encrypted(files.key);
  if (!encrypted || *encrypted) return {};
  const auto key = read_key(files.key, nullptr);
  if (!key || key->check_fits(certificate)) return {};
  return unfit_key_error(files, certificate, "another key");
}

// With --rekey the folder's owner gets a new key for the name in the certificate. Certificates are
// public, so only the key proves that the name is the owner's.
Status check_has_key(const pki::ParticipantFolder& files, const pki::Certificate& certificate) {
  if (files.key.extension() == ".p11") return fail(Code::key_in_token, {.document = files.key});
  if (!path_exists(files.key)) return unfit_key_error(files, certificate, "none");
  DDSSEC_ASSIGN_OR_RETURN(const bool encrypted, is_encrypted(files.key));
  if (encrypted) return unfit_key_error(files, certificate, "a key with a passphrase, unread");
  DDSSEC_ASSIGN_OR_RETURN(const auto key, read_key(files.key, nullptr));
  return key.check_fits(certificate) ? Status()
                                     : unfit_key_error(files, certificate, "another key");
}

Status put_key(FileTransaction& out, const fs::path& path, const pki::PrivateKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, key.to_pem());
  return pem.expose([&](BytesView octets) { return out.put(path, octets, 0600); });
}

Result<bool> is_needed(const Arguments& arguments, const pki::Certificate& certificate,
                       WallTime now) {
  if (!arguments.has("--within")) return true;
  DDSSEC_ASSIGN_OR_RETURN(const auto within, duration(arguments, "--within"));
  return certificate.not_after() < now + within;
}

// Success for the folder's own certificate, if the participant is not revoked. Returns the folder
// to record for the new certificate.
Result<fs::path> check_renewable(const Renewal& job, const OpenCa& ca) {
  DDSSEC_RETURN_IF_ERROR(check_issuer(job.old, ca, job.path));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca.paths));
  const auto next = job.is_rekeying() ? NextKey::fresh : NextKey::same;
  DDSSEC_RETURN_IF_ERROR(check_not_revoked(job.old, job.path, ca.paths, log, next));
  const auto folder = job.path.parent_path();
  DDSSEC_RETURN_IF_ERROR(
      check_own(job.old, folder, ca.paths, log, job.arguments.text("--subject")));
  DDSSEC_RETURN_IF_ERROR(job.is_rekeying() ? check_has_key(job.files, job.old)
                                           : check_fits_key(job.files, job.old));
  return recorded_folder(job.old, folder, ca.paths, log);
}

// A link that leads nowhere cannot be extended, and must not be ignored.
Status check_no_broken_link(const fs::path& permissions) {
  std::error_code ignored;
  if (path_exists(permissions) || !fs::is_symlink(path_in_held_folder(permissions))) return {};
  return fail(Code::file_not_found,
              {.document = permissions,
               .note = "it is a link that leads nowhere",
               .hint = "put the permissions in its place, or remove the link; without "
                       "--permissions only the certificate is renewed"});
}

// Says with --permissions why nothing was extended.
std::string unchanged_permissions_text(const std::optional<SignedPermissions>& seen) {
  if (!seen)
    return "no permissions are in the folder, so none were extended: ddssec permissions new makes "
           "them\n";
  return fmt::format("permissions stay as they are: they end on {}, not before the certificate\n",
                     date(seen->grant.validity.not_after));
}

// Renews the permissions with the certificate, if that was requested and is needed.
Status renew_permissions(const Renewal& job, const pki::Certificate& renewed, CaOpener& opener,
                         FileTransaction& out, Answer<RenewedIdentity>& answer) {
  if (job.arguments.has("--permissions"))
    DDSSEC_RETURN_IF_ERROR(check_no_broken_link(job.files.permissions));
  auto& [result, report, has_result] = answer;
  const auto& seen = job.permissions;
  if (seen) {
    result.permissions_until = seen->grant.validity.not_after;
    result.permissions_had_ended = seen->has_ended;
  }
  if (job.arguments.has("--permissions") && path_exists(job.files.permissions) &&
      (!seen || *result.permissions_until < renewed.not_after())) {
    DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("permissions"));
    DDSSEC_ASSIGN_OR_RETURN(const auto document, put_extended(out, job, renewed, ca, report));
    result.permissions_until = renewed.not_after();
    result.permissions_extended = true;
    report.text += signed_in_words(document, job.path.parent_path());
    report.findings = uncovered_grants(document, job.files.governance, job.files.permissions);
  } else if (!seen && path_exists(job.files.permissions) &&
             !permissions_ca(job.arguments).empty()) {
    report.text += fmt::format(
        "permissions.p7s is not what this permissions CA signed for {}: "
        "ddssec doctor {}\n",
        renewed.subject(), job.path.parent_path().string());
  } else if (job.arguments.has("--permissions")) {
    report.text += unchanged_permissions_text(seen);
  }
  return {};
}

// Reports what the renewal means for a running participant.
void add_consequence(const Renewal& job, const pki::Certificate& renewed,
                     Answer<RenewedIdentity>& answer) {
  auto& [result, report, has_result] = answer;
  if (job.old.not_after() <= job.now()) {
    report.text +=
        "the identity had ended, and with it all connections: start the participant again\n";
    return;
  }
  if (result.permissions_had_ended) {
    if (result.permissions_extended)
      report.text +=
          "the permissions had ended, and with them all connections: start the participant again\n";
    return;
  }
  const bool is_in_place = job.path == job.files.certificate;
  const auto problem =
      certificate_refusal_warning(job.files, job.old, renewed, job.is_rekeying() || !is_in_place);
  if (problem)
    report.errors.push_back(*problem);
  else
    report.text +=
        "a participant on ddssec's plugins takes it while it runs; with stock plugins, restart "
        "it\n";
}

Result<IdentityRenewal> renew(Renewal job) {
  const auto& [arguments, context, path, files, old, recorded, permissions] = job;
  const auto now = job.now();
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, validity(arguments, now));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  // Reads the certificate again, because the command may have waited for a rotation.
  DDSSEC_ASSIGN_OR_RETURN(job.old, certificate_of(path));
  DDSSEC_ASSIGN_OR_RETURN(job.recorded, check_renewable(job, ca));
  job.permissions = permissions_seen(files, arguments, old, now);
  DDSSEC_ASSIGN_OR_RETURN(const auto life, within_ca(validity_after(old, wanted, now),
                                                     ca.certificate(), arguments.has("--clamp")));
  std::optional<pki::PrivateKey> key;
  if (job.is_rekeying()) {
    DDSSEC_ASSIGN_OR_RETURN(
        key, pki::PrivateKey::generate(old.key_algorithm().kind, old.key_algorithm().bits));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto renewed,
                          ca.authority.reissue(old, life, context.random, key ? &*key : nullptr));
  FileTransaction out;
  if (key) DDSSEC_RETURN_IF_ERROR(put_key(out, files.key, *key));
  DDSSEC_RETURN_IF_ERROR(out.put_public(path, renewed.pem()));
  Answer<RenewedIdentity> answer{{{true, path, CertificateFacts::of(renewed)}, job.is_rekeying()}};
  auto& report = answer.report;
  DDSSEC_RETURN_IF_ERROR(renew_permissions(job, renewed, opener, out, answer));
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(log_issued(
      ca.paths,
      pki::IssueLog::issued_line(renewed, recorded.string(), now, path.filename().string())));
  add_consequence(job, renewed, answer);
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, out.commit());
  RenewalListAdditions listed;
  listed.add(ca.paths, renewed);
  if (const auto written = listed.write(now); !written) report.errors.push_back(written.error());
  return IdentityRenewal{std::move(answer.result), std::move(report)};
}

// Only the end of the certificate decides whether a renewal is needed.
std::string unrenewed_permissions_text(const Renewal& job) {
  const auto seen = permissions_seen(job.files, job.arguments, job.old, job.now());
  if (!seen) return {};
  const auto end = seen->grant.validity.not_after;
  return fmt::format("permissions stay as they are: they end on {}{}\n", date(end),
                     end < job.old.not_after()
                         ? ", before the certificate; without --within they are extended"
                         : "");
}

Result<IdentityRenewal> identity_renew(const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("PATH");
  const auto path = certificate_path(given);
  const auto folder = path.parent_path();
  std::error_code ignored;
  if (fs::is_directory(folder.empty() ? "." : folder, ignored))
    DDSSEC_RETURN_IF_ERROR(hold_folder(folder));
  DDSSEC_RETURN_IF_ERROR(finish_interrupted(folder));
  DDSSEC_RETURN_IF_ERROR(certificate_of(given));
  DDSSEC_RETURN_IF_ERROR(hold_folder(folder));
  DDSSEC_ASSIGN_OR_RETURN(const auto old, certificate_of(path));
  const Renewal job{arguments, context, path, pki::participant_folder(folder), old};
  DDSSEC_ASSIGN_OR_RETURN(const auto needed, is_needed(arguments, job.old, job.now()));
  if (needed) return renew(job);
  IdentityRenewal answer{UnchangedIdentity{{false, path, CertificateFacts::of(old)}}};
  if (arguments.has("--permissions")) answer.report.text = unrenewed_permissions_text(job);
  return answer;
}

}  // namespace

std::vector<Command> identity_renew_commands() {
  return {
      {.group = "identity",
       .name = "renew",
       .summary = "Gives a participant a certificate with a new validity, in place of the old.",
       .positionals = {{"PATH", "a participant's folder or its certificate"}},
       .options = {ca_option("the CA that issued it"),
                   days("365"),
                   {"--within", "TIME", "only if it expires within this time: 30d, 12h, 4w"},
                   {"--rekey", "", "with a new key; otherwise the key stays"},
                   {"--permissions", "", "permissions that end before it are extended too"},
                   {"--ended-permissions", "", "with --permissions: also those that have ended"},
                   kSubjectOfFolder,
                   {"--clamp", "", "end with the CA if it ends before"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity renew talker --ca ca --permissions",
                    "ddssec identity renew talker --ca ca --within 30d"},
       .run = identity_renew,
       .sought_in = {"keystore"}}};
}

}  // namespace ddssec::cli
