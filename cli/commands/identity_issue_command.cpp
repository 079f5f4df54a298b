// identity issue: creates, completes or renews a participant's folder.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/ca/subject_overlap.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/granted_domains.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/participant_options.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/configuration_files.hpp"
#include "cli/participant/drop_in.hpp"
#include "cli/participant/fleet.hpp"
#include "cli/participant/fleet_folder.hpp"
#include "cli/participant/issuing_cas.hpp"
#include "cli/participant/participant.hpp"
#include "pki/certificate_source.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Copies only a document that the participant will accept. One that is unsigned, or signed by
// another CA, would be detected only at its first start.
Result<Bytes> governance_of(const Arguments& arguments, WallTime now) {
  if (!arguments.has("--governance")) return Bytes();
  const auto file = document_path<GovernanceKind>(arguments.text("--governance"));
  DDSSEC_RETURN_IF_ERROR(check_signing_ca(arguments.text("--ca"), "permissions"));
  const auto ca = ca_paths(arguments.text("--ca"), "permissions").certificate;
  DDSSEC_RETURN_IF_ERROR(verified(file, ca, now));
  return read_file(file, pki::kMaxDocumentOctets);
}

using Findings = std::vector<Finding>;

// The governance document that the participant has or gets.
fs::path governance_file(const Arguments& arguments) {
  return arguments.has("--governance")
             ? document_path<GovernanceKind>(arguments.text("--governance"))
             : pki::participant_folder(arguments.text("-o"), pki::FolderLayout::flat).governance;
}

