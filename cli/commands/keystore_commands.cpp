// keystore: creates and maintains the keystore of ROS 2, with two separate CAs and keys that only
// their owner can read.
#include <algorithm>
#include <fcntl.h>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "base/guarded_path.hpp"
#include "base/shell_word.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/governance_revision.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/ca/subject_overlap.hpp"
#include "cli/commands/groups.hpp"
#include "cli/commands/keystore_results.hpp"
#include "cli/commands/keystore_upkeep.hpp"
#include "cli/doctor/doctor_options.hpp"
#include "cli/doctor/products.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/granted_domains.hpp"
#include "cli/documents/ros_policy.hpp"
#include "cli/documents/signed_permissions.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/frame/rename_recovery.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/passphrase.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/configuration_files.hpp"
#include "cli/participant/keystore.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/lint.hpp"
#include "governance/profile.hpp"
#include "governance/read.hpp"
#include "governance/write.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

Result<pki::Authority> make_ca(const fs::path& keystore, std::string_view role,
                               const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto life, validity(arguments, context.clock.calendar_seconds()));
  return pki::Authority::create_root(ca_subject(folder_name(keystore), role), {}, life,
                                     context.random);
}

Result<Answer<CreatedKeystore>> keystore_create(const Arguments& arguments,
                                                const Context& context) {
  const fs::path target = arguments.text("KEYSTORE");
  DDSSEC_ASSIGN_OR_RETURN(const auto profile, profile_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto domains, domain_ranges(arguments, "--domain"));
  DDSSEC_RETURN_IF_ERROR(check_nameable(target));
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(target));
  std::optional<pki::Passphrase> secret;
  if (!arguments.has("--no-passphrase")) {
    DDSSEC_ASSIGN_OR_RETURN(secret, new_passphrase(arguments));
  }
  const bool single = arguments.has("--single-ca");
  DDSSEC_ASSIGN_OR_RETURN(const auto identity,
                          make_ca(target, single ? "" : "Identity", arguments, context));
  auto permissions = identity;
  if (!single) {
    DDSSEC_ASSIGN_OR_RETURN(permissions, make_ca(target, "Permissions", arguments, context));
  }
  DDSSEC_RETURN_IF_ERROR(add_keystore_cas(folder, identity, single ? nullptr : &permissions,
                                          secret ? &*secret : nullptr));
  const auto xml = to_xml(governance::governance_of(profile, domains));
  const auto text = with_first_revision(xml);
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      permissions.sign_document(text.octets, context.clock.calendar_seconds(), context.random));
  DDSSEC_RETURN_IF_ERROR(add_keystore_governance(folder, xml, document));
  const auto logged =
      signed_line(permissions.certificate(), text, target / "enclaves/governance.p7s",
                  context.clock.calendar_seconds());
  DDSSEC_RETURN_IF_ERROR(folder.add("private/permissions_ca.signed.jsonl", as_bytes(logged), 0600));
  DDSSEC_ASSIGN_OR_RETURN(const auto list, first_crl(identity));
  DDSSEC_RETURN_IF_ERROR(folder.add_public("public/identity_ca.crl.pem", list.pem()));
  Answer<CreatedKeystore> out{{target,
                               secret.has_value(),
                               {NewCaFacts::of("identity", identity.certificate()),
                                NewCaFacts::of("permissions", permissions.certificate())}}};
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, folder.commit());
  return out;
}

// Says whether an enclave may keep its present permissions.
enum class Rights : std::uint8_t { needed, may_stay };

// Rights must be given explicitly and in one way, so that an enclave with all rights must be
// requested.
Status check_one_source(const Arguments& arguments, Rights rights) {
  const bool given[] = {arguments.has("--publish") || arguments.has("--subscribe"),
                        arguments.has("--permissions"), arguments.has("--policy"),
                        arguments.has("--allow-all")};
  const auto count = std::ranges::count(given, true);
  if (count == 1 || (count == 0 && rights == Rights::may_stay)) return {};
  return fail(Code::usage, {.field = "--publish",
                            .note = "give --publish and --subscribe, or one of --permissions, "
                                    "--policy and --allow-all"});
}

