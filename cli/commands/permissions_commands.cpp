// permissions new: the rights of one participant, for the subject of its certificate.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cli/ca/ca_folder.hpp"
#include "cli/ca/new_document.hpp"
#include "cli/ca/signing_warnings.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/granted_domains.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/new_file.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/lint.hpp"
#include "governance/read.hpp"
#include "governance/rights.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The governance document of the participant. It lies beside the new document or beside the
// certificate.
fs::path governance_beside(const Arguments& arguments) {
  const fs::path cert = arguments.text("--cert");
  std::error_code ignored;
  const auto folders = {folder_of(arguments.text("-o")),
                        fs::is_directory(cert, ignored) ? cert : folder_of(cert)};
  for (const auto& folder : folders)
    if (const auto file = pki::participant_folder(folder).governance; path_exists(file))
      return file;
  return {};
}

// Without --domain, uses the one domain of that governance document, because a participant with
// permissions for another domain cannot start.
Result<std::vector<governance::DomainRange>> domains_for(const Arguments& arguments,
                                                         std::vector<Finding>& findings) {
  const auto governance = governance_beside(arguments);
  if (governance.empty())
    return arguments.has("--domain") ? domain_ranges(arguments, "--domain")
                                     : std::vector<governance::DomainRange>{{0, 0}};
  DDSSEC_ASSIGN_OR_RETURN(auto out, granted_domains(arguments, governance, findings));
  const bool is_one = out.size() == 1 && out.front().first == out.front().last;
  if (arguments.has("--domain") || is_one) return out;
  return fail(Code::usage, {.field = "--domain",
                            .expected = "one of the domains of " + governance.string() + ": " +
                                        governance::doctor::to_text(out),
                            .found = "none"});
}

Result<governance::Rights> rights_from(const Arguments& arguments, Report& report) {
  if (arguments.has("--partition") && !arguments.has("--publish") && !arguments.has("--subscribe"))
    return fail(Code::usage, {.field = "--partition", .note = "it needs --publish or --subscribe"});
  governance::Rights out;
  DDSSEC_ASSIGN_OR_RETURN(out.domains, domains_for(arguments, report.findings));
  DDSSEC_ASSIGN_OR_RETURN(out.publish, topics_of(arguments, "--publish"));
  DDSSEC_ASSIGN_OR_RETURN(out.subscribe, topics_of(arguments, "--subscribe"));
  DDSSEC_ASSIGN_OR_RETURN(out.deny_publish, topics_of(arguments, "--deny-publish"));
  DDSSEC_ASSIGN_OR_RETURN(out.deny_subscribe, topics_of(arguments, "--deny-subscribe"));
  out.partitions = arguments.all("--partition");
  return out;
}

// As long as the certificate, unless --days or --not-after is given.
Result<governance::Validity> life(const Arguments& arguments, const pki::Certificate& certificate,
                                  WallTime now) {
  if (arguments.has("--days") && arguments.has("--not-after"))
    return fail(Code::usage, {.field = "--days", .note = "not together with --not-after"});
  governance::Validity out{certificate.not_before(), certificate.not_after()};
  if (arguments.has("--days")) {
    DDSSEC_ASSIGN_OR_RETURN(const auto days, validity(arguments, now));
    return governance::Validity{days.not_before, days.not_after};
  }
  if (!arguments.has("--not-after")) return out;
  const auto text = arguments.text("--not-after");
  const auto end = time_from(text);
  if (!end || *end <= out.not_before)
    return fail(Code::usage,
                {.field = "--not-after",
                 .expected = "a time such as 2027-11-21T00:00:00Z, or a date, not before " +
                             to_string(out.not_before),
                 .found = '"' + text + '"'});
  out.not_after = *end;
  return out;
}

// The common name, if the subject is nothing else. The name of a grant only appears in messages.
std::string grant_name(const pki::Certificate& certificate) {
  constexpr std::string_view kCommonName = "CN=";
  std::string_view name = certificate.subject();
  const bool is_plain = name.starts_with(kCommonName) && name.find_first_of(",+\\") == name.npos;
  return std::string(is_plain ? name.substr(kCommonName.size()) : name);
}