// The settings for every participant of the command.
Result<ParticipantSpec> common_spec(const Arguments& arguments, WallTime now, Findings& findings) {
  ParticipantSpec out{.name = {}, .subject = {}, .life = {}};
  DDSSEC_ASSIGN_OR_RETURN(out.domains,
                          granted_domains(arguments, governance_file(arguments), findings));
  DDSSEC_ASSIGN_OR_RETURN(out.life, validity(arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(out.key, key_spec(arguments));
  DDSSEC_ASSIGN_OR_RETURN(out.publish, topics_of(arguments, "--publish"));
  DDSSEC_ASSIGN_OR_RETURN(out.subscribe, topics_of(arguments, "--subscribe"));
  out.partitions = arguments.all("--partition");
  out.takes_other_grants = arguments.has("--other-grants");
  DDSSEC_ASSIGN_OR_RETURN(out.dropin, drop_in_of(arguments));
  DDSSEC_ASSIGN_OR_RETURN(out.ocsp_responder, ocsp_responder(arguments));
  return out;
}

Result<ParticipantSpec> spec_of(const Arguments& arguments, WallTime now, Findings& findings) {
  DDSSEC_ASSIGN_OR_RETURN(auto spec, common_spec(arguments, now, findings));
  spec.name = arguments.text("NAME");
  DDSSEC_RETURN_IF_ERROR(check_name(spec.name));
  spec.subject = arguments.has("--subject") ? arguments.text("--subject") : "CN=" + spec.name;
  if (arguments.has("--partition") && !spec.has_permissions())
    return fail(Code::usage, {.field = "--partition", .note = "it needs --publish or --subscribe"});
  if (!arguments.has("--permissions")) return spec;
  if (spec.has_permissions())
    return fail(Code::usage,
                {.field = "--permissions", .note = "not together with --publish or --subscribe"});
  DDSSEC_ASSIGN_OR_RETURN(spec.permissions,
                          read_file(arguments.text("--permissions"), pki::kMaxDocumentOctets));
  return spec;
}

using IssuedParticipants = std::variant<IssuedFacts, IssuedFleet>;
using IssueAnswer = Answer<IssuedParticipants>;

// Issues many participants with one command: all or none. Existing participants of a fleet stay
// unchanged.
Result<IssueAnswer> issue_fleet(const Arguments& arguments, const Context& context,
                                Findings& findings) {
  const auto now = context.clock.calendar_seconds();
  for (const auto* option : {"--subject", "--permissions"})
    if (arguments.has(option))
      return fail(Code::usage,
                  {.field = option, .note = "not together with --from: write it in the file"});
  const fs::path from = arguments.text("--from");
  const fs::path target = arguments.text("-o");
  DDSSEC_ASSIGN_OR_RETURN(const auto common, common_spec(arguments, now, findings));
  DDSSEC_ASSIGN_OR_RETURN(auto specs, read_fleet(from, common, now));
  DDSSEC_ASSIGN_OR_RETURN(auto folder, FleetFolder::at(target, specs));
  // Checked first, so that the user types no passphrase for a document that cannot be used.
  DDSSEC_RETURN_IF_ERROR(governance_of(arguments, now));
  const bool any_rights = std::ranges::any_of(specs, &ParticipantSpec::has_permissions);
  DDSSEC_ASSIGN_OR_RETURN(const auto cas, open_issuing_cas(arguments, any_rights, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto governance, governance_of(arguments, now));
  IssuedFleet fleet{target};
  Report report;
  FleetMembers members(cas.permissions ? &*cas.permissions : nullptr, target, now);
  SubjectsOfFleet subjects(from);
  DDSSEC_ASSIGN_OR_RETURN(const auto issue_log, read_issue_log(cas.identity.paths));
  SubjectsInUse in_use(issue_log, {}, now);
  Progress progress("participants", specs.size());
  for (std::size_t i = 0; i < specs.size(); ++i) {
    auto& spec = specs[i];
    DDSSEC_ASSIGN_OR_RETURN(const auto made,
                            make_participant_within_ca(spec, cas, arguments, context, from));
    warn_of_rights(spec, from.string(), report);
    DDSSEC_RETURN_IF_ERROR(
        folder.add(i, spec.name, made, cas.issuers(spec.has_permissions()), governance));
    fleet.participants.push_back(members.add(spec.name, made));
    const auto& certificate = made.self.certificate;
    subjects.add(spec.name, certificate, report);
    DDSSEC_RETURN_IF_ERROR(with_default_document(in_use.check(certificate.subject()), from));
    in_use.add(certificate.subject(), spec.name);
    progress.step();
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto drop_in, drop_in_of(arguments));
  report.text += folder.text() + drop_in_line(drop_in);
  DDSSEC_RETURN_IF_ERROR(log_participants(cas, members.issued(), members.signed_lines()));
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, folder.commit());
  return IssueAnswer{std::move(fleet), std::move(report)};
}

// One participant, as the command line requests it.
struct IssueRequest {
  const Arguments& arguments;
  const Context& context;
  ParticipantSpec spec;
  fs::path target;
  Bytes governance;
  pki::ParticipantFolder files;  // the paths of `target`

  bool is_replacing() const { return arguments.has("--replace"); }
};

IssuedFacts issued_of(const IssueRequest& request, const pki::Certificate& certificate,
                      std::string done = {}) {
  return {request.spec.name, request.target, CertificateFacts::of(certificate), std::move(done)};
}

// The contents of one participant's folder, and the CAs that signed it.
struct IssuedFolder {
  IssuingCas cas;
  NewParticipant made;
};

Result<IssuedFolder> issue(IssueRequest& request) {
  const auto now = request.context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(auto cas,
                          open_issuing_cas(request.arguments, request.spec.has_permissions(), now));
  // Reads the document again: a rotation that this command waited for may have signed it again.
  DDSSEC_ASSIGN_OR_RETURN(request.governance, governance_of(request.arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(
      auto made, make_participant_within_ca(request.spec, cas, request.arguments, request.context,
                                            request.arguments.text("--permissions")));
  return IssuedFolder{std::move(cas), std::move(made)};
}

// Reports what the folder lacks after everything is in place. (A dry run prints another text.)
Result<IssueAnswer> issue_answer(IssuedFacts issued, Report report, const IssueRequest& request,
                                 Result<std::vector<WrittenFile>> committed) {
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, std::move(committed));
  const auto missing = missing_files_text(request.files);
  report.text += missing;
  if (missing.empty()) report.text += configuration_lines(request.spec.name, request.target);
  if (!request.spec.dropin.empty() || leaves_libraries_open(request.target))
    report.text += drop_in_line(request.spec.dropin);
  warn_of_rights(request.spec, request.arguments.text("--permissions"), report);
  return IssueAnswer{std::move(issued), std::move(report)};
}

Result<IssueAnswer> create_folder(IssueRequest& request) {
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(request.target));
  DDSSEC_ASSIGN_OR_RETURN(const auto issued, issue(request));
  const auto& [cas, made] = issued;
  DDSSEC_RETURN_IF_ERROR(
      add_flat(folder, "", made, cas.issuers(request.spec.has_permissions()), request.governance));
  DDSSEC_RETURN_IF_ERROR(
      log_participant(cas, made, request.target, request.context.clock.calendar_seconds()));
  return issue_answer(issued_of(request, made.self.certificate), {}, request, folder.commit());
}

std::unexpected<Error> would_overwrite_error(const fs::path& file, std::string note) {
  return fail(Code::would_overwrite,
              {.document = file,
               .note = std::move(note),
               .hint = "--replace makes a new key, certificate and documents in "
                       "this folder; ddssec permissions new --replace changes the permissions "
                       "alone; or choose another folder"});
}

// A key alone waits for its certificate, and a certificate alone for its key, so neither is
// completed.
Status check_pair(const IssueRequest& request) {
  const bool has_certificate = path_exists(request.files.certificate);
  const bool has_key = path_exists(request.files.key);
  if (has_certificate == has_key) return {};
  const auto& file = has_key ? request.files.key : request.files.certificate;
  return fail(
      Code::would_overwrite,
      {.document = file,
       .note = has_key ? "the key has no certificate" : "the certificate has no key here",
       .hint = has_key
                   ? "ddssec identity sign-csr issues the certificate for a key that is "
                     "there; --replace makes both new; or choose another folder"
                   : "the key is on the device as a rule, and this folder needs none; --replace "
                     "makes both new; or choose another folder"});
}

// Adds missing files to a folder.
class Completion {
 public:
  explicit Completion(const IssueRequest& request) : request_(request) {}

  // Leaves an identical file unchanged; any other existing file is an error.
  Status add(const fs::path& file, BytesView octets, unsigned mode, bool is_asked_for) {
    if (!path_exists(file)) {
      ++count_;
      return out_.put(file, octets, mode);
    }
    if (!is_asked_for) return {};
    DDSSEC_ASSIGN_OR_RETURN(const auto found, read_file(file, pki::kMaxDocumentOctets));
    if (std::ranges::equal(found, octets)) return {};
    return would_overwrite_error(file, "it is another one");
  }
  Status put(const fs::path& file, std::string_view text) {
    ++count_;
    return out_.put_public(file, text);
  }
  Result<std::vector<WrittenFile>> commit() {
    if (count_ == 0) return would_overwrite_error(request_.target, "nothing is missing in it");
    return out_.commit();
  }

 private:
  const IssueRequest& request_;
  FileTransaction out_;
  std::size_t count_ = 0;
};

// The existing certificate must have the requested subject and come from this CA.
Status check_same(const IssueRequest& request, const pki::Certificate& certificate,
                  const pki::Certificate& ca) {
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, pki::SubjectName::parse(request.spec.subject));
  if (pki::SubjectName::of(certificate).key() != wanted.key())
    return would_overwrite_error(
        request.files.certificate,
        fmt::format("it is that of {}, not of {}", certificate.subject(), request.spec.subject));
  if (!certificate.is_issued_by(ca))
    return would_overwrite_error(
        request.files.certificate,
        fmt::format("it was issued by {}, not by this CA", certificate.issuer()));
  return {};
}

Status add_permissions(const IssueRequest& request, const pki::Certificate& certificate,
                       Completion& out) {
  if (!request.spec.has_permissions()) {
    const bool is_used = path_exists(request.files.permissions) || !request.governance.empty();
    DDSSEC_ASSIGN_OR_RETURN(const auto trust, permissions_trust(request.arguments, is_used));
    if (trust.empty()) return {};
    return out.add(request.files.permissions_ca, as_bytes(trust), 0644, is_used);
  }
  if (path_exists(request.files.permissions))
    return would_overwrite_error(request.files.permissions, "the participant has permissions");
  const auto now = request.context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, CaOpener(request.arguments).open("permissions"));
  DDSSEC_ASSIGN_OR_RETURN(const auto xml,
                          with_default_document(permissions_xml(request.spec, certificate, now),
                                                request.arguments.text("--permissions")));
  DDSSEC_ASSIGN_OR_RETURN(const auto document,
                          sign_permissions(ca.authority, xml, now, request.context.random));
  DDSSEC_RETURN_IF_ERROR(out.add(request.files.permissions_ca, as_bytes(ca.trust_pem), 0644, true));
  DDSSEC_RETURN_IF_ERROR(out.add(request.files.permissions, document, 0644, true));
  return log_signed(ca, as_bytes(xml), request.files.permissions, now);
}

