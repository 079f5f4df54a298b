// identity renew, identity revoke: what happens to a certificate later.
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/near.hpp"
#include "cli/options.hpp"
#include "cli/participant.hpp"
#include "cli/participant_places.hpp"
#include "cli/transaction.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Only what this CA (or itself before it was renewed) issued, whatever its dates.
Status check_issuer(const pki::Certificate& certificate, const OpenCa& ca, const fs::path& path) {
  if (!certificate.is_issued_by(ca.certificate()))
    return fail(Code::issuer_unknown,
                {.document = path,
                 .expected = "a certificate that " + ca.certificate().subject() + " issued",
                 .found = "one of " + certificate.issuer(),
                 .hint = "name the folder of the CA that issued it: --ca DIR"});
  return {};
}

/// The permissions of a participant, if its folder has them and they verify.
struct OldPermissions {
  governance::Permissions document;
  const governance::Grant* grant;
};

Result<std::optional<OldPermissions>> permissions_in(const pki::ParticipantFolder& files,
                                                     const pki::Certificate& certificate,
                                                     WallTime now) {
  if (!is_there(files.permissions) || !is_there(files.permissions_ca)) return std::nullopt;
  const auto proof = DDSSEC_TRY(verified(files.permissions, files.permissions_ca, now));
  OldPermissions out{
      DDSSEC_TRY(named(governance::read_permissions(proof.content()), files.permissions)), nullptr};
  const auto subject = pki::SubjectName::of(certificate);
  const auto& grants = out.document.grants;
  const auto found = std::ranges::find_if(
      grants, [&](const auto& grant) { return governance::is_for(grant, subject); });
  if (found == grants.end())
    return fail(Code::no_grant_for_subject,
                {.document = files.permissions, .found = certificate.subject()});
  out.grant = &*found;
  return out;
}

// The same rights for longer, signed anew.
Status put_extended(Replacement& out, const pki::ParticipantFolder& files,
                    const OldPermissions& old, WallTime until, const Context& context,
                    const OpenCa& ca) {
  auto document = old.document;
  document.grants[static_cast<std::size_t>(old.grant - old.document.grants.data())]
      .validity.not_after = until;
  const auto xml = to_xml(document);
  const auto octets =
      DDSSEC_TRY(ca.authority.sign_document(as_bytes(xml), context.clock.now(), context.random));
  const auto plain = fs::path(files.permissions).replace_extension("xml");
  if (is_there(plain)) DDSSEC_TRY(out.put_public(plain, xml));
  return out.put(files.permissions, octets, 0644);
}

Status put_key(Replacement& out, const fs::path& path, const pki::PrivateKey& key) {
  const auto pem = DDSSEC_TRY(key.to_pem());
  return pem.expose([&](BytesView octets) { return out.put(path, octets, 0600); });
}

Result<bool> is_needed(const Arguments& arguments, const pki::Certificate& certificate,
                       WallTime now) {
  if (!arguments.has("--within")) return true;
  return certificate.not_after() < now + DDSSEC_TRY(duration(arguments, "--within"));
}

Report not_needed(const fs::path& path, const pki::Certificate& certificate) {
  return {.text = fmt::format("{}  not needed: expires {}\n", path.string(),
                              date(certificate.not_after())),
          .result = {{"renewed", false},
                     {"file", path.string()},
                     {"subject", certificate.subject()},
                     {"serial", certificate.serial()},
                     {"not_after", to_string(certificate.not_after())}}};
}