// The rights of the enclave in the policy, as one grant.
Result<governance::Grant> grant_of_policy(const fs::path& file, const ParticipantSpec& spec,
                                          const Arguments& arguments, Report& report) {
  DDSSEC_ASSIGN_OR_RETURN(auto file_policy, read_policy(file, {spec.name}));
  const auto policy = with_options(std::move(file_policy), arguments);
  add_findings(report, merged_profiles(policy), file);
  add_findings(report, prefixed_names(policy), file);
  auto grant = permissions_of(policy, {}).grants.front();
  for (auto& rule : grant.rules) rule.domains.ranges = spec.domains;
  return grant;
}

// A topic of ROS 2 has a prefix in DDS, which the names in a policy lack.
void warn_of_missing_prefixes(const ParticipantSpec& spec, Report& report) {
  const auto is_of_ros = [](std::string_view topic) {
    for (const std::string_view prefix :
         {"rt/", "rq/", "rr/", "rs/", "ra/", "ros_discovery_info", "DCPS", "*", "?", "[", "/"})
      if (topic.starts_with(prefix)) return true;
    return false;
  };
  for (const auto* topics : {&spec.publish, &spec.subscribe})
    for (const auto& topic : *topics)
      if (!is_of_ros(topic))
        report.findings.push_back(
            {.rule = Rule::PERM034,
             .message = fmt::format("\"{}\" is a DDS topic that no ROS 2 node uses", topic),
             .hint = fmt::format("ROS 2 topic /{0} is rt/{0} in DDS; --policy takes the names of "
                                 "ROS 2",
                                 topic),
             .severity = Severity::warning});
}

Status read_rights(ParticipantSpec& spec, const Arguments& arguments, Rights rights,
                   Report& report) {
  DDSSEC_RETURN_IF_ERROR(check_one_source(arguments, rights));
  DDSSEC_ASSIGN_OR_RETURN(
      spec.domains,
      granted_domains(arguments, fs::path(arguments.text("KEYSTORE")) / "enclaves/governance.p7s",
                      report.findings));
  DDSSEC_ASSIGN_OR_RETURN(spec.publish, topics_of(arguments, "--publish"));
  DDSSEC_ASSIGN_OR_RETURN(spec.subscribe, topics_of(arguments, "--subscribe"));
  warn_of_missing_prefixes(spec, report);
  warn_of_rights(spec, {}, report);
  if (arguments.has("--allow-all")) spec.publish = spec.subscribe = {"*"};
  spec.takes_other_grants = arguments.has("--other-grants");
  if (arguments.has("--permissions")) {
    DDSSEC_ASSIGN_OR_RETURN(spec.permissions,
                            read_file(arguments.text("--permissions"), pki::kMaxDocumentOctets));
  }
  if (arguments.has("--policy")) {
    DDSSEC_ASSIGN_OR_RETURN(spec.grant,
                            grant_of_policy(arguments.text("--policy"), spec, arguments, report));
  } else if (arguments.has("--node-defaults"))
    return fail(Code::usage, {.field = "--node-defaults",
                              .note = "it takes the names of the nodes from --policy"});
  return {};
}

// Shows what `permissions lint` warns of in a document that is put into force. It was just made, so
// it can be parsed. Nothing is shown twice, and nothing as an error.
Status warn_of_document(std::string_view xml, const fs::path& document,
                        const governance::PermissionsUse& use, Report& report) {
  if (xml.empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions, governance::read_permissions(as_bytes(xml)));
  for (auto& finding : lint(permissions, use)) {
    const bool is_shown = std::ranges::find(report.findings, finding.message, &Finding::message) !=
                          report.findings.end();
    if (is_shown || finding.severity < Severity::warning) continue;
    finding.severity = Severity::warning;
    finding.document = document;
    report.findings.push_back(std::move(finding));
  }
  return {};
}

// The file in which lines of the document count: the one that was given, or the text beside the
// signed form.
fs::path shown_document(const Arguments& arguments, const pki::ParticipantFolder& files) {
  return arguments.has("--permissions") ? fs::path(arguments.text("--permissions"))
                                        : fs::path(files.permissions).replace_extension("xml");
}

// ROS 2 uses such names, so they are only a warning: ddssec's plugins and Fast DDS distinguish
// them.
Status warn_of_overlap(const ParticipantSpec& spec, const CaPaths& identity, const fs::path& target,
                       WallTime now, Report& report) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(identity));
  const auto apart = SubjectsInUse(log, target, now).check(spec.subject);
  if (apart) return {};
  const auto& details = apart.error().details();
  report.findings.push_back(
      {.rule = Rule::PERM011,
       .message = fmt::format("{}: {}", details.found, details.note),
       .hint = "let participants run ddssec's plugins; or choose names of which none has all the "
               "parts of another",
       .products = {"cyclonedds"}});
  return {};
}