// Keeps key and certificate, and adds only missing files.
Result<IssueAnswer> add_missing_files(IssueRequest& request) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(request.files.certificate));
  const auto paths = ca_paths(request.arguments.text("--ca"), "identity");
  DDSSEC_ASSIGN_OR_RETURN(const auto lock, lock_records(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto cas, read_certificates(paths.certificate));
  DDSSEC_RETURN_IF_ERROR(check_same(request, certificate, cas.front()));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  DDSSEC_RETURN_IF_ERROR(
      check_not_revoked(certificate, request.files.certificate, paths, log, NextKey::same));
  Completion out(request);
  DDSSEC_RETURN_IF_ERROR(out.add(request.files.identity_ca, as_bytes(to_pem(cas)), 0644, false));
  DDSSEC_RETURN_IF_ERROR(add_permissions(request, certificate, out));
  if (!request.governance.empty())
    DDSSEC_RETURN_IF_ERROR(out.add(request.files.governance, request.governance, 0644, true));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl,
                          list_for_newcomers(paths, request.context.clock.calendar_seconds()));
  if (crl) {
    DDSSEC_ASSIGN_OR_RETURN(const auto lists, file_of_lists(paths, *crl));
    DDSSEC_RETURN_IF_ERROR(out.add(request.files.crl, as_bytes(lists), 0644, false));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto missing_files,
                          missing_configuration_files(request.files, request.spec.dropin));
  for (const auto& [name, text] : missing_files)
    DDSSEC_RETURN_IF_ERROR(out.put(request.target / name, text));
  return issue_answer(
      issued_of(request, certificate, "completed, key and certificate are as before, "), {},
      request, out.commit());
}