Result<Report> identity_renew(const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("PATH");
  const auto path = certificate_path(given);
  const auto files = pki::participant_folder(path.parent_path());
  const auto now = context.clock.now();
  DDSSEC_TRY(finish_interrupted(path.parent_path()));
  const auto old = DDSSEC_TRY(certificate_of(given));
  if (!DDSSEC_TRY(is_needed(arguments, old, now))) return not_needed(path, old);
  const auto wanted = DDSSEC_TRY(validity(arguments, now));
  CaOpener opener(arguments);
  const auto ca = DDSSEC_TRY(opener.open("identity"));
  DDSSEC_TRY(check_issuer(old, ca, path));
  const auto lock = DDSSEC_TRY(lock_records(ca.paths));
  if (DDSSEC_TRY(read_issue_log(ca.paths)).is_revoked(old.serial()))
    return fail(Code::certificate_revoked, {.document = path, .found = old.subject()});
  const auto life = DDSSEC_TRY(within_ca(wanted, ca.certificate(), arguments.has("--clamp")));
  std::optional<pki::PrivateKey> key;
  if (arguments.has("--rekey") && files.key.extension() == ".p11")
    return fail(Code::key_in_token, {.document = files.key});
  if (arguments.has("--rekey"))
    key = DDSSEC_TRY(pki::PrivateKey::generate(old.key_algorithm().kind, old.key_algorithm().bits));
  const auto renewed =
      DDSSEC_TRY(ca.authority.reissue(old, life, context.random, key ? &*key : nullptr));
  const auto permissions = DDSSEC_TRY(permissions_in(files, old, now));
  const bool ends_before =
      permissions && permissions->grant->validity.not_after < renewed.not_after();
  const bool extend = ends_before && arguments.has("--permissions");

  Replacement out;
  if (key) DDSSEC_TRY(put_key(out, files.key, *key));
  DDSSEC_TRY(out.put_public(path, renewed.pem()));
  if (extend) {
    const auto signer = DDSSEC_TRY(opener.open("permissions"));
    DDSSEC_TRY(put_extended(out, files, *permissions, renewed.not_after(), context, signer));
  }
  std::error_code ignored;
  const auto folder = fs::absolute(path, ignored).lexically_normal().parent_path();
  DDSSEC_TRY(check_not_interrupted());
  DDSSEC_TRY(append_lines(ca.paths.log, pki::IssueLog::issued_line(renewed, folder.string(), now)));
  Report report;
  report.text = fmt::format("{}  {}  {}expires {}\n", path.string(), renewed.subject(),
                            key ? "with a new key, " : "", date(renewed.not_after()));
  report.result = {{"renewed", true},
                   {"file", path.string()},
                   {"subject", renewed.subject()},
                   {"serial", renewed.serial()},
                   {"not_after", to_string(renewed.not_after())},
                   {"rekeyed", key.has_value()},
                   {"permissions_until", Json()}};
  if (permissions) {
    const auto until = extend ? renewed.not_after() : permissions->grant->validity.not_after;
    report.result["permissions_until"] = to_string(until);
    if (ends_before)
      report.text += fmt::format("permissions {} {}\n",
                                 extend         ? "extended to"
                                 : until <= now ? "expired and the participant cannot start, since"
                                                : "end before it, on",
                                 date(until));
    if (ends_before && !extend) report.text += "  --permissions extends them as well\n";
  }
  report.text += old.not_after() <= now
                     ? "the identity had ended, and with it all connections: start the participant "
                       "again\n"
                     : "a running participant has the old one until it starts again\n";
  report.files_written = DDSSEC_TRY(out.commit());
  return report;
}

/// What is to be revoked.
struct Doomed {
  std::string subject;
  std::vector<std::string> serials;  ///< that are not revoked yet
};

bool is_serial(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789ABCDEFabcdef") == text.npos;
}

// A participant's earlier certificates are for the same key as a rule: all that have not ended go.
Result<Doomed> doomed_participant(const fs::path& given, const OpenCa& ca, const pki::IssueLog& log,
                                  WallTime now) {
  const auto certificate = DDSSEC_TRY(certificate_of(given));
  DDSSEC_TRY(check_issuer(certificate, ca, certificate_path(given)));
  Doomed out{certificate.subject(), {}};
  if (!log.is_revoked(certificate.serial())) out.serials.push_back(certificate.serial());
  for (const auto& issued : log.issued())
    if (issued.subject == certificate.subject() && !issued.revoked && now < issued.not_after &&
        issued.serial != certificate.serial())
      out.serials.push_back(issued.serial);
  return out;
}

// The log may know the name; revoking by a name alone could end the wrong participant.
std::unexpected<Error> not_there(const std::string& what, const OpenCa& ca,
                                 const pki::IssueLog& log) {
  ErrorDetails details{.document = what,
                       .expected = "a participant's folder, its certificate or a serial number",
                       .hint = participants_near(what)};
  for (const auto& issued : log.issued()) {
    const bool is_meant = issued.subject == what || issued.subject == "CN=" + what ||
                          folder_name(issued.folder) == what;
    if (!is_meant || issued.revoked) continue;
    details.hint =
        fmt::format("the CA's log has it: ddssec identity revoke {} --ca {}",
                    is_there(fs::path(issued.folder) / "cert.pem") ? issued.folder : issued.serial,
                    ca.paths.log.parent_path().string());
  }
  return fail(Code::file_not_found, std::move(details));
}

Result<Doomed> doomed(const std::string& what, const OpenCa& ca, const pki::IssueLog& log,
                      WallTime now) {
  if (is_there(what) || !is_serial(what))
    return is_there(what) ? doomed_participant(what, ca, log, now) : not_there(what, ca, log);
  const auto serial = ascii_upper(what);
  const auto* issued = log.find(serial);
  if (issued == nullptr)
    return fail(Code::serial_unknown, {.document = ca.paths.log, .found = serial});
  Doomed out{issued->subject, {}};
  if (!log.is_revoked(serial)) out.serials.push_back(serial);
  return out;
}

Result<pki::RevocationReason> reason_of(const Arguments& arguments) {
  const auto word = arguments.text("--reason");
  const auto reason = pki::revocation_reason_from(word);
  if (!reason)
    return fail(Code::usage,
                {.field = "--reason",
                 .expected = "unspecified, keyCompromise, affiliationChanged, superseded, "
                             "cessationOfOperation or privilegeWithdrawn",
                 .found = word});
  return *reason;
}