// The task of `keystore enclave`.
struct EnclaveJob {
  const Arguments& arguments;
  const Context& context;
  fs::path keystore;
  std::string name;
  fs::path target;
  bool is_again;  // the enclave exists, and gets a new key and certificate
  pki::ParticipantFolder files;
};

Result<EnclaveJob> enclave_job(const Arguments& arguments, const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  const auto name = arguments.text("ENCLAVE");
  DDSSEC_RETURN_IF_ERROR(check_enclave(name));
  if (name == "/") return fail(Code::enclave_name_unusable, {.found = name});
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  const auto target = keystore / enclave_folder(name);
  const auto files = pki::participant_folder(target, pki::FolderLayout::sros2);
  const bool is_again = arguments.has("--replace") && path_exists(target);
  if (path_exists(files.certificate) && !is_again)
    return fail(Code::would_overwrite,
                {.document = target,
                 .note = "the enclave exists",
                 .hint = "ddssec keystore permission gives it other rights; --replace issues it "
                         "again, with a new key"});
  DDSSEC_RETURN_IF_ERROR(check_nameable(target));
  if (is_again) {
    DDSSEC_RETURN_IF_ERROR(hold_folder(target));
    DDSSEC_RETURN_IF_ERROR(finish_interrupted(target));
  } else {
    DDSSEC_RETURN_IF_ERROR(open_guarded(target, O_PATH));  // refuses links of other users above it
  }
  if (is_again && files.key.extension() == ".p11")
    return fail(Code::key_in_token, {.document = files.key});
  return EnclaveJob{arguments, context, keystore, name, target, is_again, files};
}

// The permissions are for the name, which stays the same. The user decides whether they continue.
Result<std::string> kept_permissions_text(const EnclaveJob& job,
                                          const pki::Certificate& certificate) {
  const auto now = job.context.clock.calendar_seconds();
  const auto old = [&]() -> Result<SignedPermissions> {
    const auto ca = ca_paths(job.keystore, "permissions").certificate;
    DDSSEC_ASSIGN_OR_RETURN(const auto proof, verified(job.files.permissions, ca, now));
    DDSSEC_ASSIGN_OR_RETURN(auto out, own_permissions(proof, certificate, now));
    if (out.has_ended) return fail(Code::grant_expired, {.found = certificate.subject()});
    return out;
  }();
  if (old)
    return fmt::format("permissions.p7s stays, until {}\n", date(old->grant.validity.not_after));
  auto details = old.error().details();
  details.document = job.files.permissions;
  details.hint =
      "give its rights, too: --publish and --subscribe, or one of --permissions, --policy and "
      "--allow-all";
  return fail(old.error().code(), std::move(details));
}

// The log is written before the files, because a certificate that the log lacks cannot be revoked.
Result<std::vector<WrittenFile>> put_enclave(const EnclaveJob& job, EnclaveFolder& folder,
                                             const NewParticipant& made, const OpenCa& identity,
                                             const OpenCa* permissions) {
  const auto now = job.context.clock.calendar_seconds();
  DDSSEC_RETURN_IF_ERROR(add_enclave(folder, job.name, made));
  DDSSEC_ASSIGN_OR_RETURN(const auto list, list_for_newcomers(identity.paths, now));
  if (list) DDSSEC_RETURN_IF_ERROR(folder.add_public("crl.pem", list->pem()));
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(log_issued(identity.paths, log_line(made, job.target, now)));
  if (permissions != nullptr)
    DDSSEC_RETURN_IF_ERROR(
        log_signed(permissions->paths, signed_line(made, *permissions, job.target, now)));
  return folder.commit();
}