// A *.p11 file names an object of a token, so PEM text in it would be useless.
Status check_nothing_in_token(const IssueRequest& request) {
  for (const auto* file :
       {&request.files.certificate, &request.files.identity_ca, &request.files.permissions_ca})
    if (file->extension() == ".p11")
      return would_overwrite_error(*file, "it names what a token holds");
  if (request.files.key.extension() != ".p11") return {};
  return fail(Code::key_in_token,
              {.document = request.files.key,
               .hint = "remove key.p11 if the participant is to have a key in a file; for one in a "
                       "token: ddssec identity csr --key pkcs11:..., then identity sign-csr"});
}

// Replaces existing files by what the command creates; other files stay.
Result<IssueAnswer> write_folder(IssueRequest& request) {
  DDSSEC_RETURN_IF_ERROR(check_nothing_in_token(request));
  DDSSEC_ASSIGN_OR_RETURN(const auto issued, issue(request));
  const auto& [cas, made] = issued;
  const auto& files = request.files;
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(out.put_public(files.identity_ca, cas.identity.trust_pem));
  // Documents that stay may be of another permissions CA, and then its certificate stays, too.
  const bool is_ca_used = cas.permissions || !request.governance.empty();
  if (!cas.permissions_trust.empty() && (is_ca_used || !path_exists(files.permissions_ca)))
    DDSSEC_RETURN_IF_ERROR(out.put_public(files.permissions_ca, cas.permissions_trust));
  if (!made.permissions.empty())
    DDSSEC_RETURN_IF_ERROR(out.put(files.permissions, made.permissions, 0644));
  const auto plain = fs::path(files.permissions).replace_extension("xml");
  if (!made.permissions.empty() && path_exists(plain))
    DDSSEC_RETURN_IF_ERROR(out.put_public(plain, made.permissions_xml));
  if (!request.governance.empty())
    DDSSEC_RETURN_IF_ERROR(out.put(files.governance, request.governance, 0644));
  if (cas.list) {
    DDSSEC_ASSIGN_OR_RETURN(auto trusted, read_certificates(cas.identity.paths.certificate));
    DDSSEC_RETURN_IF_ERROR(put_list(
        out, files.crl,
        {*cas.list, cas.identity.certificate(), request.arguments.text("--ca"),
         &made.self.certificate, std::move(trusted), request.context.clock.calendar_seconds()}));
  }
  // Existing configuration files keep changes of the user, such as the network interface.
  DDSSEC_ASSIGN_OR_RETURN(const auto missing_files,
                          missing_configuration_files(files, request.spec.dropin));
  for (const auto& [name, text] : missing_files)
    DDSSEC_RETURN_IF_ERROR(out.put_public(request.target / name, text));
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, made.self.key.to_pem());
  DDSSEC_RETURN_IF_ERROR(
      pem.expose([&](BytesView octets) { return out.put(files.key, octets, 0600); }));
  DDSSEC_RETURN_IF_ERROR(out.put_public(files.certificate, made.self.certificate.pem()));
  DDSSEC_RETURN_IF_ERROR(
      log_participant(cas, made, request.target, request.context.clock.calendar_seconds()));
  Report report;
  report.text = former_certificate_text(request.files.certificate, request.arguments.text("--ca"),
                                        request.context.clock.calendar_seconds());
  DDSSEC_ASSIGN_OR_RETURN(auto answer, issue_answer(issued_of(request, made.self.certificate),
                                                    std::move(report), request, out.commit()));
  refresh_renewals(request.arguments.text("--ca"), files, request.context.clock.calendar_seconds(),
                   answer.report);
  return answer;
}