// If --ca is a folder with both CAs, its identity CA must have issued the certificate.
Status check_issued_here(const pki::Certificate& certificate, const Arguments& arguments) {
  if (!arguments.has("--sign") || !arguments.has("--ca")) return {};
  const auto ca = arguments.text("--ca");
  const auto paths = ca_paths(ca, "identity");
  if (!path_exists(paths.certificate) ||
      paths.certificate == ca_paths(ca, "permissions").certificate)
    return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto cas, read_certificates(paths.certificate));
  if (std::ranges::any_of(cas, [&](const auto& one) { return certificate.is_issued_by(one); }))
    return {};
  return fail(Code::issuer_unknown,
              {.document = arguments.text("--cert"),
               .expected = "a certificate that " + paths.certificate.string() + " issued",
               .found = fmt::format("\"{}\", issued by \"{}\"", certificate.subject(),
                                    certificate.issuer()),
               .hint = "for a participant of another identity CA, name the permissions CA alone: "
                       "--ca " +
                       ca_paths(ca, "permissions").certificate.parent_path().string()});
}

struct NewPermissions {
  fs::path file;
  std::string subject;
  WallTime not_before, not_after;
  bool has_rights = true;               // true if some topic may be used
  std::vector<WrittenFile> files = {};  // all files that were written

  static constexpr auto fields() {
    using Self = NewPermissions;
    return std::tuple(field<&Self::file>(), field<&Self::subject>({.def = "subject"}),
                      field<&Self::not_before>(), field<&Self::not_after>());
  }
  std::string text() const {
    std::string out;
    if (!has_rights)
      out =
          "it lets the participant join and use no topic: --publish and --subscribe allow "
          "topics\n";
    for (const auto& one : files)
      out += fmt::format("{}  for {} until {}\n", one.path, subject, date(not_after));
    return out;
  }
};

Result<Answer<NewPermissions>> permissions_new(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_of(arguments.text("--cert")));
  DDSSEC_RETURN_IF_ERROR(check_issued_here(certificate, arguments));
  Answer<NewPermissions> out{};
  auto& report = out.report;
  DDSSEC_ASSIGN_OR_RETURN(const auto rights, rights_from(arguments, report));
  DDSSEC_ASSIGN_OR_RETURN(const auto validity,
                          life(arguments, certificate, context.clock.calendar_seconds()));
  const auto grant = grant_of(grant_name(certificate), certificate, rights, validity);
  const auto xml = to_xml(governance::Permissions{.grants = {grant}});
  // The document is parsed, because the arguments may contain something that no document can.
  DDSSEC_ASSIGN_OR_RETURN(const auto document, governance::read_permissions(as_bytes(xml)));
  add_findings(
      report,
      lint(document, {.now = context.clock.calendar_seconds(), .certificate = &certificate}),
      arguments.text("-o"));
  if (report.exit != Exit::done) {
    report.text = "not written: it would be of no use\n";
    out.has_result = false;
    return out;
  }
  const bool has_rights = std::ranges::any_of(document.grants[0].rules, [](const auto& rule) {
    return !rule.publish.empty() || !rule.subscribe.empty();
  });
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, write_document(xml, arguments, context));
  if (arguments.has("--sign"))
    warn_of_extension(document, signed_path(arguments.text("-o")), arguments.text("--ca"),
                      context.clock.calendar_seconds());
  out.result = {report.files_written.front().path, grant.subject_name, grant.validity.not_before,
                grant.validity.not_after,          has_rights,         report.files_written};
  return out;
}

}  // namespace

std::vector<Command> permissions_commands() {
  return {
      {.group = "permissions",
       .name = "new",
       .summary = "Writes the permissions of one certificate's subject; the rest is denied.",
       .positionals = {},
       .options = with_signing_options(
           {{.name = "--cert",
             .value = "FILE",
             .summary = "the participant's certificate",
             .required = true},
            {.name = "-o", .value = "FILE", .summary = "the new document", .required = true},
            repeated("--domain", "N|A-B",
                     "a domain or a range of them; without it, that of governance.p7s in "
                     "the folder of -o or of --cert; without one, 0"),
            repeated("--publish", "GLOB", "topics it may write"),
            repeated("--subscribe", "GLOB", "topics it may read"),
            repeated("--deny-publish", "GLOB", "topics it may not write, whatever else says"),
            repeated("--deny-subscribe", "GLOB", "topics it may not read, whatever else says"),
            repeated("--partition", "GLOB",
                     "partitions of what it may write and read; without it, only endpoints "
                     "without a partition"),
            {"--days", "N", "how long it is valid, if not as long as the certificate"},
            {"--not-after", "TIME", "or until when (2027-11-21T00:00:00Z)"}}),
       .examples = {"ddssec permissions new --cert talker/cert.pem --publish rt/chatter -o "
                    "permissions.xml",
                    "ddssec permissions new --cert talker/cert.pem --domain 0-5 --subscribe 'rt/*' "
                    "--sign --ca ca -o talker/permissions.xml"},
       .run = permissions_new}};
}

}  // namespace ddssec::cli