Result<Answer<MadeEnclave>> keystore_enclave(const Arguments& arguments, const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto job, enclave_job(arguments, context));
  DDSSEC_ASSIGN_OR_RETURN(const auto life, validity(arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto key, key_spec(arguments));
  ParticipantSpec spec{.name = job.name, .subject = "CN=" + job.name, .life = life, .key = key};
  Report report;
  DDSSEC_RETURN_IF_ERROR(
      read_rights(spec, arguments, job.is_again ? Rights::may_stay : Rights::needed, report));
  using Existing = EnclaveFolder::Existing;
  DDSSEC_ASSIGN_OR_RETURN(auto folder,
                          EnclaveFolder::at(job.keystore, job.target,
                                            job.is_again ? Existing::replaced : Existing::refused));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto identity, opener.open(ca_paths(job.keystore, "identity")));
  std::optional<OpenCa> permissions;
  if (spec.has_permissions()) {
    DDSSEC_ASSIGN_OR_RETURN(permissions, opener.open(ca_paths(job.keystore, "permissions")));
  }
  const auto* const signer = permissions ? &*permissions : nullptr;
  DDSSEC_ASSIGN_OR_RETURN(spec.life,
                          within_ca(spec.life, identity.certificate(), arguments.has("--clamp")));
  DDSSEC_RETURN_IF_ERROR(warn_of_overlap(spec, identity.paths, job.target, now, report));
  DDSSEC_ASSIGN_OR_RETURN(const auto made,
                          with_default_document(make_participant(spec, {identity, signer}, context),
                                                arguments.text("--permissions")));
  const auto& certificate = made.self.certificate;
  Answer<MadeEnclave> out{{.name = job.name,
                           .dir = job.target,
                           .subject = certificate.subject(),
                           .serial = certificate.serial(),
                           .not_after = certificate.not_after()}};
  out.report.findings = std::move(report.findings);
  DDSSEC_RETURN_IF_ERROR(warn_of_document(made.permissions_xml,
                                          shown_document(arguments, job.files),
                                          {.now = now, .certificate = &certificate}, out.report));
  if (signer == nullptr) {
    DDSSEC_ASSIGN_OR_RETURN(const auto kept, kept_permissions_text(job, certificate));
    out.report.text += kept;
  }
  if (job.is_again)
    out.report.text += former_certificate_text(job.files.certificate, job.keystore, now);
  out.report.text +=
      ros2_snippet(job.keystore, job.name, spec.domains) +
      fmt::format("# in the same terminal, ddssec doctor {} --ros checks these variables\n",
                  shell_word(job.target.string()));
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written,
                          put_enclave(job, folder, made, identity, signer));
  if (job.is_again) refresh_renewals(job.keystore, job.files, now, out.report);
  return out;
}

Result<Answer<ListedEnclaves>> keystore_list(const Arguments& arguments, const Context&) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  const auto enclaves = enclaves_of(keystore);
  Answer<ListedEnclaves> out{{enclaves.names}};
  add_unseen(enclaves, out.report);
  return out;
}

// This command has no option with which the user could name the participant.
Status check_of_enclave(const pki::Certificate& certificate, const fs::path& folder,
                        const fs::path& keystore, const std::string& name) {
  auto issued = check_issued_for(certificate, folder, ca_paths(keystore, "identity"));
  if (issued || (issued.error().code() != Code::certificate_of_another_folder &&
                 issued.error().code() != Code::certificate_unlogged))
    return issued;
  auto details = issued.error().details();
  details.hint = fmt::format(
      "put the enclave's own certificate back, or issue the enclave again: ddssec keystore enclave "
      "{} {} --replace, with its rights{}",
      shell_word(keystore.string()), name,
      issued.error().code() == Code::certificate_unlogged
          ? "; what sros2 issued, ddssec keystore import takes over"
          : "");
  return fail(issued.error().code(), std::move(details));
}

Result<Answer<SignedForEnclave>> keystore_permission(const Arguments& arguments,
                                                     const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  const auto name = arguments.text("ENCLAVE");
  DDSSEC_RETURN_IF_ERROR(check_enclave(name));
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  DDSSEC_RETURN_IF_ERROR(check_enclave_in(keystore, name));
  const auto files =
      pki::participant_folder(keystore / enclave_folder(name), pki::FolderLayout::sros2);
  DDSSEC_RETURN_IF_ERROR(hold_folder(files.folder));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(files.certificate));
  // The enclave's folder may have come back from its device, and the certificate in it decides
  // which subject gets the permissions, and until when.
  DDSSEC_RETURN_IF_ERROR(check_of_enclave(certificate, files.folder, keystore, name));
  ParticipantSpec spec{.name = name, .subject = {}, .life = {}};
  Report report;
  DDSSEC_RETURN_IF_ERROR(read_rights(spec, arguments, Rights::needed, report));
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto xml,
                          with_default_document(permissions_xml(spec, certificate, now),
                                                arguments.text("--permissions")));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open(ca_paths(keystore, "permissions")));
  DDSSEC_ASSIGN_OR_RETURN(const auto document,
                          sign_permissions(ca.authority, xml, now, context.random));
  DDSSEC_RETURN_IF_ERROR(warn_of_document(xml, shown_document(arguments, files),
                                          {.now = now, .certificate = &certificate}, report));
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(out.put_public(files.folder / "permissions.xml", xml));
  DDSSEC_RETURN_IF_ERROR(out.put(files.permissions, document, 0644));
  DDSSEC_RETURN_IF_ERROR(log_signed(ca, as_bytes(xml), files.permissions, now));
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, out.commit());
  return Answer<SignedForEnclave>{
      {name, files.permissions, certificate.subject(), ca.certificate().subject()},
      std::move(report)};
}