// Which participants notice the new list, and when.
std::string next_steps(const std::string& ca, const ParticipantPlaces& places,
                       const std::vector<std::string>& without_list, const CaPaths& paths) {
  auto out = fmt::format(
      "next: ddssec crl distribute --ca {}   (puts the list into {})\n"
      "when the list is in the folder, a participant reads it\n"
      "  with ddssec's plugins (in Cyclone DDS, or embedded): within 5 s, also the first "
      "crl.pem that appears beside its certificate\n"
      "  with the stock plugins of Cyclone DDS or Fast DDS: only when it starts again, and "
      "only if its configuration names the list (ROS 2 names crl.pem of the enclave)\n",
      ca, counted(places.here.size(), "folder"));
  if (!without_list.empty()) out += "  no list so far, so that nothing is revoked there:\n";
  for (std::size_t i = 0; i < without_list.size() && i < 10; ++i)
    out += fmt::format("    {}\n", without_list[i]);
  if (without_list.size() > 10) out += fmt::format("    and {} more\n", without_list.size() - 10);
  return out + places_text(places, paths);
}

// A folder that may not be entered counts as one with a list: crl distribute says what is wrong.
std::vector<std::string> without_list(const ParticipantPlaces& places) {
  std::vector<std::string> out;
  for (const auto& folder : places.here) {
    std::error_code error;
    if (!fs::exists(pki::participant_folder(folder).crl, error) && !error) out.push_back(folder);
  }
  return out;
}

Result<std::string> report_places(const CaPaths& ca, const pki::IssueLog& log,
                                  const std::string& given, Report& report) {
  const auto places = DDSSEC_TRY(participant_places(ca, log));
  const auto bare = without_list(places);
  auto& out = report.result;
  out["folders"] = Json::array();
  for (const auto& folder : places.here) out["folders"].push_back(folder.string());
  out["without_list"] = bare;
  out["elsewhere"] = places.elsewhere;
  for (const auto& folder : places.other_copies) out["elsewhere"].push_back(folder);
  for (const auto& folder : out["elsewhere"]) out["folders"].push_back(folder);
  return next_steps(given, places, bare, ca);
}

Result<Report> identity_revoke(const Arguments& arguments, const Context& context) {
  const auto now = context.clock.now();
  const auto reason = DDSSEC_TRY(reason_of(arguments));
  const int days = DDSSEC_TRY(arguments.number("--next-update", 1, kMostDays));
  CaOpener opener(arguments);
  const auto ca = DDSSEC_TRY(opener.open("identity"));
  const auto lock = DDSSEC_TRY(lock_records(ca.paths));
  auto log = DDSSEC_TRY(read_issue_log(ca.paths));
  const auto what = DDSSEC_TRY(doomed(arguments.text("WHAT"), ca, log, now));
  Report report;
  report.result = {{"subject", what.subject}, {"serials", what.serials}};
  if (what.serials.empty() && DDSSEC_TRY(lists_all(ca.paths, log))) {
    report.text = fmt::format("{}  revoked already\n", what.subject);
    return report;
  }
  std::string lines;
  for (const auto& serial : what.serials) {
    const pki::Revocation revocation{serial, now, reason};
    DDSSEC_TRY(log.add(revocation));
    lines += pki::IssueLog::revoked_line(revocation);
  }
  const auto crl = DDSSEC_TRY(next_crl(ca, log, now, days));
  Replacement out;
  DDSSEC_TRY(out.put_public(ca.paths.crl, crl.pem()));
  DDSSEC_TRY(check_not_interrupted());
  // First the log: should the machine stop here, the next list is made from it.
  if (!lines.empty()) DDSSEC_TRY(append_lines(ca.paths.log, lines));
  report.result["crl"] = {{"file", ca.paths.crl.string()},
                          {"number", crl.number().value_or(0)},
                          {"next_update", to_string(*crl.next_update())}};
  const auto next = DDSSEC_TRY(report_places(ca.paths, log, arguments.text("--ca"), report));
  report.text =
      fmt::format("{}  revoked {}; revocation list {} holds until {}\n{}", what.subject,
                  lines.empty() ? "already, but the list did not say so"
                                : fmt::format("({})", counted(what.serials.size(), "certificate")),
                  crl.number().value_or(0), date(*crl.next_update()), next);
  report.files_written = DDSSEC_TRY(out.commit());
  return report;
}

}  // namespace

std::vector<Command> identity_change_commands() {
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
                   {"--clamp", "", "end with the CA if it ends before"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity renew talker --ca ca --permissions",
                    "ddssec identity renew talker --ca ca --within 30d"},
       .run = identity_renew},
      {.group = "identity",
       .name = "revoke",
       .summary = "Declares a certificate void and makes the revocation list that says so.",
       .positionals = {{"WHAT",
                        "a participant's folder or certificate (all that its subject has), or one "
                        "serial number"}},
       .options = {ca_option("the CA that issued it"),
                   {"--reason", "WORD", "why, in the words of RFC 5280", "unspecified"},
                   kNextUpdate,
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity revoke talker --ca ca --reason keyCompromise"},
       .run = identity_revoke}};
}

}  // namespace ddssec::cli