// Fills a folder without a participant. No file of one may be in it.
Result<IssueAnswer> fill_existing_folder(IssueRequest& request) {
  for (const auto* file :
       {&request.files.identity_ca, &request.files.permissions_ca, &request.files.governance,
        &request.files.permissions, &request.files.crl})
    if (path_exists(*file))
      return would_overwrite_error(*file, "it is there without a key and a certificate");
  return write_folder(request);
}

Result<IssueAnswer> issue_one(const Arguments& arguments, const Context& context,
                              Findings& findings) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(auto spec, spec_of(arguments, now, findings));
  const fs::path given = arguments.text("-o");
  const fs::path target = given.has_filename() ? given : given.parent_path();
  DDSSEC_RETURN_IF_ERROR(check_nameable(target));
  std::error_code ignored;
  // A symbolic link does not count as a folder, so that nothing is written elsewhere.
  const bool is_folder = fs::symlink_status(target, ignored).type() == fs::file_type::directory;
  DDSSEC_ASSIGN_OR_RETURN(auto governance, governance_of(arguments, now));
  IssueRequest request{arguments,
                       context,
                       std::move(spec),
                       target,
                       std::move(governance),
                       pki::participant_folder(target, pki::FolderLayout::flat)};
  if (!is_folder) return create_folder(request);
  DDSSEC_RETURN_IF_ERROR(hold_folder(target));
  DDSSEC_RETURN_IF_ERROR(check_not_above_participants(target, request.spec.name));
  DDSSEC_RETURN_IF_ERROR(finish_interrupted(target));
  if (request.is_replacing()) return write_folder(request);
  DDSSEC_RETURN_IF_ERROR(check_pair(request));
  return path_exists(request.files.certificate) ? add_missing_files(request)
                                                : fill_existing_folder(request);
}

Result<IssueAnswer> identity_issue(const Arguments& arguments, const Context& context) {
  if (arguments.has("--from") == arguments.has("NAME"))
    return fail(Code::usage, {.field = "NAME", .note = "give either a name or --from"});
  if (arguments.has("--from") && arguments.has("--replace"))
    return fail(Code::usage, {.field = "--replace",
                              .note = "it is for one participant, not with "
                                      "--from"});
  Findings findings;
  DDSSEC_ASSIGN_OR_RETURN(auto answer, arguments.has("--from")
                                           ? issue_fleet(arguments, context, findings)
                                           : issue_one(arguments, context, findings));
  auto& all = answer.report.findings;
  all.insert(all.end(), findings.begin(), findings.end());
  return answer;
}

const Option kParticipantFolder{.name = "-o",
                                .value = "DIR",
                                .summary = "the folder: a new one, or one that lacks something",
                                .required = true};

}  // namespace

std::vector<Command> identity_issue_commands() {
  return {
      {.group = "identity",
       .name = "issue",
       .summary = "Makes or completes a participant's folder: key, certificates, permissions.",
       .positionals = {{.name = "NAME",
                        .summary = "the participant's name",
                        .optional = true,
                        .unless = "--from"}},
       .options = {ca_option("the folder that ca create made"),
                   kParticipantFolder,
                   kSubject,
                   days("365"),
                   kClampToCa,
                   kKey,
                   {"--from", "FILE",
                    "a fleet in TOML: [[participant]] with name, publish, "
                    "subscribe, partitions, domain, subject, days, key, permissions"},
                   repeated("--domain", "N|A-B",
                            "a domain or a range of them; without it, the governance document's, "
                            "or 0"),
                   repeated("--publish", "TOPIC", "a topic or expression it may publish"),
                   repeated("--subscribe", "TOPIC", "a topic or expression it may subscribe to"),
                   repeated("--partition", "GLOB",
                            "partitions in which it may use these topics; without any, only "
                            "without a partition"),
                   {"--permissions", "FILE", "a permissions document to sign instead"},
                   kOtherGrants,
                   {"--governance", "FILE", "a signed governance document to copy"},
                   kDropIn,
                   kOcspResponder,
                   {"--replace", "",
                    "in a folder that is there: replace key, certificate and the documents that "
                    "are asked for; without it, only what is missing is added"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity issue talker --ca ca -o talker --publish rt/chatter "
                    "--governance governance.p7s",
                    "ddssec identity issue --from participants.toml --ca ca -o fleet "
                    "--governance governance.p7s"},
       .run = identity_issue}};
}

}  // namespace ddssec::cli