const Positional kKeystore{"KEYSTORE", "the keystore's folder"};
const Positional kEnclave{"ENCLAVE", "the enclave's name, such as /robot/camera"};

std::vector<Option> rights_options() {
  return {repeated("--domain", "N|A-B",
                   "a domain or a range of them; without it, the governance document's"),
          repeated("--publish", "TOPIC", "a topic or expression it may publish (rt/chatter)"),
          repeated("--subscribe", "TOPIC", "a topic or expression it may subscribe to"),
          {"--permissions", "FILE", "a permissions document to sign instead"},
          kOtherGrants,
          {"--policy", "FILE", "a ROS 2 policy (sros2), of which this enclave's part counts"},
          kNodeDefaults,
          {"--allow-all", "", "it may publish and subscribe to everything"},
          kPassphraseFile,
          kPassphraseEnv,
          kInsecureKeyMode};
}

std::vector<Option> with(std::vector<Option> options, const std::vector<Option>& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

std::vector<Command> keystore_commands() {
  return {
      {.group = "keystore",
       .name = "create",
       .summary = "Makes a keystore of ROS 2 with an identity CA and a permissions CA.",
       .positionals = {{"KEYSTORE", "a new folder"}},
       .options = {kDomains,
                   {"--profile", "NAME", "open, balanced or strict", "strict"},
                   {"--single-ca", "", "one CA for both, as sros2 makes it"},
                   days("3650"),
                   kPassphraseFile,
                   kPassphraseEnv,
                   kNoPassphrase},
       .examples = {"ddssec keystore create keystore --domain 0 --no-passphrase"},
       .run = keystore_create},
      {.group = "keystore",
       .name = "enclave",
       .summary = "Makes an enclave: key, certificate, permissions and the links.",
       .positionals = {kKeystore, kEnclave},
       .options = with({days("365"),
                        kKey,
                        {"--clamp", "", "end with the CA if it ends before"},
                        {"--replace", "",
                         "replace key and certificate of an enclave that is there; without "
                         "rights, it keeps its permissions; enclaves below it stay as they are"}},
                       rights_options()),
       .examples = {"ddssec keystore enclave keystore /talker --publish rt/chatter",
                    "ddssec keystore enclave keystore /talker --allow-all",
                    "ddssec keystore enclave keystore /talker --replace"},
       .run = keystore_enclave},
      {.group = "keystore",
       .name = "list",
       .summary = "Lists the enclaves.",
       .positionals = {kKeystore},
       .options = {},
       .examples = {"ddssec keystore list keystore"},
       .run = keystore_list},
      {.group = "keystore",
       .name = "permission",
       .summary = "Gives an enclave other permissions, in place of those that it has.",
       .positionals = {kKeystore, kEnclave},
       .options = rights_options(),
       .examples = {"ddssec keystore permission keystore /talker --policy policy.xml "
                    "--node-defaults",
                    "ddssec keystore permission keystore /talker --permissions new.xml"},
       .run = keystore_permission},
      {.group = "keystore",
       .name = "verify",
       .summary = "Looks at every enclave as doctor does; exit 1 if a product refuses one.",
       .positionals = {kKeystore},
       .options = {kDomainToCheck},
       .examples = {"ddssec keystore verify keystore"},
       .run = keystore_verify},
      {.group = "keystore",
       .name = "import",
       .summary = "Takes over a keystore of sros2: restricts its keys' file modes and records its "
                  "certificates.",
       .positionals = {kKeystore},
       .options = {},
       .examples = {"ddssec keystore import keystore"},
       .run = keystore_import}};
}

}  // namespace ddssec::cli
